#pragma once
// Where a slider all but begins to slip, or has just begun to: an edge that runs into it (slider.hpp) at its highest
// place. The derivative of the force jumps there, so that a maximum may lie in a corner of the response.
#include <vector>

#include "contact/contact_point.hpp"

namespace dovetail {

struct Graze {
  int direction = 0, side = 0; ///< t1 or t2; the sense of the slip, +1 or -1
  double theta = 0;            ///< where the edge is highest
  double height = 0;           ///< of the edge over the slider as it was before [N]; negative: it does not slip there
  double size = 0;             ///< what that is measured by [N]
  std::vector<double> by_t, by_n; ///< (2H+1) its derivative by the motion in that direction, and in n
};

} // namespace dovetail
