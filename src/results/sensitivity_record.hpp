#pragma once
// Derivatives at a peak, in user units: one row of /sensitivity.
#include <vector>

#include "problems/peak_sensitivity.hpp"

namespace dovetail {

struct SlopeRecord {
  std::vector<double> normal_stiffness, gap;          ///< (N_x)
  std::vector<double> tangential_stiffness, friction; ///< (N_x, 2)
  double force = 0, preload = 0, damping = 0;         ///< by factors on them
};

/// Complete on rank 0 only.
struct SensitivityRecord {
  int point = 0;    ///< of the curve, at which the peak was located
  double omega = 0; ///< [rad/s]
  double amplitude = 0;
  SlopeRecord amplitude_by, omega_by;
};

/// `unit`: of the watched unknown's amplitude. Collective.
SensitivityRecord collect(const PeakSensitivity &peak, const HarmonicSystem &system, double unit, int point);

} // namespace dovetail
