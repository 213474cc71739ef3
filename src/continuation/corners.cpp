// Round a corner of the curve, where a contact lifts off, lands or begins to slip.
#include <algorithm>
#include <cmath>

#include "continuation/follower.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "looking round a corner";
constexpr double least_apart = 1e-3; // squared sine of the angle between lines that can be said to meet

} // namespace

// At a corner the leg beyond may make more than a right angle with this one: then no plane across the old tangent
// meets it, however near. The Jacobian beyond the corner knows its tangent, and the sign of the determinant, which
// stays the same along the curve, on which side of the corner it lies. Where parts of the structure are alike, several
// contacts change at once, other branches may meet here, and the sign tells nothing: close to the corner the other side
// is tried as well, and taken unless it is the leg we came by. Far along the leg Newton's method takes many iterations:
// not where they are dear.
bool Follower::round_corner(double step, Extent extent, Go &outcome) {
  UniqueVec beyond = system_->unknowns(), t = system_->unknowns();
  for (const bool by_sign : {true, false}) {
    if (!by_sign && extent == Extent::first) break;
    if (by_sign ? here_.sign == 0 : step > close_to_corner) continue;
    std::vector<UniqueVec> tried;
    for (const double ahead : {1.0, 4.0, 0.25, 16.0, 64.0, 0.02}) {
      int sign;
      check(VecWAXPY(beyond, ahead * step, here_.t, here_.y), doing);
      if (!curve_->tangent_at(beyond, here_.t, t, sign)) continue;
      if ((sign != here_.sign) == by_sign) check(VecScale(t, -1), doing);
      const auto alike = [&](const UniqueVec &other) { return curve_->norm.product(t, other) > 0.999; };
      if (curve_->norm.product(t, here_.t) > 0.9 || std::any_of(tried.begin(), tried.end(), alike)) continue;
      tried.push_back(system_->unknowns());
      check(VecCopy(t, tried.back()), doing);
      for (const double part : {1.0, 0.1, 8.0}) {
        if (part > 1 && dear()) break;
        if ((ahead <= 4 || part < 1) && go_round(t, part * step, by_sign, outcome)) return true;
        if (extent == Extent::first) return false;
      }
    }
  }
  return false;
}

// The leg that runs in direction t from the last point, or near it: to a point close to where it begins.
bool Follower::go_round(Vec t, double step, bool by_sign, Go &outcome) {
  check(VecWAXPY(trial_.y, step, t, here_.y), doing);
  check(VecCopy(trial_.y, predicted_), doing);
  if (!(system_->omega(trial_.y) > 0) || !curve_->solve_across(t, trial_, {false, most_newton, step})) return false;
  check(VecAXPY(predicted_, -1, trial_.y), doing);
  if (curve_->norm.length(predicted_) > most_correction * step || angle(curve_->norm, t, trial_.t) > most_angle)
    return false;
  const double turned = angle(curve_->norm, here_.t, trial_.t), from = here_.omega;
  if (by_sign ? trial_.sign != here_.sign : M_PI - turned < std::max(0.01, 4 * curvature_ * step)) return false;
  branch_point_.reset();
  if (turned < straight) { // no corner: this leg, only hard to meet across its tangent
    check(VecWAXPY(predicted_, -1, here_.y, trial_.y), doing);
    check(VecScale(predicted_, 1 / curve_->norm.length(predicted_)), doing);
    if (angle(curve_->norm, here_.t, predicted_) > turned + allowed_astray()) return false; // another one beside it
    outcome = accept_step(t, step);
  } else {
    Station corner = curve_->station();
    if (!back_to_corner(corner)) return false;
    std::swap(trial_, corner);
    check(VecWAXPY(predicted_, -1, here_.y, trial_.y), doing);
    const int folds = summary_.counts.folds;
    outcome = accept_step(here_.t, curve_->norm.length(predicted_), true);
    if (outcome == Go::refused) return false;
    ++summary_.counts.corners;
    if (summary_.counts.folds == folds) note_bend(from); // else it is one already
    notify(BranchEvent::Kind::corner,
           "corner of the curve, turning by " + std::to_string(std::lround(turned * 180 / M_PI)) + " degrees", from);
  }
  if (outcome == Go::on) step_ = step, limit_step();
  return outcome != Go::refused;
}

Follower::Meeting Follower::meeting(const Station &other) const {
  const ArcNorm &norm = curve_->norm;
  const UniqueVec between = system_->unknowns();
  check(VecWAXPY(between, -1, here_.y, other.y), doing);
  const double cosine = norm.product(here_.t, other.t), a = norm.product(between, here_.t),
               b = norm.product(between, other.t), apart = 1 - cosine * cosine;
  Meeting at{(a - cosine * b) / apart, (b - cosine * a) / apart, 0};
  if (!(apart > least_apart && at.ahead >= 0)) at = {0, b, 0}; // as near to here_ as can be
  check(VecAXPBYPCZ(between, -at.ahead, -at.back, 1, here_.t, other.t), doing);
  at.miss = norm.length(between);
  return at;
}

// A point close to the beginning of the leg on which trial_ lies, if it is one that begins where the old one ends: a
// step back along it converges, and from there the lines along both tangents all but meet, ahead of here_. Else it is
// some other leg nearby, or one of a loop that would be cut off.
bool Follower::back_to_corner(Station &corner) {
  const double back = meeting(trial_).back;
  const auto step_back = [&](double part) {
    check(VecWAXPY(corner.y, -part * back, trial_.t, trial_.y), doing);
    return curve_->solve_across(trial_.t, corner, {false, most_newton, part * back}) && corner.sign == trial_.sign &&
           angle(curve_->norm, corner.t, trial_.t) < most_angle;
  };
  if (!(back > 0) || !(step_back(0.8) || step_back(0.5))) return false;
  const Meeting at = meeting(corner);
  return at.miss < most_miss * (at.ahead + std::abs(at.back));
}

} // namespace dovetail
