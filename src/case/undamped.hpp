#pragma once
// Whether a case has any damping of its structure.
#include <algorithm>

#include "case/damping.hpp"

namespace dovetail {

inline bool undamped(const Damping &damping) {
  return damping.stiffness == 0 && damping.mass == 0 && damping.structural == 0 && !damping.matrix &&
         std::all_of(damping.ratios.begin(), damping.ratios.end(), [](const ModeRatio &one) { return one.ratio == 0; });
}

} // namespace dovetail
