#pragma once
// Time integration of a small model to its steady state: the way on where harmonic balance finds no solution, and the
// truth it is measured against.
#include <vector>

#include "harmonic/dense_model.hpp"

namespace dovetail {

struct SteadyState {
  bool settled = false;             ///< the last two periods agree
  int periods = 0;                  ///< integrated
  double change = 0;                ///< largest difference between the last two periods, relative to the largest motion
  std::vector<double> q, v;         ///< (n) motion and d/dt at the end of the last period, theta = 0
  std::vector<Memory> w;            ///< (points) sliders there
  std::vector<double> coefficients; ///< (n, 2H+1) of the last period
};

struct IntegrationSettings {
  int harmonics = 1;       ///< of `coefficients`
  int periods = 200;       ///< at most
  double tolerance = 1e-6; ///< of `change`
};

/// Integrates at `omega` from the periodic motion `start` (n, 2H+1 of any H; empty: rest in the preload state), the
/// sliders standing where that motion leaves them.
SteadyState steady_state(const DenseModel &model, double omega, const std::vector<double> &start,
                         const IntegrationSettings &settings);

} // namespace dovetail
