#pragma once
// Parameters of the contact law (theory.md, section 5) at one contact point. Direction 0 is t1, 1 is t2.
#include <array>

namespace dovetail {

struct ContactPoint {
  double kn = 0;              ///< normal stiffness [N/m], > 0
  std::array<double, 2> kt{}; ///< tangential stiffness [N/m], > 0
  std::array<double, 2> mu{}; ///< friction coefficient [-], >= 0
  double gap = 0;             ///< x_n0, lift-off displacement [m]: closed where x_n > x_n0
};

/// Slider positions w [m]: the law's memory.
using Memory = std::array<double, 2>;

} // namespace dovetail
