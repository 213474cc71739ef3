#include "analyses/branch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "analyses/follower.hpp"

namespace dovetail {
namespace {

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
      progress_(unit_), lent_from_(system.harmonics()), direction_(settings.to < settings.from ? -1 : 1),
      asked_for_(system.harmonics()), asked_samples_(system.samples()), begun_at_(settings.from) {
  take_curve(*response_);
  if (settings.stability) begin_stability();
  if (settings.estimates) estimator_ = std::make_unique<Estimator>(system, unit_, newton.residual_tolerance);
}

BranchSummary Follower::run(Vec y, const std::string &why_there) {
  CurvePoint first = curve_->point();
  std::string how = why_there;
  summary_.omega = settings_.from;
  if (const int motions = system_->loose_body().motions(); motions > 0)
    notify(BranchEvent::Kind::start,
           "the structure is held by its joint alone in " + std::to_string(motions) +
               (motions == 1 ? " rigid motion" : " rigid motions"),
           settings_.from);
  if (settings_.in_time && first_in_time(settings_.from)) {
    std::swap(first, here_);
    how += "; the first point comes from time integration, and the curve is followed in time from there";
  } else if (settings_.in_time ||
             !first_point(settings_.from, y, first, how, settings_.briefly ? Effort::brief : Effort::full)) {
    if (summary_.end != End::interrupted) summary_.end = End::no_start;
    return summary_;
  }
  if (!how.empty()) notify(BranchEvent::Kind::start, how, settings_.from);
  begin(std::move(first));
  return follow(false);
}

void Follower::begin(CurvePoint first) {
  here_ = std::move(first);
  if (direction_ < 0 && !orbit_) turn(here_);
  curve_->norm.see(here_.y);
  for (int i = 0; i < step_limits.most_refinements && !orbit_ && refined_for(here_); ++i) {
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
    if (!std::exchange(between, false)) orbit_ ? advance_in_time() : advance();
    if (!ended_) after_step();
    const bool lost = summary_.end == End::retraced || summary_.end == End::turned_back || summary_.end == End::stalled;
    if (!ended_ || !lost) continue;
    ended_ = false; // a leap may end the sweep
    refusal_ = summary_.why;
    if (summary_.end == End::retraced && more_harmonics()) {
      control_.be_careful(careful_points, step_limits.longest); // marks of the curve with fewer lie here
      continue;
    }
    if (!leave_from_farthest(summary_.why))
      ended_ = true;
    else if (!ended_)
      after_step();
  }
  summary_.omega = here_.parameter;
  summary_.farthest = farther(here_.parameter) ? here_.parameter : farthest_->parameter;
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
  if (!ended_ && !orbit_) cluster_.stepped(here_.parameter, summary_.counts.newton);
  if (!ended_ && cluster_.crowded()) pass_crowd();
  if (!ended_ && winds()) {
    const double turned = farthest_->parameter, integrated = integrating_;
    const bool left = leave_from_farthest("the curve winds on and does not go ahead", true);
    if (!left && interrupted()) { // to be tried again by a restart
      integrating_ = integrated;
      end(End::interrupted, "interrupted");
    } else {
      if (!left) progress_.stayed(turned); // it is followed on
      progress_.restart_count(summary_.counts.newton);
      if (!left && orbit_ && progress_.times_stayed() > most_stays)
        end(End::turned_back, "the curve winds on in time as well, and no way on was found");
    }
  }
  if (!ended_ && drift_.drifts()) {
    drift_.forget();
    refusal_ =
        "from here on the curve is a straight line at one frequency, along which mean positions change and nothing "
        "else: any of them is a solution, and beyond the body walks away";
    if (!leap(Way::newton, here_.parameter) && !leap(Way::integration, here_.parameter)) end(End::stalled, refusal_);
  }
  count_estimates();
  if (observer_.state) observer_.state(state());
  return ended_ ? Outcome::ended : Outcome::on;
}

void Follower::report(CurvePoint &s, double arclength, const Stability *stability, bool place) {
  ++summary_.counts.points;
  if (orbit_) ++summary_.counts.in_time;
  std::optional<MotionState> motion;
  if (orbit_) motion = orbit_->motion_state(*data_of(s).motion);
  observer_.point({s.y, *system_, s.parameter, arclength, s.newton, data_of(s).activity, stability,
                   !estimator_ ? nullptr
                   : place     ? &error_of(s)
                               : &affordable_error_of(s),
                   between_error_, 1 - std::abs(settings_.to - s.parameter) / unit_, place,
                   motion ? &*motion : nullptr});
}

void Follower::notify(BranchEvent::Kind kind, const std::string &text, double omega, double amplitude) {
  observer_.event({kind, text, omega, amplitude});
}

// At either end, then in between, towards `to`.
BranchSummary follow_branch(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings, Vec y,
                            const BranchObserver &observer, const BranchState *state) {
  BranchSettings other = settings;
  if (state) {
    Archive saved(state->fields);
    double direction = 0;
    saved.field("direction", direction);
    saved.field("begun_at", other.from);
    const bool reversed = direction * (settings.to - settings.from) < 0; // begun at the other end
    other.to = reversed ? settings.from : settings.to;
    return Follower(system, newton, other, observer).go_on(*state);
  }
  other.both_ends = true;
  const BranchSummary summary = Follower(system, newton, other, observer).run(y, "");
  other.both_ends = false;
  BranchSummary from_there = summary;
  const auto none = [&] { return from_there.end == BranchSummary::End::no_start; };
  const auto begin_at = [&](double from, double to, const std::string &where) {
    if (!none()) return;
    other.from = from, other.to = to;
    check(VecSet(y, 0), "starting elsewhere");
    from_there = Follower(system, newton, other, observer).run(y, "no solution was found at " + where);
  };
  const std::string other_end = "the other end of the sweep: begun at this one, towards it";
  const bool sweep = settings.from != settings.to, elsewhere = settings.strategies.has(Strategy::elsewhere);
  if (sweep && elsewhere) begin_at(settings.to, settings.from, other_end);
  other.in_time = true;
  begin_at(settings.from, settings.to, sweep ? "either end of the sweep by harmonic balance" : "this frequency by it");
  if (sweep && elsewhere) begin_at(settings.to, settings.from, other_end);
  other.briefly = true;
  for (const bool in_time : {false, true})
    for (const double part : {0.02, 0.2, 0.35, 0.5, 0.65, 0.8}) {
      other.in_time = in_time;
      if (sweep && elsewhere)
        begin_at(settings.from + part * (settings.to - settings.from), settings.to,
                 "either end of the sweep: begun at this frequency, towards " +
                     std::string(settings.to < settings.from ? "lower" : "higher") + " ones");
    }
  return none() ? summary : from_there;
}

} // namespace dovetail
