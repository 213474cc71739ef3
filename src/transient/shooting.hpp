#pragma once
// Periodic motion as a fixed point of one period's flow, found by Newton's method: where damping is weak, thousands of
// periods pass before a march arrives there.
#include "transient/period_map.hpp"

namespace dovetail {

struct Orbit {
  bool found = false;
  double nearer = 1; ///< what a period changes there, over what it changed at the start
  Flow::State state; ///< at theta = 0; the nearest that was seen if none is found
  int periods = 0;   ///< integrated on the way
  /// Largest modulus of the multipliers of the motion, that of stuck sliders, which is 1, left out. Beyond 1 a march
  /// leaves the motion.
  double multiplier = 0;
};

/// The periodic motion near `start`, to `tolerance` relative to its size, within that many periods. A slider that
/// sticks all the time keeps its place. far: any periodic motion, for a start that is not rest; with a small model
/// then by the whole derivative of the period map, which takes as long as a few periods.
Orbit periodic_orbit(Flow &flow, const Flow::State &start, double tolerance, int periods, bool far);

/// The motion near y: by GMRES the derivative is needed in a few directions only, one period integrated
/// for each, because most of the motion forgets within a period where it began.
Orbit krylov_orbit(PeriodMap &map, Numbers y, double tolerance);

} // namespace dovetail
