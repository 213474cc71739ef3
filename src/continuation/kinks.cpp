// Round a kink of the curve, as where a contact lifts off, lands or begins to slip.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "continuation/stepper.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "looking round a kink";
constexpr double aheads[] = {1.0, 4.0, 0.25, 16.0, 64.0, 0.02}; // steps along the tangent, where the other leg is felt
constexpr double parts[] = {1.0, 0.1, 8.0};                     // of a step, along the other leg
constexpr double farthest_with_whole_steps = 4;                 // of `aheads`
constexpr double alike_cosine = 0.999;                          // of legs that are the same
constexpr double not_turned_cosine = 0.9;                       // of a leg that is no other
constexpr double least_short_of_back = 0.01; // [rad], by which a leg must differ from the one that led here,
constexpr double curvatures_short = 4;       // or by so many times what the curve turns in a step
constexpr double steps_back[] = {0.8, 0.5};  // of the way to where the tangents meet

} // namespace

// At a kink the leg beyond may make more than a right angle with this one: then no plane across the old tangent
// meets it, however near. The Jacobian beyond the kink knows its tangent, and the sign of the determinant, which
// stays the same along the curve, on which side of the kink it lies. Where parts of the structure are alike, several
// contacts change at once, other branches may meet here, and the sign tells nothing: close to the kink the other side
// is tried as well, and taken unless it is the leg we came by. Far along the leg Newton's method takes many iterations:
// not where they are dear.
bool Stepper::round_kink(double step, Extent extent, Outcome &outcome) {
  if (here_.sign != 0 && try_legs(step, true, extent, outcome)) return true;
  return extent == Extent::all && step <= step_limits.close_to_kink && try_legs(step, false, extent, outcome);
}

// Those on the side of the kink that the sign tells, or on the other one; of what looks alike the first only.
bool Stepper::try_legs(double step, bool by_sign, Extent extent, Outcome &outcome) {
  UniqueVec beyond = curve_->problem.unknowns(), t = curve_->problem.unknowns();
  std::vector<UniqueVec> tried;
  const auto alike = [&](const UniqueVec &other) { return curve_->norm.product(t, other) > alike_cosine; };
  for (const double ahead : aheads) {
    int sign;
    check(VecWAXPY(beyond, ahead * step, here_.t, here_.y), doing);
    if (!curve_->tangent_at(beyond, here_.t, t, sign)) continue;
    if ((sign != here_.sign) == by_sign) check(VecScale(t, -1), doing);
    if (curve_->norm.product(t, here_.t) > not_turned_cosine || std::any_of(tried.begin(), tried.end(), alike))
      continue;
    tried.push_back(curve_->problem.unknowns());
    check(VecCopy(t, tried.back()), doing);
    for (const double part : parts) {
      if (part > 1 && iterations_are_expensive()) break;
      if ((ahead <= farthest_with_whole_steps || part < 1) && go_round(t, part * step, by_sign, outcome)) return true;
      if (extent == Extent::first) return false;
    }
  }
  return false;
}

// The leg that runs in direction t from the last point, or near it: to a point close to where it begins.
bool Stepper::go_round(Vec t, double step, bool by_sign, Outcome &outcome) {
  const double sharp = std::max(least_short_of_back, curvatures_short * curvature_ * step);
  check(VecWAXPY(trial_.y, step, t, here_.y), doing);
  check(VecCopy(trial_.y, predicted_), doing);
  if (!curve_->problem.is_admissible(parameter_of(trial_.y)) ||
      !curve_->solve_across(t, trial_, {false, step_limits.most_newton, step}))
    return false;
  check(VecAXPY(predicted_, -1, trial_.y), doing);
  if (curve_->norm.length(predicted_) > step_limits.most_correction * step ||
      angle(curve_->norm, t, trial_.t) > step_limits.most_angle)
    return false;
  const double turned = angle(curve_->norm, here_.t, trial_.t), from = here_.parameter;
  if (by_sign ? trial_.sign != here_.sign : M_PI - turned < sharp) return false;
  branch_point_.reset();
  if (turned < step_limits.straight) { // no kink: this leg, only hard to meet across its tangent
    check(VecWAXPY(predicted_, -1, here_.y, trial_.y), doing);
    check(VecScale(predicted_, 1 / curve_->norm.length(predicted_)), doing);
    if (angle(curve_->norm, here_.t, predicted_) > turned + allowed_astray()) return false; // another one beside it
    outcome = accept_step(t, step);
  } else {
    CurvePoint kink = curve_->point();
    if (!back_to_kink(kink)) return false;
    std::swap(trial_, kink);
    check(VecWAXPY(predicted_, -1, here_.y, trial_.y), doing);
    outcome = accept_step(here_.t, curve_->norm.length(predicted_), true);
    if (outcome == Outcome::refused) return false;
    turned_kink(turned, from);
  }
  if (outcome == Outcome::on) {
    control_.set(step);
    limit_step();
  }
  return outcome != Outcome::refused;
}

// A point close to the beginning of the leg on which trial_ lies, if it is one that begins where the old one ends: a
// step back along it converges, and from there the lines along both tangents all but meet, ahead of here_. Else it is
// some other leg nearby, or one of a loop that would be cut off.
bool Stepper::back_to_kink(CurvePoint &kink) {
  const double back = meeting(*curve_, here_, trial_).back;
  const auto step_back = [&](double part) {
    check(VecWAXPY(kink.y, -part * back, trial_.t, trial_.y), doing);
    return curve_->solve_across(trial_.t, kink, {false, step_limits.most_newton, part * back}) &&
           kink.sign == trial_.sign && angle(curve_->norm, kink.t, trial_.t) < step_limits.most_angle;
  };
  if (!(back > 0) || std::none_of(std::begin(steps_back), std::end(steps_back), step_back)) return false;
  const Meeting at = meeting(*curve_, here_, kink);
  return at.miss < step_limits.most_miss * (at.ahead + std::abs(at.back));
}

} // namespace dovetail
