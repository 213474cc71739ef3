#include "continuation/event_locator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "continuation/step_control.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "locating an event";
constexpr double usual_tolerance = 1e-8; // of the step, and of the measured quantity, unless Newton's is larger
constexpr int most_solves = 80;
constexpr std::array branch_parts{0.5, 0.3, 0.7}; // of an interval, in turn: at the place itself none is found
constexpr double back_missed = 0.1;               // part of a correction, by which the way back along a curve may miss
constexpr double least_missed = 1e-3;             // of the step: smaller corrections tell nothing
constexpr double least_sine_squared = 1e-3;       // of the angle between lines that can be said to meet

} // namespace

std::optional<Located> EventLocator::between(Vec normal, Bound from, Bound to, const Measured &f) const {
  const double tolerance = std::max(usual_tolerance, tolerance_),
               scale = std::max(std::abs(from.value), std::abs(to.value)), step = to.along - from.along;
  curve_.precisely(true);
  const std::shared_ptr<void> usual(nullptr, [&](void *) { curve_.precisely(false); });
  double a = from.along, b = to.along, fa = from.value, fb = to.value;
  UniqueVec ya, yb; // to lay out new ones would take messages
  check(VecDuplicate(from.y, ya.out()), doing);
  check(VecDuplicate(to.y, yb.out()), doing);
  check(VecCopy(from.y, ya), doing);
  check(VecCopy(to.y, yb), doing);
  Located place{a, curve_.point()};
  double before = b - a;
  int last_side = 0;
  for (int i = 0; i < most_solves; ++i) {
    double part = fa / (fa - fb);
    if (!std::isfinite(part) || (i % 3 == 2 && b - a > before / 2)) part = 0.5;
    if (i % 3 == 2) before = b - a;
    check(VecWAXPY(place.at.y, -1, ya, yb), doing);
    check(VecAYPX(place.at.y, part, ya), doing);
    place.along = a + part * (b - a);
    if (!curve_.solve_across(normal, place.at)) return std::nullopt;
    const double value = f(place.at);
    if (std::abs(value) <= tolerance * scale || b - a <= tolerance * step) return place;
    const int side = (value > 0) == (fa > 0) ? -1 : 1;
    if (side < 0) {
      a = place.along, fa = value;
      check(VecCopy(place.at.y, ya), doing);
      if (last_side == side) fb /= 2; // Illinois
    } else {
      b = place.along, fb = value;
      check(VecCopy(place.at.y, yb), doing);
      if (last_side == side) fa /= 2;
    }
    last_side = side;
  }
  return place;
}

// Planes across the direction between both tangents meet the curve once; from the kink on, which is near where the
// tangents meet, it is near the straight line to either end.
std::optional<Located> EventLocator::in_kink(double step, std::array<double, 2> values, const Measured &f) const {
  const double ahead = meeting(curve_, here_, trial_).ahead;
  if (!(ahead > 0)) return std::nullopt;
  UniqueVec normal = curve_.problem.unknowns(), guess = curve_.problem.unknowns();
  check(VecWAXPY(normal, 1, here_.t, trial_.t), doing);
  check(VecScale(normal, 1 / curve_.norm.length(normal)), doing);
  check(VecWAXPY(guess, ahead, here_.t, here_.y), doing);
  const auto near = [&](Vec y, Vec from) { // else it is a solution of another branch
    const UniqueVec way = curve_.problem.unknowns();
    check(VecWAXPY(way, -1, from, y), doing);
    return curve_.norm.length(way) < step_limits.most_correction * ahead;
  };
  CurvePoint kink = curve_.point();
  check(VecCopy(guess, kink.y), doing);
  if (!curve_.solve_across(normal, kink, {false, step_limits.most_newton, ahead}) || !near(kink.y, guess))
    return std::nullopt;
  const double here = curve_.plane(normal, here_.y), there = curve_.plane(normal, kink.y) - here,
               end = curve_.plane(normal, trial_.y) - here, value = f(kink);
  if (!(0 < there && there < end)) return std::nullopt;
  const Bound middle{there, kink.y, value};
  std::optional<Located> place = value * values[0] < 0 ? between(normal, {0, here_.y, values[0]}, middle, f)
                                                       : between(normal, middle, {end, trial_.y, values[1]}, f);
  if (!place || !near(place->at.y, kink.y)) return std::nullopt;
  place->along *= step / end;
  return place;
}

bool EventLocator::leads_back(double step, double missed) const {
  CurvePoint back = curve_.point();
  check(VecWAXPY(back.y, -step, trial_.t, trial_.y), doing);
  if (!curve_.solve_across(trial_.t, back)) return false;
  check(VecAXPY(back.y, -1, here_.y), doing);
  const double distance = curve_.norm.length(back.y), along = curve_.norm.product(back.y, here_.t);
  return std::sqrt(std::max(0.0, distance * distance - along * along)) <
         back_missed * std::max(missed, least_missed * step);
}

std::optional<Located> EventLocator::branch_point(double step) const {
  UniqueVec ya = curve_.problem.unknowns(), yb = curve_.problem.unknowns();
  check(VecCopy(here_.y, ya), doing);
  check(VecCopy(trial_.y, yb), doing);
  Located place = located_at(curve_, trial_, step), middle{step, curve_.point()};
  double a = 0, b = step;
  const auto found_at = [&](double part) {
    check(VecWAXPY(middle.at.y, -1, ya, yb), doing);
    check(VecAYPX(middle.at.y, part, ya), doing);
    middle.along = a + part * (b - a);
    return curve_.solve_across(here_.t, middle.at) && angle(curve_.norm, here_.t, middle.at.t) <= step_limits.straight;
  };
  while (b - a > usual_tolerance * step) {
    if (std::none_of(branch_parts.begin(), branch_parts.end(), found_at)) break;
    (middle.at.sign == here_.sign ? a : b) = middle.along;
    check(VecCopy(middle.at.y, middle.along == a ? ya : yb), doing);
    std::swap(place, middle);
  }
  if (b - a > step / 2) return std::nullopt; // not even halved
  check(VecAXPY(yb, -1, ya), doing);
  const double length = curve_.norm.length(yb), aside = std::sqrt(std::max(0.0, length * length - (b - a) * (b - a)));
  if (aside > std::max(std::tan(step_limits.straight) * (b - a), least_missed * step)) return std::nullopt;
  return place;
}

Meeting meeting(const Curve &curve, const CurvePoint &here, const CurvePoint &other) {
  const ArcLengthMetric &norm = curve.norm;
  const UniqueVec between = curve.problem.unknowns();
  check(VecWAXPY(between, -1, here.y, other.y), doing);
  const double cosine = norm.product(here.t, other.t), a = norm.product(between, here.t),
               b = norm.product(between, other.t), apart = 1 - cosine * cosine;
  Meeting at{(a - cosine * b) / apart, (b - cosine * a) / apart, 0};
  if (!(apart > least_sine_squared && at.ahead >= 0)) at = {0, b, 0}; // as near to here as can be
  check(VecAXPBYPCZ(between, -at.ahead, -at.back, 1, here.t, other.t), doing);
  at.miss = norm.length(between);
  return at;
}

Located located_at(const Curve &curve, const CurvePoint &s, double along) {
  Located place{along, curve.point()};
  check(VecCopy(s.y, place.at.y), doing);
  check(VecCopy(s.t, place.at.t), doing);
  place.at.sign = s.sign, place.at.parameter = s.parameter;
  place.at.newton = s.newton, place.at.data = s.data;
  return place;
}

} // namespace dovetail
