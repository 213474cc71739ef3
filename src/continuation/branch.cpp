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
      direction_(settings.to < settings.from ? -1 : 1), begun_at_(settings.from) {
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
  if (!first_point(settings_.from, y, first, how, settings_.briefly)) {
    if (summary_.end != End::interrupted) summary_.end = End::no_start;
    return summary_;
  }
  if (!how.empty()) notify(BranchEvent::Kind::start, how, settings_.from);
  begin(std::move(first));
  return follow(false);
}

void Follower::begin(Station first) {
  here_ = std::move(first);
  if (direction_ < 0) turn(here_);
  curve_->norm.see(here_.y);
  for (int i = 0; i < most_refinements && refined_for(here_); ++i) {
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
    if (!std::exchange(between, false)) advance();
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
  return summary_;
}

Follower::Go Follower::end(End how, const std::string &why) {
  summary_.end = how, summary_.why = why;
  ended_ = true;
  return Go::ended;
}

bool Follower::farther(double omega) const { return !farthest_ || direction_ * (omega - farthest_->omega) > 0; }

void Follower::drop_anchors() {
  for (auto &anchor : anchors_) anchor.reset();
  since_anchor_ = careful_ = 0;
}

// A curve that runs on from its beginning cannot come upon an older piece of itself, unless a step has led to another
// piece of it, or the wrong way round a corner. That is where it came upon it, or where it was there before. So the
// last points are followed once more, with short steps.
bool Follower::follow_again(const std::string &why) {
  const bool just_done = repeated_at_ > 0 && summary_.counts.points - repeated_at_ < 2 * careful_points;
  if (!settings_.adaptive || settings_.steps_only || !anchors_[0] || just_done ||
      summary_.counts.repeats >= most_repeats)
    return false;
  repeated_at_ = summary_.counts.points;
  here_ = std::move(*anchors_[0]);
  const double way = anchor_arc_;
  const int points = anchored + since_anchor_ + 1;
  drop_anchors();
  careful_ = careful_points, careful_step_ = careful_part * way / points;
  ++summary_.counts.repeats;
  notify(BranchEvent::Kind::again, why + ": the last points once more, with short steps", here_.omega);
  begin_amplitude();
  trail_.interrupt();
  still_ = 0;
  check(VecScale(here_.t, 1 / curve_->norm.length(here_.t)), "measuring arc length");
  step_ = careful_step_;
  limit_step();
  return true;
}

// Without what belongs to the solve.
Station Follower::copy(const Station &s) const {
  Station other = curve_->station();
  check(VecCopy(s.y, other.y), "noting a point");
  check(VecCopy(s.t, other.t), "noting a point");
  other.sign = s.sign, other.omega = s.omega;
  return other;
}

double Follower::plain_length(Vec t) const {
  PetscReal length;
  check(VecNorm(t, NORM_2, &length), "measuring arc length");
  return length;
}

// Of here_, which no step along the curve led to.
void Follower::begin_amplitude() {
  amplitude_ = (*meter_)(here_.y, here_.t);
  between_.begin({amplitude_.value, amplitude_.slope / plain_length(here_.t)});
  between_error_ = NAN;
}

// One accepted step along the curve, or what the ladder finds instead.
Follower::Go Follower::advance() {
  const double least = settings_.adaptive ? shortest_step : shortest_step * settings_.step;
  halvings_ = {};
  double corner_due = corner_step;
  for (double step = step_; step >= least; step /= 2) {
    Go go = try_step(step);
    for (int i = 0; i < most_refinements && go == Go::refined; ++i) go = try_step(step);
    if (go == Go::on) spare_harmonics();
    if (go != Go::refused) return go;
    ++summary_.counts.cuts;
    notify(BranchEvent::Kind::cut, refusal_ + ", step halved", here_.omega);
    if (Go go; settings_.adaptive && step <= corner_due) {
      if (round_corner(step, go)) return go;
      corner_due = step / 64;
    }
  }
  return settings_.adaptive ? climb() : end(End::stalled, refusal_);
}

double Follower::allowed_astray() const { return system_->samples() == exactly ? most_astray : most_astray_sampled; }

Follower::Go Follower::try_step(double step) {
  check(VecWAXPY(trial_.y, step, here_.t, here_.y), "predicting");
  check(VecCopy(trial_.y, predicted_), "predicting");
  branch_point_.reset();
  if (!(system_->omega(trial_.y) > 0)) {
    refusal_ = "the predicted frequency is not positive";
    halvings_ = {};
    return Go::refused;
  }
  const bool hurried = settings_.adaptive && step > least_newton_step; // more iterations would be refused
  if (!curve_->solve_across(here_.t, trial_, {false, hurried ? most_newton : 0, step})) {
    refusal_ = trial_.newton.why;
    halvings_ = {};
    return Go::refused;
  }
  check(VecAXPY(predicted_, -1, trial_.y), "measuring a correction");
  const Halvings::Measure measure{angle(curve_->norm, here_.t, trial_.t), curve_->norm.length(predicted_) / step,
                                  allowed_astray()};
  const bool corner = halvings_.add(measure);
  if (!settings_.adaptive) return refined_for(trial_) ? Go::refined : accept_step(here_.t, step);
  if (measure.refused() && !corner) {
    refusal_ = measure.angle > most_angle ? "the curve turns too far within one step"
                                          : "the solution lies too far from the predicted one";
    return Go::refused;
  }
  if (trial_.sign * here_.sign < 0) { // a hairpin was jumped over, or another branch crosses within the step
    refusal_ = "the curve turns round within one step";
    const bool smooth = measure.angle < straight && measure.correction < straight;
    if (smooth && leads_back(step, measure.correction * step))
      branch_point_ = locate_branch_point(step);
    else if (!(corner && step <= close_to_corner))
      return Go::refused;
  }
  const int newton = trial_.newton.newton;
  if (refined_for(trial_)) return Go::refined;
  const Go go = accept_step(here_.t, step);
  if (go != Go::on) return go;
  if (!corner) curvature_ = measure.angle / step;
  choose_step(step, measure.angle, newton);
  return go;
}

// The step to trial_, on planes across `normal`, with all that lies within; or round a corner, to where it is.
Follower::Go Follower::accept_step(Vec normal, double step, bool at_corner) {
  const Amplitude next = (*meter_)(trial_.y, trial_.t);
  const bool was_outside = beyond_start(here_.omega) > 0, outside = beyond_start(trial_.omega) > 0;
  const double plain = plain_length(normal);
  const Amplitude by_arc{next.value, next.slope / plain_length(trial_.t)};
  BetweenPoints between = between_;
  if (at_corner) between.begin(by_arc);
  const double between_error = at_corner ? NAN : between.add(step * plain, by_arc);
  if (!was_outside || !outside) {
    std::vector<Place> found;
    if (!find_places(normal, step, at_corner, next, found)) return Go::refused;
    between_error_ = between_error;
    if (report_places(found, plain) == Go::ended) return Go::ended;
  }
  if (outside && !was_outside)
    notify(BranchEvent::Kind::outside,
           "the curve leaves the sweep at its beginning: points beyond are not stored, the next is where it comes back",
           here_.omega);
  arclength_ += step * plain;
  std::swap(here_, trial_);
  amplitude_ = next, between_ = between;
  if (const double w = trial_.omega; direction_ * (here_.omega - w) < 0 && farther(w)) farthest_ = copy(trial_);
  if (!outside)
    report(here_, arclength_, verdict_ ? &*verdict_ : nullptr);
  else if (beyond_start(here_.omega) > most_beyond * std::min(omega_unit_, settings_.from))
    return end(End::turned_back, "the branch turned back, left the sweep at its beginning and did not come back");
  check(VecWAXPY(predicted_, -1, trial_.y, here_.y), "measuring a step");
  still_ = curve_->norm.swing(predicted_) < nothing * curve_->norm.length(predicted_) ? still_ + 1 : 0;
  curve_->norm.see(here_.y);
  anchor_arc_ += curve_->norm.length(predicted_), newer_arc_ += curve_->norm.length(predicted_);
  if (careful_ > 0) {
    --careful_; // over marks of the last time
  } else {
    const auto sense = trail_.add(system_->layout(), here_.y, here_.t, curve_->norm.largest_motion());
    if (sense != Trail::Sense::fresh) {
      const std::string why = sense == Trail::Sense::opposite ? "the branch runs back over itself"
                                                              : "the branch is closed: it came back to where it was";
      return follow_again(why) ? Go::on : end(End::retraced, why);
    }
  }
  if (++since_anchor_ >= anchored) {
    anchors_[0] = std::exchange(anchors_[1], copy(here_));
    anchor_arc_ = std::exchange(newer_arc_, 0.0), since_anchor_ = 0;
  }
  check(VecScale(here_.t, 1 / curve_->norm.length(here_.t)), "measuring arc length"); // by the norm as it is now
  return Go::on;
}

void Follower::choose_step(double step, double turned, int newton) {
  if (!settings_.adaptive) return;
  const double by_newton = std::pow(2.0, (aimed_newton - newton) / 2.0),
               by_angle = aimed_angle / std::max(turned, 1e-3);
  step_ = step * std::clamp(std::min(by_newton, by_angle), 0.5, 2.0);
  limit_step();
}

void Follower::limit_step() {
  if (!settings_.adaptive) return;
  step_ = std::min(step_, longest_step);
  if (const double rate = std::abs(system_->omega(here_.t)) / omega_unit_; rate > 0)
    step_ = std::min(step_, longest_omega_step / rate);
  if (const double rate = curve_->norm.motion(here_.t); rate > 0)
    step_ = std::min(step_, std::max(longest_motion_step * curve_->norm.motion(here_.y) / rate, shortest_motion_step));
  if (careful_ > 0) step_ = std::min(step_, careful_step_);
  step_ = std::max(step_, 10 * shortest_step);
}

// A curve that bends over may leave the sweep at its beginning and come back: it is followed there, but not reported.
double Follower::beyond_start(double omega) const { return (settings_.from - omega) * direction_; }

// Many bends within a small part of the sweep are no physics, but too few harmonics for contacts that open and close.
void Follower::note_bend(double omega) {
  bends_.push_back(omega);
  if (bends_.size() < many_bends) return;
  const auto [low, high] = std::minmax_element(bends_.end() - many_bends, bends_.end());
  if (*high - *low >= crowded_part * omega_unit_) return;
  crowded_ = bends_often;
}

// Nor are many short steps that come to nothing.
void Follower::note_creeping() {
  const long now = summary_.counts.newton;
  const auto near = [&](double omega) { return std::abs(omega - crowd_.omega) <= creeping_part * omega_unit_; };
  if (!near(here_.omega)) crowd_ = {here_.omega, now};
  if (now - crowd_.newton <= most_creeping || std::count_if(bends_.begin(), bends_.end(), near) < few_bends) return;
  crowded_ = "the curve bends again and again and makes no way";
  crowd_.newton = now;
}

// A curve that winds on between frequencies it has met, for as many iterations as a whole sweep may take, and as some
// seconds hold if it is small, is left: the frequencies ahead are what was asked for. The more often, the sooner.
bool Follower::winds() {
  const long now = summary_.counts.newton;
  const auto beyond = [&](double omega) { return direction_ * (here_.omega - omega); };
  if (windings_ > 0 && beyond(left_at_) > enough_ahead * omega_unit_) windings_ = 0;
  if (beyond(ahead_.omega) > least_ahead * omega_unit_) ahead_ = {here_.omega, now};
  const double unknowns = static_cast<double>(system_->layout().dofs() * system_->layout().width);
  const double patience = std::max(least_patience, most_wound / unknowns) / (1 << std::min(windings_, most_halved));
  return settings_.adaptive && !settings_.steps_only && static_cast<double>(now - ahead_.newton) > patience &&
         farthest_ && beyond(farthest_->omega) < 0 &&
         (!stay_until_ || direction_ * (farthest_->omega - *stay_until_) > least_ahead * omega_unit_);
}

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
      if (!left) stay_until_ = turned; // it is followed on
      ahead_.newton = summary_.counts.newton;
    }
  }
  if (!ended_ && still_ == enough_still) {
    still_ = 0;
    refusal_ =
        "from here on the curve is a straight line at one frequency, along which mean positions change and nothing "
        "else: any of them is a solution, and beyond the body walks away";
    if (!leap(Way::newton, here_.omega) && !leap(Way::integration, here_.omega)) end(End::stalled, refusal_);
  }
  if (observer_.state) observer_.state(state());
  return ended_ ? Go::ended : Go::on;
}

