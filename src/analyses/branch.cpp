#include "analyses/branch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "analyses/follower.hpp"

namespace dovetail {
namespace {

constexpr double least_patience = 400; // Newton iterations for a curve that does not go ahead,
constexpr double dear_patience = 100;  // where they are expensive; or so many that
constexpr double most_wound = 3e5;     // unknowns were corrected in all
constexpr double alone = 1e-3; // of its frequency, is what counts as much as the motion where there is one point only

double unit_of(const BranchSettings &settings) {
  return settings.to != settings.from ? std::abs(settings.to - settings.from) : alone * settings.from;
}

} // namespace

Follower::Follower(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings,
                   const BranchObserver &observer)
    : Stepper({settings.adaptive, settings.step}, unit_of(settings), newton.step_tolerance), system_(&system),
      newton_(newton), settings_(settings), observer_(observer),
      response_(std::make_unique<ResponseCurve>(system, newton, unit_, settings.adaptive, summary_.counts)),
      meter_(std::make_unique<AmplitudeMeter>(system.layout(), settings.watched)), retraced_(unit_), cluster_(unit_),
      progress_(unit_), asked_for_(system.harmonics()), direction_(settings.to < settings.from ? -1 : 1) {
  take_curve(*response_);
  if (settings.stability) begin_stability();
  if (settings.estimates) estimator_ = std::make_unique<Estimator>(system, unit_, newton.residual_tolerance);
}

BranchSummary Follower::run(Vec y) {
  summary_.parameter = settings_.from;
  if (const int motions = system_->loose_body().motions(); motions > 0)
    notify(BranchEvent::Kind::start,
           "the structure is held by its joint alone in " + std::to_string(motions) +
               (motions == 1 ? " rigid motion" : " rigid motions"),
           settings_.from);
  check(VecCopy(y, here_.y), "starting");
  if (!first_point(settings_.from)) {
    const std::string why = summary_.why;
    if (!recovers(Failure::Kind::nowhere, why, settings_.from)) {
      if (summary_.end != End::interrupted) summary_.end = End::no_start, summary_.why = why;
      return summary_;
    }
    how_ = "no solution was found at the first " + parameter_name() + ": begun at this one" +
           (how_.empty() ? "" : "; " + how_);
  }
  if (!how_.empty()) notify(BranchEvent::Kind::start, how_, settings_.from);
  summary_.why.clear();
  begin();
  return follow(false);
}

void Follower::begin() {
  if (direction_ < 0) turn(here_);
  curve_->norm.see(here_.y);
  for (int i = 0; i < step_limits.most_refinements && refined_for(here_); ++i) {
  }
  verdict_ = judge(here_);
  report(here_, 0, verdict_ ? &*verdict_ : nullptr);
  if (settings_.to == settings_.from) return;
  measure_anew();
  control_.set(settings_.step / plain_length(here_.t)); // the user's arc length is in the plain norm
  progress_.begin(here_.parameter, summary_.counts.newton, direction_);
  begin_amplitude();
  retraced_.add(curve_->problem, here_.y, here_.t, curve_->norm.largest_motion());
  limit_step();
}

BranchSummary Follower::go_on(const BranchState &state) {
  restore(state);
  return follow(true);
}

// `between`: it stands between two steps, and what is looked at there may not have been.
BranchSummary Follower::follow(bool between) {
  if (settings_.to == settings_.from) end(End::arrived);
  if (summary_.counts.points >= settings_.max_points) between = true;
  while (!ended_) {
    if (!std::exchange(between, false)) advance();
    if (!ended_) after_step();
    const bool lost = summary_.end == End::retraced || summary_.end == End::turned_back || summary_.end == End::stalled;
    if (!ended_ || !lost) continue;
    ended_ = false; // a leap may end the sweep
    const std::string why = summary_.why;
    const bool tried = summary_.end == End::stalled && stands_farthest() && progress_.times_left() == 0;
    if (tried || !leave(why)) // the same from the same place
      ended_ = true;
    else if (!ended_)
      after_step();
  }
  summary_.parameter = here_.parameter;
  summary_.farthest = stands_farthest() ? here_.parameter : farthest_->parameter;
  return summary_;
}

Follower::Outcome Follower::end(End how, const std::string &why) {
  summary_.end = how, summary_.why = why;
  ended_ = true;
  return Outcome::ended;
}

bool Follower::farther(double omega) const { return !farthest_ || direction_ * (omega - farthest_->parameter) > 0; }

// Of here_, which was noted.
void Follower::recall_activity() {
  const UniqueVec r = system_->unknowns();
  system_->residual(here_.y, r);
  here_.data = curve_->problem.describe();
}

double Follower::plain_length(Vec t) const {
  PetscReal length;
  check(VecNorm(t, NORM_2, &length), "measuring arc length");
  return length;
}

// Of here_, which no step along the curve led to.
void Follower::begin_amplitude() {
  forget_before();
  amplitude_ = (*meter_)(here_.y, here_.t);
  between_.begin({amplitude_.value, amplitude_.slope / plain_length(here_.t)});
  between_error_ = NAN;
}

// A curve that bends over may leave the sweep at its beginning and come back: it is followed there, but not reported.
double Follower::beyond_start(double omega) const { return (settings_.from - omega) * direction_; }

// Between two steps: may it go on, and where does it stand.
Follower::Outcome Follower::after_step() {
  if (summary_.counts.points >= settings_.max_points)
    end(End::max_points, "stopped at continuation.max_points = " + std::to_string(settings_.max_points));
  else if (observer_.interrupted && observer_.interrupted())
    end(End::interrupted, "interrupted");
  if (!ended_) cluster_.stepped(here_.parameter, summary_.counts.newton);
  if (!ended_ && cluster_.crowded()) {
    const std::string why = cluster_.why();
    recovers(Failure::Kind::crowded, why, cluster_.beyond(here_.parameter, direction_)); // or it is followed on
  }
  if (!ended_ && winds()) leave_windings();
  if (!ended_ && drift_.drifts()) {
    drift_.forget();
    const std::string why = "from here on the curve is a straight line at one " + parameter_name() +
                            ", along which mean positions change and nothing "
                            "else: any of them is a solution, and beyond the body walks away";
    if (!recovers(Failure::Kind::drifting, why, here_.parameter)) end(End::stalled, why);
  }
  count_estimates();
  if (observer_.state) observer_.state(state());
  return ended_ ? Outcome::ended : Outcome::on;
}

// A curve that winds on between frequencies it has met, for as many iterations as a whole sweep may take, and as some
// seconds hold if it is small, is left: the frequencies ahead are what was asked for.
bool Follower::winds() {
  progress_.stepped(here_.parameter, summary_.counts.newton);
  if (!settings_.adaptive || settings_.strategies.none() || stands_farthest()) return false;
  const double unknowns = static_cast<double>(system_->layout().dofs() * system_->layout().width);
  return progress_.winds(farthest_->parameter, summary_.counts.newton,
                         std::max(dear() ? dear_patience : least_patience, most_wound / unknowns));
}

void Follower::leave_windings() {
  const double turned = farthest_->parameter, integrated = integrating_;
  const bool left = leave("the curve winds on and does not go ahead");
  if (!left && interrupted()) { // to be tried again by a restart
    integrating_ = integrated;
    end(End::interrupted, "interrupted");
    return;
  }
  if (!left) progress_.stayed(turned); // it is followed on
  progress_.restart_count(summary_.counts.newton);
}

void Follower::report(CurvePoint &s, double arclength, const Stability *stability, bool place) {
  ++summary_.counts.points;
  observer_.point({s.y, *system_, s.parameter, arclength, s.newton, data_of(s).activity, stability,
                   !estimator_ ? nullptr
                   : place     ? &error_of(s)
                               : &affordable_error_of(s),
                   between_error_, 1 - std::abs(settings_.to - s.parameter) / unit_, place});
}

void Follower::notify(BranchEvent::Kind kind, const std::string &text, double omega, double amplitude) {
  observer_.event({kind, text, omega, amplitude});
}

BranchSummary follow_branch(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings, Vec y,
                            const BranchObserver &observer, const BranchState *state) {
  Follower follower(system, newton, settings, observer);
  return state ? follower.go_on(*state) : follower.run(y);
}

} // namespace dovetail
