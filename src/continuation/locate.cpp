// Where on the curve something happens within a step: found by solving on planes in between.
#include <algorithm>
#include <cmath>
#include <utility>

#include "continuation/follower.hpp"

namespace dovetail {
namespace {

constexpr double place_tolerance = 1e-8; // of the step, and of the measured quantity, unless Newton's is larger
constexpr double place_in_time = 1e-7;   // arc length, likewise

} // namespace

// The solution on the plane across `normal`, so far along it from here_; s.y: a guess.
bool Follower::solve_within(Vec normal, double along, Station &s, const StepEffort &effort) {
  return orbit_ ? show_if(orbit_->between(along), s) : curve_->solve_across(normal, s, effort);
}

// Where f passes zero: regula falsi on planes across `normal`, halving the interval where that is slow, for f may jump
// at a corner of the curve. Nothing if Newton fails in between.
std::optional<Follower::Place> Follower::locate(Place::Kind kind, Vec normal, Bound from, Bound to, const Measured &f) {
  const double scale = std::max(std::abs(from.value), std::abs(to.value)), step = to.along - from.along,
               tolerance = orbit_ ? std::max(place_tolerance, place_in_time / step)
                                  : std::max(place_tolerance, newton_.step_tolerance);
  curve_->precisely(true);
  const std::shared_ptr<void> usual(nullptr, [&](void *) { curve_->precisely(false); });
  double a = from.along, b = to.along, fa = from.value, fb = to.value;
  UniqueVec ya = system_->unknowns(), yb = system_->unknowns();
  check(VecCopy(from.y, ya), "locating a place");
  check(VecCopy(to.y, yb), "locating a place");
  Place place{0, kind, curve_->station()};
  double before = b - a;
  int last_side = 0;
  for (int i = 0; i < 80; ++i) {
    double part = fa / (fa - fb);
    if (!std::isfinite(part) || (i % 3 == 2 && b - a > before / 2)) part = 0.5;
    if (i % 3 == 2) before = b - a;
    part = std::clamp(part, 0.01, 0.99);
    check(VecWAXPY(place.at.y, -1, ya, yb), "locating a place");
    check(VecAYPX(place.at.y, part, ya), "locating a place");
    const double x = a + part * (b - a);
    if (!solve_within(normal, x, place.at)) return std::nullopt;
    const double fx = f(place.at);
    place.along = x;
    if (std::abs(fx) <= tolerance * scale || b - a <= tolerance * step) return place;
    const int side = (fx > 0) == (fa > 0) ? -1 : 1;
    if (side < 0) {
      a = x, fa = fx;
      check(VecCopy(place.at.y, ya), "locating a place");
      if (last_side == side) fb /= 2; // Illinois
    } else {
      b = x, fb = fx;
      check(VecCopy(place.at.y, yb), "locating a place");
      if (last_side == side) fa /= 2;
    }
    last_side = side;
  }
  return place;
}

Follower::Place Follower::place_at(const Station &s, Place::Kind kind, double along) {
  Place place{along, kind, curve_->station()};
  check(VecCopy(s.y, place.at.y), "locating a place");
  check(VecCopy(s.t, place.at.t), "locating a place");
  place.at.sign = s.sign, place.at.omega = s.omega;
  place.at.newton = s.newton, place.at.activity = s.activity, place.at.motion = s.motion;
  if (s.motion) place.at.error = s.error;
  return place;
}

// In a corner between here_ and trial_ planes across either leg may miss the other one. Those across the direction
// between both tangents meet the curve once; from the corner on, which is near where the tangents meet, it is near the
// straight line to either end. In time the corner itself is the place. What cannot be located so is the one of both
// ends that lies `beyond`, farther on or higher. values: of f there.
Follower::Place Follower::corner_place(Place::Kind kind, double step, bool beyond, std::array<double, 2> values,
                                       const Measured &f) {
  std::optional<Place> place;
  if (orbit_) {
    Place corner{0, kind, curve_->station()};
    if (show_if(orbit_->corner(), corner.at)) {
      corner.along = std::clamp(orbit_->along(*corner.at.motion), 0.0, step);
      place = std::move(corner);
    }
  } else {
    const long before = summary_.counts.newton;
    place = locate_in_corner(kind, step, values, f);
    const long took = summary_.counts.newton - before;
    ahead_.newton += took, crowd_.newton += took; // that is no winding
  }
  if (place) return std::move(*place);
  return beyond ? place_at(trial_, kind, step) : place_at(here_, kind, 0);
}

std::optional<Follower::Place> Follower::locate_in_corner(Place::Kind kind, double step, std::array<double, 2> values,
                                                          const Measured &f) {
  constexpr const char *doing = "locating a place in a corner";
  const double ahead = meeting(trial_).ahead;
  if (!(ahead > 0)) return std::nullopt;
  UniqueVec normal = system_->unknowns(), guess = system_->unknowns();
  check(VecWAXPY(normal, 1, here_.t, trial_.t), doing);
  check(VecScale(normal, 1 / curve_->norm.length(normal)), doing);
  check(VecWAXPY(guess, ahead, here_.t, here_.y), doing);
  const auto near = [&](Vec y, Vec from) { // else it is a solution of another branch
    const UniqueVec way = system_->unknowns();
    check(VecWAXPY(way, -1, from, y), doing);
    return curve_->norm.length(way) < most_correction * ahead;
  };
  Station corner = curve_->station();
  check(VecCopy(guess, corner.y), doing);
  if (!curve_->solve_across(normal, corner, {false, most_newton, ahead}) || !near(corner.y, guess)) return std::nullopt;
  const double here = curve_->plane(normal, here_.y), there = curve_->plane(normal, corner.y) - here,
               end = curve_->plane(normal, trial_.y) - here, value = f(corner);
  if (!(0 < there && there < end)) return std::nullopt;
  const Bound middle{there, corner.y, value};
  std::optional<Place> place = value * values[0] < 0 ? locate(kind, normal, {0, here_.y, values[0]}, middle, f)
                                                     : locate(kind, normal, middle, {end, trial_.y, values[1]}, f);
  if (!place || !near(place->at.y, corner.y)) return std::nullopt;
  place->along *= step / end;
  return place;
}

// Between here_ and trial_ the determinant changes its sign. Either another branch crosses the curve there, or two legs
// of a hairpin face each other and the step went across: then the way back from trial_ misses here_ by as much.
bool Follower::leads_back(double step, double missed) {
  Station back = curve_->station();
  check(VecWAXPY(back.y, -step, trial_.t, trial_.y), "looking back");
  if (!curve_->solve_across(trial_.t, back)) return false;
  check(VecAXPY(back.y, -1, here_.y), "looking back");
  const double distance = curve_->norm.length(back.y), along = curve_->norm.product(back.y, here_.t);
  return std::sqrt(std::max(0.0, distance * distance - along * along)) < 0.1 * std::max(missed, 1e-3 * step);
}

// Close to a branch point Newton may land on the other branch: the place is as good as bisection gets.
Follower::Place Follower::locate_branch_point(double step) {
  UniqueVec ya = system_->unknowns(), yb = system_->unknowns();
  check(VecCopy(here_.y, ya), "locating a branch point");
  check(VecCopy(trial_.y, yb), "locating a branch point");
  Place place = place_at(trial_, Place::Kind::branch, step), middle{step, Place::Kind::branch, curve_->station()};
  double a = 0, b = step;
  while (b - a > 1e-5 * step) {
    check(VecWAXPY(middle.at.y, -1, ya, yb), "locating a branch point");
    check(VecAYPX(middle.at.y, 0.5, ya), "locating a branch point");
    if (!curve_->solve_across(here_.t, middle.at) || angle(curve_->norm, here_.t, middle.at.t) > straight) break;
    middle.along = (a + b) / 2;
    (middle.at.sign == here_.sign ? a : b) = middle.along;
    check(VecCopy(middle.at.y, middle.along == a ? ya : yb), "locating a branch point");
    std::swap(place, middle);
  }
  return place;
}

} // namespace dovetail
