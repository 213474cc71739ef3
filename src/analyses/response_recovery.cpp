#include "analyses/response_recovery.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "analyses/last_iterate.hpp"
#include "analyses/load_steps.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

std::string ahead_in_words(const std::string &parameter, double part) { // of the range
  const long percent = std::lround(100 * part);
  return percent < 1 ? "the next " + parameter
                     : "a " + parameter + " " + std::to_string(percent) + " % of the sweep ahead";
}

} // namespace

bool ResponseRecovery::recovers(Failure::Kind kind, const std::string &why, double from) {
  before_jump_ = stepper_.here().parameter;
  return recover(settings_.strategies, {kind, why, from}, *this);
}

bool ResponseRecovery::first_point(double value) {
  how_.clear();
  CurvePoint &here = stepper_.here();
  ResponseCurve &curve = stepper_.response.curve();
  const bool other_ways = settings_.strategies.has("fewer_harmonics"); // quicker than Newton with all harmonics
  const auto by_fewer_harmonics = [&] {
    return other_ways && stand_on(search_.by_fewer_harmonics(value, here.y, true));
  };
  PetscReal given;
  check(VecNorm(here.y, NORM_INFINITY, &given), "starting");
  const bool one_first = given == 0 && stepper_.response.system().harmonics() > 1;
  if (one_first && by_fewer_harmonics()) return how_.clear(), true;
  if (other_ways ? curve.solve_at(value, here, hurried) : curve.solve_at(value, here)) return true;
  report_.summary.why = "no solution was found at the first " + stepper_.response.parameter_name() + ": " +
                        here.newton.why + difference(stepper_.response.system(), here);
  if (const std::string lost = stepper_.response.lost_to_rounding(value, here.newton.residual); !lost.empty()) {
    report_.summary.why += lost;
    return false;
  }
  starting_ = true;
  const bool found = (!one_first && by_fewer_harmonics()) || (other_ways && curve.solve_at(value, here)) ||
                     recovers(Failure::Kind::no_start, report_.summary.why, value);
  if (!how_.empty()) how_ = "Newton does not converge from rest; the first point comes from " + how_;
  starting_ = false;
  return found;
}

bool ResponseRecovery::stand_on(std::optional<PointSearch::Found> found) {
  if (!found) return false;
  how_ = found->how;
  stepper_.stand_on(std::move(found->point), std::move(found->system));
  return true;
}

bool ResponseRecovery::integrate_at(double value, double share) {
  return stand_on(search_.by_integration(value, starting_ ? nullptr : static_cast<Vec>(stepper_.here().y), share));
}

bool ResponseRecovery::begin_at(double from, double to) {
  SweepRange &range = stepper_.range;
  const auto [first, last] = std::pair(range.from, range.to);
  range.from = from, range.to = to;
  search_.set_integrated(0);
  check(VecSet(stepper_.here().y, 0), "beginning elsewhere");
  if (first_point(from)) return true;
  range.from = first, range.to = last;
  return false;
}

void ResponseRecovery::go_on(const Failure &failure, bool integrated) {
  const SweepRange &range = stepper_.range;
  CurvePoint &here = stepper_.here();
  const std::string parameter = stepper_.response.parameter_name();
  const double next = here.parameter, reached = stepper_.farthest.or_farther(before_jump_);
  for (const double w : range.between(reached, next))
    report_.event(report_.counts.missed, BranchEvent::Kind::missed,
                  "this " + parameter + " of " + stepper_.response.at_key() + " is left out by a leap", w);
  if (range.direction() < 0) turn(here);
  report_.event(integrated ? report_.counts.integrations : report_.counts.leaps,
                integrated ? BranchEvent::Kind::integration : BranchEvent::Kind::leap,
                "the curve could not be followed here (" + failure.why + "): went on from the " +
                    (integrated ? "steady state that time integration finds" : "solution") + " at " +
                    ahead_in_words(parameter, std::abs(next - before_jump_) / range.unit) +
                    "; the branch may have changed",
                next);
  stepper_.land();
  if (next == range.to) report_.end(BranchReport::End::arrived);
}

} // namespace dovetail
