#pragma once
// What surrounds the derivative by the motion in the Jacobian of a nonlinear mode: columns Om, zeta, lam, and rows of
// the length and the phase of Psi_1 and of the plane that a step ends on.
#include "problems/border.hpp"
#include "problems/nonlinear_mode.hpp"

namespace dovetail {

class ModeBorder : public Border<NonlinearMode::extra> {
public:
  static constexpr int width = NonlinearMode::extra;
  using Border::Border;
  /// At the point of the mode evaluated last; `plane` (unknowns). Collective.
  void take(const NonlinearMode &mode, Vec plane);

private:
  std::vector<double> swinging_, along_; // motion of the own contact dofs without means, and G' times it
};

} // namespace dovetail
