#include "continuation/stepper.hpp"

#include <algorithm>
#include <cmath>

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr int kink_again = 64; // after all legs were tried in vain: so many times shorter

} // namespace

Stepper::Outcome Stepper::advance() {
  const double least = control_.shortest();
  halvings_ = {};
  double kink_due = step_limits.kink_step;
  int waiting = iterations_are_expensive() ? kinks_in_vain_ : 0; // halvings before all legs of a kink are tried
  for (double step = control_.step(); step >= least; step /= 2) {
    Outcome outcome = try_step(step);
    for (int i = 0; i < step_limits.most_refinements && outcome == Outcome::refined; ++i) outcome = try_step(step);
    if (outcome == Outcome::on) stepped();
    if (outcome != Outcome::refused) return outcome;
    halved(refusal_);
    if (!control_.adaptive() || step > kink_due) continue;
    const bool all = waiting-- <= 0;
    const bool found = round_kink(step, all ? Extent::all : Extent::first, outcome);
    if (all) kinks_in_vain_ = found ? 0 : std::min(kinks_in_vain_ + 1, step_limits.most_waiting);
    if (found) return outcome;
    if (all) kink_due = step / kink_again;
  }
  return no_step();
}

double Stepper::allowed_astray() const { return curve_->problem.is_smooth() ? most_astray : most_astray_rough; }

StepMeasure Stepper::measured(double step) {
  check(VecAXPY(predicted_, -1, trial_.y), "measuring a correction");
  return {angle(curve_->norm, here_.t, trial_.t), curve_->norm.length(predicted_) / step, allowed_astray()};
}

// trial_ becomes the point a step along the curve, if Newton's method finds one.
bool Stepper::solve_trial(double step) {
  check(VecWAXPY(trial_.y, step, here_.t, here_.y), "predicting");
  check(VecCopy(trial_.y, predicted_), "predicting");
  if (before_ && step == control_.step()) curve_->bend(*before_, here_, step, trial_.y); // else there may be a kink
  branch_point_.reset();
  if (!curve_->problem.is_admissible(parameter_of(trial_.y))) {
    refusal_ = "the predicted " + curve_->problem.parameter().name + " is not positive";
    return false;
  }
  const bool hurried = control_.adaptive() && step > step_limits.least_newton_step; // more would be refused
  if (curve_->solve_across(here_.t, trial_, {false, hurried ? step_limits.most_newton : 0, step})) return true;
  refusal_ = trial_.newton.why;
  return false;
}

// Whether trial_ and here_ hang together, by all checks in turn.
bool Stepper::belongs(double step, const StepMeasure &measure, bool kink) {
  if (measure.refused() && !kink) {
    refusal_ = measure.why();
    return false;
  }
  if (!kink && curve_->problem.is_smooth() && step > step_limits.close_to_kink &&
      curve_->off_middle(here_, trial_) > step_limits.most_off_middle) {
    refusal_ = "the curve does not run smoothly from one end of the step to the other";
    return false;
  }
  if (trial_.sign * here_.sign >= 0) return true;
  refusal_ = "the curve turns round within one step"; // a hairpin was jumped over, or another branch crosses
  const bool straight = measure.angle < step_limits.straight && measure.correction < step_limits.straight;
  if (straight && locator().leads_back(step, measure.correction * step)) {
    branch_point_ = locator().branch_point(step);
    return true;
  }
  return kink && step <= step_limits.close_to_kink;
}

Stepper::Outcome Stepper::try_step(double step) {
  if (!solve_trial(step)) {
    halvings_ = {};
    return Outcome::refused;
  }
  const StepMeasure measure = measured(step);
  const bool kink = halvings_.add(measure);
  if (control_.adaptive() && !belongs(step, measure, kink)) return Outcome::refused;
  const int newton = trial_.newton.newton;
  if (refine(trial_)) return Outcome::refined;
  const Outcome outcome = accept_step(here_.t, step);
  if (outcome != Outcome::on || !control_.adaptive()) return outcome;
  if (!kink) curvature_ = measure.angle / step;
  control_.after(step, measure.angle, newton);
  limit_step();
  return outcome;
}

// The step to trial_, on planes across `normal`, with all that lies within; or round a kink, to where it is.
Stepper::Outcome Stepper::accept_step(Vec normal, double step, bool at_kink) {
  PetscReal plain;
  check(VecNorm(normal, NORM_2, &plain), "measuring arc length");
  const Outcome outcome = pass(normal, step, plain, at_kink);
  if (outcome != Outcome::on) return outcome;
  if (control_.adaptive() && curve_->problem.is_smooth() && !at_kink)
    note(before_, trial_);
  else
    before_.reset();
  check(VecWAXPY(predicted_, -1, trial_.y, here_.y), "measuring a step");
  return settle(predicted_);
}

Stepper::Outcome Stepper::settle(Vec) {
  curve_->norm.see(here_.y);
  measure_anew();
  return Outcome::on;
}

void Stepper::measure_anew() { check(VecScale(here_.t, 1 / curve_->norm.length(here_.t)), "measuring arc length"); }

void Stepper::note(std::optional<CurvePoint> &place, const CurvePoint &s) const {
  if (!place) place = curve_->point();
  check(VecCopy(s.y, place->y), "noting a point");
  check(VecCopy(s.t, place->t), "noting a point");
  place->sign = s.sign, place->parameter = s.parameter;
}

void Stepper::limit_step() {
  if (!control_.adaptive()) return;
  control_.limit({std::abs(parameter_of(here_.t)) / unit_, curve_->norm.motion(here_.t), curve_->norm.motion(here_.y)},
                 curve_->problem.is_smooth());
}

void Stepper::take_curve(Curve &curve) {
  curve_ = &curve;
  here_ = curve.point(), trial_ = curve.point();
  predicted_ = curve.problem.unknowns();
  before_.reset();
}

void Stepper::archive_steps(Archive &archive) {
  control_.archive(archive);
  archive.field("sign", here_.sign);
  archive.field("newton", here_.newton.newton);
  archive.field("curvature", curvature_);
  archive.field("kinks_in_vain", kinks_in_vain_);
}

} // namespace dovetail
