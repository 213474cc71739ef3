#pragma once
// Time integration of a small model to its steady state: the way on where harmonic balance finds no solution, and the
// truth it is measured against.
#include <vector>

#include "transient/flow.hpp"

namespace dovetail {

struct SteadyState {
  bool settled = false; ///< the last two periods agree, and so would all to come, to the tolerance
  int periods = 0;      ///< integrated, those of shooting included
  double work = 0;      ///< that it took, as IntegrationSettings::work
  double change = 0; ///< largest difference between the last two periods, each dof relative to its own motion; motions
                     ///< below 1e-4 of the largest mode or contact dof count as that large
  /// Largest modulus of the multipliers where the motion was found by shooting, else 0. Beyond 1 it is unstable: a
  /// march would not arrive at it. The 1 of sliders that stick all the time is left out.
  double multiplier = 0;
  bool opens = false;               ///< a contact that can, in the last period
  MotionState end;                  ///< of the last period, theta = 0
  std::vector<double> coefficients; ///< (n, 2H+1) of the last period
  std::vector<double> amplitude;    ///< (n) largest |q - mean| over the last period, from its course in time
};

struct IntegrationSettings {
  int harmonics = 1;       ///< of `coefficients`
  int periods = 200;       ///< at most, those of shooting included
  double tolerance = 1e-6; ///< of `change`, and of what is left to come
  double work = 2e10;      ///< multiplications at most, roughly: some tenths of a second
};

/// Integrates at `omega` from the periodic motion `start` (n, 2H+1 of any H; empty: rest in the preload state), the
/// sliders standing where that motion leaves them. Marches; where that takes long, shooting finds the periodic motion
/// nearby. From rest an unstable one is the answer only if no other is found. Whatever happens, it ends: where numbers
/// run away, or periods or work are used up, with settled = false and the last motion. The same on every rank.
SteadyState steady_state(const DenseModel &model, double omega, const std::vector<double> &start,
                         const IntegrationSettings &settings);
/// From theta = 0 of a motion.
SteadyState steady_state_from(const DenseModel &model, double omega, const MotionState &start,
                              const IntegrationSettings &settings);

} // namespace dovetail
