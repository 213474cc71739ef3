#include "analyses/follower.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "analyses/last_iterate.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr double least_patience = 400; // Newton iterations for a curve that does not go ahead,
constexpr double dear_patience = 100;  // where they are expensive; or so many that
constexpr double most_wound = 3e5;     // unknowns were corrected in all
constexpr double first_skip = 0.01;    // of the range, left out when a curve is left again, twice as much each time

} // namespace

Follower::Follower(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings,
                   const BranchObserver &observer)
    : settings_(settings), observer_(observer), report_(observer), stepper_(system, newton, settings, report_),
      recovery_(settings, stepper_, report_) {}

BranchSummary Follower::run(Vec y) {
  report_.summary.parameter = settings_.from;
  if (const int motions = stepper_.response.system().loose_body().motions(); motions > 0)
    report_.event(BranchEvent::Kind::start,
                  "the structure is held by its joint alone in " + std::to_string(motions) +
                      (motions == 1 ? " rigid motion" : " rigid motions"),
                  settings_.from);
  check(VecCopy(y, stepper_.here().y), "starting");
  std::string elsewhere;
  if (!recovery_.first_point(settings_.from)) {
    const std::string why = report_.summary.why;
    if (!recovery_.recovers(Failure::Kind::nowhere, why, settings_.from)) {
      if (report_.summary.end != End::interrupted) report_.end(End::no_start, why);
      return report_.summary;
    }
    elsewhere = "no solution was found at the first " + stepper_.response.parameter_name() + ": begun at this one";
  }
  const std::string &how = recovery_.how();
  const std::string told = elsewhere + (elsewhere.empty() || how.empty() ? "" : "; ") + how;
  if (!told.empty()) report_.event(BranchEvent::Kind::start, told, stepper_.range.from);
  report_.summary.why.clear();
  stepper_.begin(settings_.step);
  return follow(false);
}

BranchSummary Follower::go_on(const BranchState &state) {
  report_.counts = state.counts;
  Archive saved(state.fields);
  stepper_.restore(state, saved);
  recovery_.archive(saved);
  return follow(true);
}

BranchState Follower::state() {
  BranchState state;
  Archive saved;
  stepper_.save(state, saved);
  recovery_.archive(saved);
  state.fields = saved.fields();
  state.counts = report_.counts;
  return state;
}

// `between`: it stands between two steps, and what is looked at there may not have been. A step that a limit ends half
// way is not saved: a restart takes it again, from the state before.
BranchSummary Follower::follow(bool between) {
  if (stepper_.range.one_point()) report_.end(End::arrived);
  if (!between && !report_.ended() && observer_.state) observer_.state(state());
  if (report_.counts.points >= settings_.max_points) between = true;
  while (!report_.ended()) {
    if (!std::exchange(between, false)) step();
    if (!report_.ended()) after_step();
    if (report_.ended()) leave_lost();
  }
  report_.summary.parameter = stepper_.here().parameter;
  report_.summary.farthest = stepper_.farthest.or_farther(stepper_.here().parameter);
  return report_.summary;
}

void Follower::step() {
  if (stepper_.advance() != Stepper::Outcome::refused) return;
  const std::string why = stepper_.why(), where = difference(stepper_.response.system(), stepper_.here());
  if (!settings_.adaptive || !recovery_.recovers(Failure::Kind::no_step, why, stepper_.here().parameter))
    report_.end(report_.interrupted() ? End::interrupted : End::stalled, why + where);
}

// Between two steps: may it go on, and where does it stand.
void Follower::after_step() {
  if (!report_.ends_at(settings_.max_points) && report_.interrupted()) report_.end(End::interrupted, "interrupted");
  if (!report_.ended()) look_back();
  stepper_.errors.count_work();
  if (observer_.state) observer_.state(state());
}

