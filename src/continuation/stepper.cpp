#include "continuation/stepper.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "continuation/predictor.hpp"
#include "continuation/step_check.hpp"
#include "support/error.hpp"

namespace dovetail {

Stepper::Outcome Stepper::advance() {
  if (!ahead_.empty()) {
    trial_ = std::move(ahead_.back());
    ahead_.pop_back();
    halvings_ = {};
    check(VecScale(trial_.t, 1 / curve_->norm.length(trial_.t)), "measuring arc length"); // the metric may have grown
    forget_plain_length(trial_.t);    // as for a restart, which has to measure it; a factor of 1 would leave it known
    curve_->recall(curve_->memory()); // and has no factors at hand
    const double step = length_to(trial_);
    const Outcome outcome = step > 0 ? take_trial(step) : Outcome::refused;
    if (outcome == Outcome::on) stepped();
    if (outcome == Outcome::on || outcome == Outcome::ended) return outcome;
    ahead_.clear();
  }
  const double least = control_.shortest();
  halvings_ = {};
  double kink_due = step_limits.kink_step;
  for (double step = control_.step(); step >= least; step /= 2) {
    Outcome outcome = try_step(step);
    for (int i = 0; i < step_limits.most_refinements && outcome == Outcome::refined; ++i) outcome = try_step(step);
    if (outcome == Outcome::on) stepped();
    if (outcome != Outcome::refused) return outcome;
    ahead_.clear();
    halved(refusal_);
    if (!control_.adaptive() || step > kink_due) continue;
    if (round_kink(step, outcome)) return outcome;
    kink_due = step * step_limits.close_to_kink / step_limits.kink_step; // so the second try is at close_to_kink
  }
  return no_step();
}

// trial_ becomes the point a step along the curve, if Newton's method finds one.
bool Stepper::solve_trial(double step) {
  if (before_ && step == control_.step()) // else there may be a kink
    CubicPredictor(curve_->norm, *before_).predict(here_, step, trial_.y);
  else
    TangentPredictor().predict(here_, step, trial_.y);
  branch_point_.reset();
  if (!curve_->problem.is_admissible(parameter_of(trial_.y))) {
    refusal_ = "the predicted " + curve_->problem.parameter().name + " is not positive";
    return false;
  }
  const bool hurried = control_.adaptive() && step > step_limits.close_to_kink; // more would be refused
  if (curve_->solve_across(here_.t, trial_, {false, hurried ? step_limits.most_newton : 0, step})) return true;
  refusal_ = trial_.newton.why;
  return false;
}

// Whether trial_ and here_ hang together.
bool Stepper::belongs(double step, const StepMeasure &measure, bool kink) {
  Trial trial{*curve_, here_, trial_, step, measure, kink, locator()};
  const auto why = refused(trial);
  branch_point_ = std::move(trial.branch_point), off_ = trial.off, middle_ = std::move(trial.middle);
  if (why) refusal_ = *why;
  return !why;
}

Stepper::Outcome Stepper::try_step(double step) {
  if (!solve_trial(step)) {
    halvings_ = {};
    return Outcome::refused;
  }
  return take_trial(step);
}

// What the step to trial_, a solution that far along the tangent, is worth.
Stepper::Outcome Stepper::take_trial(double step) {
  TangentPredictor().predict(here_, step, predicted_);
  check(VecAXPY(predicted_, -1, trial_.y), "measuring a correction");
  const std::vector<double> products = curve_->norm.products({{here_.t, trial_.t}, {predicted_, predicted_}});
  const StepMeasure measure{angle_of(products[0]), std::sqrt(products[1]) / step, curve_->problem.is_smooth()};
  const bool kink = halvings_.add(measure);
  off_ = {0, 0};
  const bool jump = control_.adaptive() && !belongs(step, measure, kink);
  if (jump && !takes_jump(measure.correction * step)) return Outcome::refused;
  if (jump) off_ = {0, 0};
  const bool hides = off_.part > step_limits.most_hidden && curve_->problem.resonates();
  if (off_.length > control_.between() || hides) return refine_drawing(step);
  const int newton = trial_.newton.newton;
  if (refine(trial_)) return Outcome::refined;
  const Outcome outcome = accept_step(here_.t, step, jump);
  if (jump && outcome != Outcome::refused) jumped();
  if (outcome != Outcome::on || !control_.adaptive()) return outcome;
  if (!kink && !jump) curvature_ = measure.angle / step;
  control_.after(step, measure.angle, newton, off_.length, curve_->problem.is_smooth());
  limit_step();
  return outcome;
}

// A point about half way to trial_, `whole` ahead, becomes the trial; what trial_ was is kept for the next step. By the
// plain norm the middle of what is drawn may lie ahead of its end.
Stepper::Outcome Stepper::refine_drawing(double whole) {
  ahead_.push_back(std::move(trial_));
  trial_ = curve_->point();
  trial_.y = std::move(middle_);
  branch_point_.reset();
  const double step = length_to(trial_);
  Outcome outcome = Outcome::refused;
  if (0 < step && step < step_limits.most_of_middle * whole &&
      curve_->solve_across(here_.t, trial_, {false, step_limits.most_newton, step}))
    outcome = take_trial(step);
  else
    refusal_ = "the middle of the step is not found";
  if (outcome == Outcome::refused) halvings_ = {}; // of this step alone
  return outcome;
}

double Stepper::length_to(const CurvePoint &point) const {
  return curve_->plane(here_.t, point.y) - curve_->plane(here_.t, here_.y);
}

// The step to trial_, on planes across `normal`, with all that lies within; or round a kink, to where it is.
Stepper::Outcome Stepper::accept_step(Vec normal, double step, bool at_kink) {
  const Outcome outcome = pass(normal, step, at_kink);
  if (outcome != Outcome::on) return outcome;
  if (control_.adaptive() && curve_->problem.is_smooth() && !at_kink)
    note(before_, trial_);
  else
    before_.reset();
  check(VecWAXPY(predicted_, -1, trial_.y, here_.y), "measuring a step");
  return settle(predicted_);
}

// True if a leg beyond a kink was taken; `outcome` says how that went.
bool Stepper::round_kink(double step, Outcome &outcome) {
  const double from = here_.parameter;
  const auto take = [&](const KinkTurn::Leg &leg) {
    branch_point_.reset();
    outcome = accept_step(leg.normal, leg.way, leg.at_kink);
    if (outcome == Outcome::refused) return false;
    if (leg.at_kink) turned_kink(leg.turned, from);
    if (outcome == Outcome::on) {
      control_.set(leg.step);
      limit_step();
    }
    return true;
  };
  return KinkTurn(*curve_, here_, trial_, curvature_, iterations_are_expensive(), take).turn(step);
}

Stepper::Outcome Stepper::settle(Vec) {
  curve_->norm.see(here_.y);
  measure_anew();
  return Outcome::on;
}

void Stepper::measure_anew() {
  const std::vector<double> squares = curve_->norm.products({{here_.t, here_.t}}, {here_.t, here_.y}, {here_.t});
  scale_known(here_.t, 1 / std::sqrt(squares[0]));
  speed_ = std::sqrt(squares[1] / squares[0]), motion_ = std::sqrt(squares[2]);
}

void Stepper::note(std::optional<CurvePoint> &place, const CurvePoint &s) const {
  if (!place) place = curve_->point();
  check(VecCopy(s.y, place->y), "noting a point");
  check(VecCopy(s.t, place->t), "noting a point");
  place->sign = s.sign, place->parameter = s.parameter;
}

void Stepper::limit_step() {
  if (!control_.adaptive()) return;
  const double rate = curve_->problem.resonates() ? std::abs(parameter_of(here_.t)) / unit_ : 0;
  control_.limit({rate, speed_, motion_}, curve_->problem.is_smooth());
}

void Stepper::take_curve(Curve &curve) {
  curve_ = &curve;
  here_ = curve.point(), trial_ = curve.point();
  predicted_ = curve.problem.unknowns();
  forget_steps();
}

void Stepper::archive_steps(Archive &archive) {
  control_.archive(archive);
  archive.field("sign", here_.sign);
  archive.field("newton", here_.newton.newton);
  archive.field("curvature", curvature_);
  double length = archive.restores() ? 0 : plain_length(here_.t); // to the last bit, which scaling has rounded
  archive.field("tangent_length", length);
  if (archive.restores()) note_plain_length(here_.t, length);
}

} // namespace dovetail
