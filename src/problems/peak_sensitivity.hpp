#pragma once
// What a peak of the response depends on: derivatives of its amplitude and of its frequency by the contact parameters
// of every point, the load and the preload, from a few solves with one Jacobian and its transpose.
#include <optional>

#include "harmonic/harmonic_system.hpp"
#include "problems/amplitude.hpp"

namespace dovetail {

/// Derivatives of one number at the peak, scaled.
struct PeakSlope {
  std::vector<ByParameter> points;            ///< (own)
  double force = 0, preload = 0, damping = 0; ///< by factors on them
};

struct PeakSensitivity {
  double omega = 0;     ///< of the peak, scaled
  double amplitude = 0; ///< sqrt(sum over k >= 1 of a_k^2 + b_k^2) of what is watched, scaled
  PeakSlope amplitude_by, omega_by;
};

/// At the maximum over Omega of that amplitude next to y = [X; Omega], a point of a response curve. Nothing where no
/// smooth maximum is near: it lies in a corner, or is not one. Memories w_p of points that slip in the preload count as
/// fixed. Collective.
std::optional<PeakSensitivity> peak_sensitivity(const HarmonicSystem &system, Vec y, const Watched &watched);

} // namespace dovetail
