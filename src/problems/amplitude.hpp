#pragma once
// How far what is watched moves within the period, and how that changes along a curve. Amplitude: half the
// peak-to-peak.
#include <optional>
#include <vector>

#include "contact/wave_transform.hpp"
#include "continuation/between.hpp"
#include "problems/watched_row.hpp"
#include "stuck/layout.hpp"
#include "support/handle.hpp"

namespace dovetail {

/// What is watched. Neither of the two: the contact dof that moves most (the mode, without contact).
struct Watched {
  PetscInt dof = -1;                  ///< a reduced dof, modes first
  std::optional<WatchedRow> row = {}; ///< or a sum of reduced dofs, scaled, on every rank
};

/// The extremes of one trigonometric polynomial, not of samples of it.
class Swing {
public:
  explicit Swing(int harmonics);
  /// Instants of the largest and the smallest value, from coefficients [a0, a1, b1, ...].
  struct Extremes {
    double high, low;
  };
  Extremes extremes(const double *coefficients);
  /// Half the peak-to-peak.
  double amplitude(const double *coefficients);

private:
  double highest(const double *coefficients, double sign) const;

  int harmonics_;
  std::vector<double> values_, slopes_; // on a grid of instants
  WaveTransform grid_;
};

class AmplitudeMeter {
public:
  AmplitudeMeter(const Layout &layout, const Watched &watched);
  /// Half the peak-to-peak over the period, scaled, at y and along t. Collective.
  Amplitude operator()(Vec y, Vec t);

private:
  Amplitude of_row(const double *y, const double *t);
  Amplitude of_one(const double *coefficients, const double *along);

  const Layout &layout_;
  Watched watched_;
  int harmonics_;
  Swing swing_;
};

} // namespace dovetail
