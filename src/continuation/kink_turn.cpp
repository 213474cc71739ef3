#include "continuation/kink_turn.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "continuation/event_locator.hpp"
#include "continuation/step_control.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "looking round a kink";
constexpr double aheads[] = {1.0, 4.0, 0.25, 16.0, 64.0, 0.02}; // steps along the tangent, where the other leg is felt
constexpr double parts[] = {1.0, 0.1, 8.0};                     // of a step, along the other leg
constexpr double alike_cosine = 0.999;                          // of legs that are the same
constexpr double least_short_of_back = 0.01; // [rad], by which a leg must differ from the one that led here,
constexpr double curvatures_short = 4;       // or by so many times what the curve turns in a step
constexpr double steps_back[] = {0.8, 0.5};  // of the way to where the tangents meet

} // namespace

KinkTurn::KinkTurn(Curve &curve, const CurvePoint &here, CurvePoint &trial, double curvature, bool expensive, Take take)
    : curve_(curve), here_(here), trial_(trial), curvature_(curvature), expensive_(expensive), take_(std::move(take)),
      way_(curve.problem.unknowns()) {}

// At a kink the leg beyond may make more than a right angle with this one: then no plane across the old tangent
// meets it, however near. The Jacobian beyond the kink knows its tangent, and the sign of the determinant, which
// stays the same along the curve, on which side of the kink it lies. Where parts of the structure are alike, several
// contacts change at once, other branches may meet here, and the sign tells nothing: close to the kink the other side
// is tried as well, and taken unless it is the leg we came by. Far along the leg Newton's method takes many iterations:
// not where they are dear.
bool KinkTurn::turn(double step) {
  if (here_.sign != 0 && try_legs(step, true)) return true;
  return step <= step_limits.close_to_kink && try_legs(step, false);
}

// Those on the side of the kink that the sign tells, or on the other one; of what looks alike the first only.
bool KinkTurn::try_legs(double step, bool by_sign) {
  UniqueVec beyond = curve_.problem.unknowns(), t = curve_.problem.unknowns();
  std::vector<UniqueVec> tried;
  const auto alike = [&](const UniqueVec &other) { return curve_.norm.product(t, other) > alike_cosine; };
  for (const double ahead : aheads) {
    int sign;
    check(VecWAXPY(beyond, ahead * step, here_.t, here_.y), doing);
    if (!curve_.tangent_at(beyond, here_.t, t, sign)) continue;
    if ((sign != here_.sign) == by_sign) check(VecScale(t, -1), doing);
    if (angle(curve_.norm, t, here_.t) < step_limits.straight || std::any_of(tried.begin(), tried.end(), alike))
      continue;
    tried.push_back(curve_.problem.unknowns());
    check(VecCopy(t, tried.back()), doing);
    for (const double part : parts) {
      if (part > 1 && expensive_) break;
      if (go_round(t, part * step, by_sign)) return true;
    }
  }
  return false;
}

// The leg that runs in direction t from the last point, or near it: to a point close to where it begins.
bool KinkTurn::go_round(Vec t, double step, bool by_sign) {
  check(VecWAXPY(trial_.y, step, t, here_.y), doing);
  check(VecCopy(trial_.y, way_), doing);
  if (!curve_.problem.is_admissible(parameter_of(trial_.y)) ||
      !curve_.solve_across(t, trial_, {false, step_limits.most_newton, step}))
    return false;
  check(VecAXPY(way_, -1, trial_.y), doing);
  if (curve_.norm.length(way_) > step_limits.most_correction * step ||
      angle(curve_.norm, t, trial_.t) > step_limits.kink_angle)
    return false;
  const double turned = angle(curve_.norm, here_.t, trial_.t),
               sharp = std::max(least_short_of_back, curvatures_short * curvature_ * step);
  if (by_sign ? trial_.sign != here_.sign : M_PI - turned < sharp) return false;
  if (turned < step_limits.straight) return !is_beside(turned) && take_({t, step, step, turned, false});
  CurvePoint kink = curve_.point();
  if (!back_to_kink(kink)) return false;
  std::swap(trial_, kink);
  check(VecWAXPY(way_, -1, here_.y, trial_.y), doing);
  return take_({here_.t, curve_.norm.length(way_), step, turned, true});
}

// Whether the leg to trial_ is no leg but another piece of the curve, beside this one.
bool KinkTurn::is_beside(double turned) {
  check(VecWAXPY(way_, -1, here_.y, trial_.y), doing);
  check(VecScale(way_, 1 / curve_.norm.length(way_)), doing);
  return angle(curve_.norm, here_.t, way_) > turned + aims_of(curve_.problem.is_smooth()).astray;
}

// A point close to the beginning of the leg on which trial_ lies, if it is one that begins where the old one ends: a
// step back along it converges, and from there the lines along both tangents all but meet, ahead of here_. Else it is
// some other leg nearby, or one of a loop that would be cut off.
bool KinkTurn::back_to_kink(CurvePoint &kink) {
  const double back = meeting(curve_, here_, trial_).back;
  const auto step_back = [&](double part) {
    check(VecWAXPY(kink.y, -part * back, trial_.t, trial_.y), doing);
    return curve_.solve_across(trial_.t, kink, {false, step_limits.most_newton, part * back}) &&
           kink.sign == trial_.sign && angle(curve_.norm, kink.t, trial_.t) < step_limits.kink_angle;
  };
  if (!(back > 0) || std::none_of(std::begin(steps_back), std::end(steps_back), step_back)) return false;
  const Meeting at = meeting(curve_, here_, kink);
  return at.miss < step_limits.most_off * (at.ahead + std::abs(at.back));
}

} // namespace dovetail
