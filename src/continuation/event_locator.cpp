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

constexpr double level = 1e-6;  // of the step: where so short a way lowers no value, these are rounding errors
constexpr double forward = 0.1; // least product of normal and tangent by which a cubic is led

struct Value {
  double along, f;
};

// Part of the way from `a` to `b`, on two sides of a zero, where to look next: by inverse quadratic interpolation with
// `c`, met before, where the three run evenly; else half way (Chandrupatla 1997, Advances in Engineering Software 28).
double next_part(const Value &a, const Value &b, const Value &c) {
  const double xi = (a.along - b.along) / (c.along - b.along), phi = (a.f - b.f) / (c.f - b.f);
  if (!(phi * phi < xi && (1 - phi) * (1 - phi) < 1 - xi)) return 0.5;
  return a.f / (b.f - a.f) * c.f / (b.f - c.f) +
         (c.along - a.along) / (b.along - a.along) * a.f / (c.f - a.f) * b.f / (c.f - b.f);
}

// An end of what is searched. A slope of 0: the tangent there, if known, leads too far astray.
struct End : Value {
  UniqueVec y, t;
  double slope = 0; // product of the normal and t
};

void place(End &end, const Curve &curve, Vec normal, const Bound &at) {
  end.along = at.along, end.f = at.value, end.slope = at.t ? curve.plane(normal, at.t) : 0;
  check(VecCopy(at.y, end.y), doing);
  if (!(end.slope > forward)) end.slope = 0;
  if (end.slope > 0) check(VecCopy(at.t, end.t), doing);
}

// On the cubic from one end to the other, or on the straight line.
void guess(const End &a, const End &b, double part, Vec y) {
  const double left = 1 - part, way = b.along - a.along;
  const bool straight = a.slope == 0 || b.slope == 0;
  check(VecCopy(a.y, y), doing);
  if (straight) return check(VecAXPBY(y, part, left, b.y), doing);
  check(VecAXPBY(y, part * part * (3 - 2 * part), left * left * (1 + 2 * part), b.y), doing);
  check(VecAXPBYPCZ(y, part * left * left * way / a.slope, -part * part * left * way / b.slope, 1, a.t, b.t), doing);
}

} // namespace

std::optional<Located> EventLocator::between(Vec normal, const Bound &from, const Bound &to, const Measured &f) const {
  const double tolerance = std::max(usual_tolerance, tolerance_),
               scale = std::max(std::abs(from.value), std::abs(to.value)), step = to.along - from.along;
  curve_.precisely(true);
  const std::shared_ptr<void> usual(nullptr, [&](void *) { curve_.precisely(false); });
  End a, b; // the last one, and the one on the other side
  for (UniqueVec *v : {&a.y, &a.t, &b.y, &b.t}) check(VecDuplicate(from.y, v->out()), doing); // no message
  place(a, curve_, normal, from), place(b, curve_, normal, to);
  Located found{a.along, curve_.point()};
  double part = a.f / (a.f - b.f);
  if (!(part > 0 && part < 1)) part = 0.5;
  for (int i = 0; i < most_solves; ++i) {
    const double least = std::min(0.5, tolerance * step / 2 / std::abs(b.along - a.along)), last = a.f;
    part = std::clamp(part, least, 1 - least);
    const double way = part * (b.along - a.along);
    guess(a, b, part, found.at.y);
    found.along = a.along + way;
    if (!curve_.solve_across(normal, found.at)) return std::nullopt;
    const double value = f(found.at);
    Value c = a;
    if ((value > 0) != (a.f > 0)) c = b, std::swap(a, b);
    place(a, curve_, normal, {found.along, found.at.y, value, found.at.t});
    const bool near = std::abs(b.along - a.along) <= tolerance * step,
               levelled = part != 0.5 && std::abs(way) <= level * step && std::abs(value) > std::abs(last) / 2;
    if (std::abs(value) <= tolerance * scale || near || levelled) break;
    part = next_part(a, b, c);
  }
  return found;
}

std::optional<Located> EventLocator::within(Vec normal, double step, std::array<double, 2> values,
                                            const Measured &f) const {
  return between(normal, {0, here_.y, values[0], here_.t}, {step, trial_.y, values[1], trial_.t}, f);
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