// Whether steps that converge lead nowhere.
void Follower::look_back() {
  SweepMonitors &progress = stepper_.progress;
  if (progress.cluster.crowded()) {
    const double beyond = progress.cluster.beyond(stepper_.here().parameter, stepper_.range.direction());
    recovery_.recovers(Failure::Kind::crowded, "the curve bends again and again", beyond); // or it is followed on
  }
  if (!report_.ended() && winds()) leave_windings();
  if (report_.ended() || !progress.drift.drifts()) return;
  progress.drift.forget();
  const std::string why = "from here on the curve is a straight line at one " + stepper_.response.parameter_name() +
                          ", along which mean positions change and nothing "
                          "else: any of them is a solution, and beyond the body walks away";
  if (!recovery_.recovers(Failure::Kind::drifting, why, stepper_.here().parameter)) report_.end(End::stalled, why);
}

// A curve that winds on between values it has met, for as many iterations as a whole sweep may take, and as some
// seconds hold if it is small, is left: the values ahead are what was asked for.
bool Follower::winds() {
  stepper_.progress.ahead.stepped(stepper_.here().parameter, report_.counts.newton);
  if (!settings_.adaptive || settings_.strategies.none() || stepper_.farthest.is_behind(stepper_.here().parameter))
    return false;
  const Layout &layout = stepper_.response.layout();
  const double unknowns = static_cast<double>(layout.dofs() * layout.width),
               least = stepper_.response.iterations_are_expensive() ? dear_patience : least_patience;
  return stepper_.progress.ahead.winds(stepper_.farthest.or_farther(stepper_.here().parameter), report_.counts.newton,
                                       std::max(least, most_wound / unknowns));
}

void Follower::leave_windings() {
  const double turned = stepper_.farthest.or_farther(stepper_.here().parameter), integrated = recovery_.integrated();
  const bool left = leave("the curve winds on and does not go ahead");
  if (!left && report_.interrupted()) { // to be tried again by a restart
    recovery_.set_integrated(integrated);
    report_.end(End::interrupted, "interrupted");
    return;
  }
  if (!left) stepper_.progress.ahead.stayed(turned); // it is followed on
  stepper_.progress.ahead.restart_count(report_.counts.newton);
}

// A curve that has ended short of the range's end may be left for what lies ahead, which may end the range.
void Follower::leave_lost() {
  const End how = report_.summary.end;
  if (how != End::retraced && how != End::turned_back && how != End::stalled) return;
  report_.set_ended(false);
  const std::string why = report_.summary.why;
  const bool tried = how == End::stalled && stepper_.farthest.is_behind(stepper_.here().parameter) &&
                     stepper_.progress.ahead.times_left() == 0;
  if (tried || !leave(why)) // the same from the same place
    report_.set_ended(true);
  else if (!report_.ended())
    after_step();
}

// The curve is left where it had come farthest, for what lies ahead: the farther, the more often it was left before.
bool Follower::leave(const std::string &why) {
  const bool back = !stepper_.farthest.is_behind(stepper_.here().parameter);
  if (back) std::swap(stepper_.here(), *stepper_.farthest.point);
  const double left = stepper_.here().parameter;
  const int times = stepper_.progress.ahead.times_left();
  const double skipped = times > 0 ? std::min(first_skip * std::pow(2, times), 1.0) : 0;
  const bool found =
      recovery_.recovers(Failure::Kind::lost, why, left + stepper_.range.direction() * skipped * stepper_.range.unit);
  if (found) {
    stepper_.farthest.point.reset();
    stepper_.progress.ahead.left(left);
    return true;
  }
  if (back) std::swap(stepper_.here(), *stepper_.farthest.point);
  if (report_.summary.end != End::interrupted) report_.summary.why = why;
  return false;
}

BranchSummary follow_branch(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings, Vec y,
                            const BranchObserver &observer, const BranchState *state) {
  Follower follower(system, newton, settings, observer);
  return state ? follower.go_on(*state) : follower.run(y);
}

} // namespace dovetail
