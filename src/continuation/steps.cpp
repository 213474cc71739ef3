// Steps along the curve: guess, correction, what is refused, how long the next one is.
#include <algorithm>
#include <cmath>
#include <utility>

#include "continuation/follower.hpp"

namespace dovetail {
namespace {

constexpr double rounding = 1e-9; // so that one of these lengths stays what it is

} // namespace

// One accepted step along the curve, or what the ladder finds instead.
Follower::Go Follower::advance() {
  const double least = settings_.adaptive ? shortest_step : shortest_step * settings_.step;
  halvings_ = {};
  double corner_due = corner_step;
  int waiting = dear() ? corners_in_vain_ : 0; // halvings before all legs of a corner are tried
  for (double step = step_; step >= least; step /= 2) {
    Go go = try_step(step);
    for (int i = 0; i < most_refinements && go == Go::refined; ++i) go = try_step(step);
    if (go == Go::on) spare_harmonics();
    if (go != Go::refused) return go;
    ++summary_.counts.cuts;
    notify(BranchEvent::Kind::cut, refusal_ + ", step halved", here_.omega);
    if (settings_.adaptive && step <= corner_due) {
      const bool all = waiting-- <= 0;
      const bool found = round_corner(step, all ? Extent::all : Extent::first, go);
      if (all) corners_in_vain_ = found ? 0 : std::min(corners_in_vain_ + 1, most_waiting);
      if (found) return go;
      if (all) corner_due = step / 64;
    }
  }
  return settings_.adaptive ? climb() : end(End::stalled, refusal_);
}

bool Follower::exact() const { return system_->samples() == exactly; } // sampled contact forces make teeth

double Follower::allowed_astray() const { return exact() ? most_astray : most_astray_sampled; }

Follower::Go Follower::try_step(double step) {
  check(VecWAXPY(trial_.y, step, here_.t, here_.y), "predicting");
  check(VecCopy(trial_.y, predicted_), "predicting");
  if (before_ && step == step_) curve_->bend(*before_, here_, step, trial_.y); // else there may be a corner
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
  if (!corner && exact() && step > close_to_corner && curve_->off_middle(here_, trial_) > most_off) {
    refusal_ = "the curve does not run smoothly from one end of the step to the other";
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
  const Go go = pass_to_trial(normal, step, plain_length(normal), at_corner);
  if (go != Go::on) return go;
  if (settings_.adaptive && exact() && !at_corner)
    note(before_, trial_);
  else
    before_.reset();
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
      if (trail_.met_left()) return end(End::turned_back, "the branch came back to a piece of it that had been left");
      return follow_again(why) ? Go::on : end(End::retraced, why);
    }
  }
  if (++since_anchor_ >= anchored) {
    std::swap(anchors_[0], anchors_[1]);
    note(anchors_[1], here_);
    anchor_arc_ = std::exchange(newer_arc_, 0.0), since_anchor_ = 0;
  }
  check(VecScale(here_.t, 1 / curve_->norm.length(here_.t)), "measuring arc length"); // by the norm as it is now
  return Go::on;
}

// here_ becomes trial_, `step` farther on along the curve, or `plain` times that in the plain norm; with all that lies
// within, and nothing where the curve has left the sweep.
Follower::Go Follower::pass_to_trial(Vec normal, double step, double plain, bool at_corner) {
  const Amplitude next = (*meter_)(trial_.y, trial_.t);
  const bool was_outside = beyond_start(here_.omega) > 0, outside = beyond_start(trial_.omega) > 0;
  const Amplitude by_arc{next.value, next.slope / plain_length(trial_.t)};
  BetweenPoints between = between_;
  if (at_corner) between.begin(by_arc);
  const double between_error = at_corner ? NAN : between.add(step * plain, by_arc);
  if (!was_outside || !outside) {
    std::vector<Place> found;
    if (!find_places(normal, step, at_corner, next, found)) return Go::refused;
    between_error_ = between_error;
    if (report_places(found, plain, at_corner) == Go::ended) return Go::ended;
  }
  if (outside && !was_outside)
    notify(BranchEvent::Kind::outside,
           "the curve leaves the sweep at its beginning: points beyond are not stored, the next is where it comes back",
           here_.omega);
  arclength_ += step * plain;
  std::swap(here_, trial_);
  amplitude_ = next, between_ = between;
  if (const double w = trial_.omega; direction_ * (here_.omega - w) < 0 && farther(w)) note(farthest_, trial_);
  if (!outside)
    report(here_, arclength_, verdict_ ? &*verdict_ : nullptr);
  else if (beyond_start(here_.omega) > most_beyond * std::min(omega_unit_, settings_.from))
    return end(End::turned_back, "the branch turned back, left the sweep at its beginning and did not come back");
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
  // Of few lengths, since tangents are known to 1e-6 only; not among teeth, where any other step lands on another one.
  if (exact()) step_ = std::exp2(std::floor(8 * std::log2(step_) + rounding) / 8);
}

} // namespace dovetail