void Follower::report(Station &s, double arclength, const Stability *stability, bool place) {
  ++summary_.counts.points;
  observer_.point({s.y, *system_, s.omega, arclength, s.newton, s.activity, stability,
                   !estimator_ ? nullptr
                   : place     ? &error_of(s)
                               : &affordable_error_of(s),
                   between_error_, 1 - std::abs(settings_.to - s.omega) / omega_unit_});
}

void Follower::notify(BranchEvent::Kind kind, const std::string &text, double omega, double amplitude) {
  observer_.event({kind, text, omega, amplitude});
}

// At either end, then in between, towards `to`.
BranchSummary follow_branch(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings, Vec y,
                            const BranchObserver &observer, const BranchState *state) {
  BranchSettings other = settings;
  if (state) {
    const bool reversed = state->numbers.at(8) * (settings.to - settings.from) < 0; // begun at the other end
    other.from = state->numbers.at(9), other.to = reversed ? settings.from : settings.to;
    return Follower(system, newton, other, observer).go_on(*state);
  }
  other.both_ends = true;
  const BranchSummary summary = Follower(system, newton, other, observer).run(y, "");
  other.both_ends = false;
  if (summary.end != BranchSummary::End::no_start || settings.from == settings.to) return summary;
  const auto begun_at = [&](const std::string &where) {
    check(VecSet(y, 0), "starting elsewhere");
    return Follower(system, newton, other, observer).run(y, "no solution was found at " + where);
  };
  std::swap(other.from, other.to);
  BranchSummary from_there = begun_at("the other end of the sweep: begun at this one, towards it");
  other.to = settings.to, other.briefly = true;
  for (const double part : {0.02, 0.2, 0.35, 0.5, 0.65, 0.8}) {
    if (from_there.end != BranchSummary::End::no_start) return from_there;
    other.from = settings.from + part * (settings.to - settings.from);
    from_there = begun_at("either end of the sweep: begun at this frequency, towards " +
                          std::string(settings.to < settings.from ? "lower" : "higher") + " ones");
  }
  return from_there.end == BranchSummary::End::no_start ? summary : from_there;
}

} // namespace dovetail
