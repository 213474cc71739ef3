#include "continuation/branch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "continuation/follower.hpp"

namespace dovetail {
namespace {

constexpr double alone = 1e-3; // of its frequency, is what counts as much as the motion where there is one point only

} // namespace

Follower::Follower(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings,
                   const BranchObserver &observer)
    : system_(&system), newton_(newton), settings_(settings), observer_(observer),
      omega_unit_(settings.to != settings.from ? std::abs(settings.to - settings.from) : alone * settings.from),
      curve_(std::make_unique<Curve>(system, newton, omega_unit_, settings.adaptive, summary_.counts)),
      meter_(std::make_unique<AmplitudeMeter>(system.layout(), settings.watched)), here_(curve_->station()),
      trial_(curve_->station()), predicted_(system.unknowns()), trail_(omega_unit_), lent_from_(system.harmonics()),
      direction_(settings.to < settings.from ? -1 : 1), asked_for_(system.harmonics()),
      asked_samples_(system.samples()), begun_at_(settings.from) {
  if (settings.stability) begin_stability();
  if (settings.estimates) estimator_ = std::make_unique<Estimator>(system, omega_unit_, newton.residual_tolerance);
}

BranchSummary Follower::run(Vec y, const std::string &why_there) {
  Station first = curve_->station();
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

void Follower::begin(Station first) {
  here_ = std::move(first);
  if (direction_ < 0 && !orbit_) turn(here_);
  curve_->norm.see(here_.y);
  for (int i = 0; i < most_refinements && !orbit_ && refined_for(here_); ++i) {
  }
  verdict_ = judge(here_);
  report(here_, 0, verdict_ ? &*verdict_ : nullptr);
  if (settings_.to == settings_.from) return;
  check(VecScale(here_.t, 1 / curve_->norm.length(here_.t)), "measuring arc length"); // by the norm as it is now
  step_ = settings_.step / plain_length(here_.t); // the user's arc length is in the plain norm
  ahead_ = {here_.omega, summary_.counts.newton};
  begin_amplitude();
  trail_.add(system_->layout(), here_.y, here_.t, curve_->norm.largest_motion());
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
      careful_ = careful_points, careful_step_ = longest_step; // marks of the curve with fewer lie here
      continue;
    }
    if (!leave_from_farthest(summary_.why))
      ended_ = true;
    else if (!ended_)
      after_step();
  }
  summary_.omega = here_.omega;
  summary_.farthest = farther(here_.omega) ? here_.omega : farthest_->omega;
  return summary_;
}

Follower::Go Follower::end(End how, const std::string &why) {
  summary_.end = how, summary_.why = why;
  ended_ = true;
  return Go::ended;
}

bool Follower::farther(double omega) const { return !farthest_ || direction_ * (omega - farthest_->omega) > 0; }

// Without what belongs to the solve.
void Follower::note(std::optional<Station> &place, const Station &s) const {
  if (!place) place = curve_->station();
  check(VecCopy(s.y, place->y), "noting a point");
  check(VecCopy(s.t, place->t), "noting a point");
  place->sign = s.sign, place->omega = s.omega;
}

// Of here_, which was noted.
void Follower::recall_activity() {
  const UniqueVec r = system_->unknowns();
  system_->residual(here_.y, r);
  here_.activity = system_->activity();
}

double Follower::plain_length(Vec t) const {
  PetscReal length;
  check(VecNorm(t, NORM_2, &length), "measuring arc length");
  return length;
}

// Of here_, which no step along the curve led to.
void Follower::begin_amplitude() {
  before_.reset();
  amplitude_ = (*meter_)(here_.y, here_.t);
  between_.begin({amplitude_.value, amplitude_.slope / plain_length(here_.t)});
  between_error_ = NAN;
}

// A curve that bends over may leave the sweep at its beginning and come back: it is followed there, but not reported.
double Follower::beyond_start(double omega) const { return (settings_.from - omega) * direction_; }

// Between two steps: may it go on, and where does it stand.
Follower::Go Follower::after_step() {
  if (summary_.counts.points >= settings_.max_points)
    end(End::max_points, "stopped at continuation.max_points = " + std::to_string(settings_.max_points));
  else if (observer_.interrupted && observer_.interrupted())
    end(End::interrupted, "interrupted");
  if (!ended_) note_creeping();
  if (!ended_ && !crowded_.empty()) pass_crowd();
  if (!ended_ && winds()) {
    const double turned = farthest_->omega, integrated = integrating_;
    const bool left = leave_from_farthest("the curve winds on and does not go ahead", true);
    if (!left && interrupted()) { // to be tried again by a restart
      integrating_ = integrated;
      end(End::interrupted, "interrupted");
    } else {
      if (!left) stayed_at_ = turned, ++stays_; // it is followed on
      ahead_.newton = summary_.counts.newton;
      if (!left && orbit_ && stays_ > most_stays)
        end(End::turned_back, "the curve winds on in time as well, and no way on was found");
    }
  }
  if (!ended_ && still_ == enough_still) {
    still_ = 0;
    refusal_ =
        "from here on the curve is a straight line at one frequency, along which mean positions change and nothing "
        "else: any of them is a solution, and beyond the body walks away";
    if (!leap(Way::newton, here_.omega) && !leap(Way::integration, here_.omega)) end(End::stalled, refusal_);
  }
  count_estimates();
  if (observer_.state) observer_.state(state());
  return ended_ ? Go::ended : Go::on;
}

void Follower::report(Station &s, double arclength, const Stability *stability, bool place) {
  ++summary_.counts.points;
  if (orbit_) ++summary_.counts.in_time;
  std::optional<MotionState> motion;
  if (orbit_) motion = orbit_->motion_state(*s.motion);
  observer_.point({s.y, *system_, s.omega, arclength, s.newton, s.activity, stability,
                   !estimator_ ? nullptr
                   : place     ? &error_of(s)
                               : &affordable_error_of(s),
                   between_error_, 1 - std::abs(settings_.to - s.omega) / omega_unit_, place,
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
  const bool sweep = settings.from != settings.to;
  if (sweep) begin_at(settings.to, settings.from, other_end);
  other.in_time = true;
  begin_at(settings.from, settings.to, sweep ? "either end of the sweep by harmonic balance" : "this frequency by it");
  if (sweep) begin_at(settings.to, settings.from, other_end);
  other.briefly = true;
  for (const bool in_time : {false, true})
    for (const double part : {0.02, 0.2, 0.35, 0.5, 0.65, 0.8}) {
      other.in_time = in_time;
      if (sweep)
        begin_at(settings.from + part * (settings.to - settings.from), settings.to,
                 "either end of the sweep: begun at this frequency, towards " +
                     std::string(settings.to < settings.from ? "lower" : "higher") + " ones");
    }
  return none() ? summary : from_there;
}

} // namespace dovetail
