#include "analyses/backbone.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "analyses/backbone_stepper.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

using End = BranchSummary::End;

constexpr const char *doing = "following a mode";
constexpr double begin_below = 0.5;     // of the onset, where the mode is a straight line there
constexpr double begin_slipping = 1e-3; // of the next onset, where some point slips from amplitude 0 on
constexpr double short_of = 1e-9;       // relative, of the onset: the step to it ends before the corner
constexpr double least_alike = 0.9;     // cosine between the shape and the one that the phase is referred to

} // namespace

// The mode of the stuck structure, with what its damping feeds on.
void Backbone::set_stuck(double amplitude) {
  const Layout &layout = mode_.system().layout();
  const auto write = [&](double ratio) {
    double *own;
    check(VecGetArray(here_.y, &own), doing);
    std::fill_n(own, layout.own_coefficients(), 0.0);
    for (PetscInt d = 0; d < layout.own_dofs(); ++d) {
      own[d * layout.width + cosine(1)] = settings_.shape[d].real();
      own[d * layout.width + sine(1)] = -settings_.shape[d].imag();
    }
    const double last[] = {settings_.omega, ratio, std::log10(amplitude)};
    if (layout.owns_omega()) std::copy_n(last, 3, own + layout.own_coefficients());
    check(VecRestoreArray(here_.y, &own), doing);
  };
  write(0);
  mode_.refer_to(here_.y);
  write(balance_of(mode_, mode_.evaluate(here_.y)).ratio());
}

bool Backbone::solve_at(double amplitude, CurvePoint &s) {
  if (!curve_->solve_at(std::log10(amplitude), s)) return false;
  curve_->norm.see(s.y);
  return true;
}

void Backbone::begin() {
  const double first = std::min(
      settings_.from, settings_.onset < INFINITY ? (settings_.straight ? begin_below : begin_slipping) * settings_.onset
                                                 : settings_.from);
  least_ = std::log10(first);
  set_stuck(first);
  here_.parameter = least_;
  curve_->norm.see(here_.y);
  if (!solve_at(first, here_)) {
    end(End::no_start, "no mode was found at a small amplitude: " + here_.newton.why);
    return;
  }
  mode_.refer_to(here_.y);
  keep(load_at(here_.y));
  if (first >= settings_.from || enough(load_)) report(here_, 0, false);
  if (settings_.to_force > 0 && load_ > 0) at_force_ = std::pow(10, here_.parameter) * settings_.to_force / load_;
  straight_ = settings_.straight;
  if (!straight_) begin_steps();
}

void Backbone::begin_steps() {
  straight_ = false;
  measure_anew();
  control_.set(settings_.step / plain_length(here_.t));
  limit_step();
}

// Below the onset nothing but the amplitude changes, and the load in proportion to it.
bool Backbone::go_straight() {
  const double last = std::min(settings_.onset * (1 - short_of), settings_.to);
  std::vector<double> stops{at_force_, last};
  if (here_.parameter < std::log10(settings_.from)) stops.push_back(settings_.from);
  stops.insert(stops.end(), settings_.at.begin(), settings_.at.end());
  std::sort(stops.begin(), stops.end());
  for (const double stop : stops) {
    if (stop > last || (stop != at_force_ && std::log10(stop) <= here_.parameter)) continue;
    if (!goes_on()) return false;
    if (!solve_at(stop, here_)) return end(End::stalled, here_.newton.why);
    if (stop >= settings_.from || stop == at_force_) report(here_, 0, false);
    if (stop == at_force_) return end(End::arrived);
    keep(load_at(here_.y));
  }
  if (last >= settings_.to) return end(End::arrived);
  begin_steps();
  return true;
}

// Between two steps: where does it stand, and may it go on.
bool Backbone::goes_on() {
  farthest_ = std::max(farthest_, here_.parameter);
  tell_state();
  if (summary_.counts.points >= settings_.max_points)
    return end(End::max_points, "stopped at continuation.max_points = " + std::to_string(settings_.max_points));
  return !interrupted() || end(End::interrupted, "interrupted");
}

void Backbone::follow() {
  while (!ended_ && goes_on()) advance();
}

void Backbone::report_fold(Vec normal, double step) {
  if (parameter_of(here_.t) * parameter_of(trial_.t) >= 0) return;
  auto fold = locator().within(normal, step, {parameter_of(here_.t), parameter_of(trial_.t)},
                               [](CurvePoint &s) { return parameter_of(s.t); });
  if (!fold) return;
  ++summary_.counts.folds;
  if (fold->at.parameter < std::log10(settings_.from)) return;
  report(fold->at, arclength_ + curve_->chord(here_.y, fold->at.y), true);
  notify(BranchEvent::Kind::fold, "the mode turns back in its amplitude", fold->at.parameter);
}

// Where the load of the case has reached the factor within the step.
std::optional<Located> Backbone::at_force(Vec normal, double step, double force) {
  return locator().within(normal, step, {load_ - settings_.to_force, force - settings_.to_force},
                          [&](CurvePoint &s) { return load_at(s.y) - settings_.to_force; });
}

// log10 of the amplitudes wanted within the step, in its order, and whether the mode ends there.
std::vector<std::pair<double, bool>> Backbone::wanted() const {
  const double a = here_.parameter, b = trial_.parameter;
  std::vector<std::pair<double, bool>> values;
  const auto want = [&](double amplitude, bool last) {
    const double value = std::log10(amplitude);
    if ((value - a) * (value - b) < 0 || value == b) values.emplace_back(value, last);
  };
  if (settings_.from < settings_.to) want(settings_.from, false);
  for (const double amplitude : settings_.at)
    if (amplitude != settings_.from && amplitude != settings_.to) want(amplitude, false);
  want(settings_.to, true);
  std::sort(values.begin(), values.end());
  if (b < a) std::reverse(values.begin(), values.end());
  return values;
}

// Of the step, at one of them; the mode ends at the last one, which has to have a solution.
Stepper::Outcome Backbone::pass_wanted(double value, bool last) {
  const double part = (value - here_.parameter) / (trial_.parameter - here_.parameter);
  CurvePoint s = curve_->point();
  check(VecWAXPY(s.y, -1, here_.y, trial_.y), doing);
  check(VecAYPX(s.y, part, here_.y), doing);
  if (!curve_->solve_at(value, s)) {
    ++summary_.counts.missed;
    notify(BranchEvent::Kind::missed, "an amplitude that was asked for has no solution", value);
    return last ? Outcome::refused : Outcome::on;
  }
  report(s, arclength_ + curve_->chord(here_.y, s.y), true);
  return last ? arrive(s) : Outcome::on;
}

Stepper::Outcome Backbone::arrive(CurvePoint &s) {
  std::swap(here_, s);
  end(End::arrived);
  return Outcome::ended;
}

Stepper::Outcome Backbone::pass(Vec normal, double step, bool at_kink) {
  const double force = load_at(trial_.y), way = trial_.parameter - here_.parameter;
  const auto values = wanted();
  const bool crossed = enough(force) && !enough(load_);
  std::optional<Located> reached; // nothing in a kink, or where it is not found: then trial_ is where the mode ends
  if (!at_kink) {
    if (crossed) reached = at_force(normal, step, force);
    report_fold(normal, step);
  }
  for (const auto &[value, last] : values) {
    if (reached && (value - reached->at.parameter) * way > 0) break;
    if (const Outcome outcome = pass_wanted(value, last); outcome != Outcome::on) return outcome;
  }
  if (reached) {
    report(reached->at, arclength_ + curve_->chord(here_.y, reached->at.y), true);
    return arrive(reached->at);
  }
  arclength_ += curve_->chord(here_.y, trial_.y);
  std::swap(here_, trial_);
  keep(force);
  const bool told = !values.empty() && values.back().first == here_.parameter;
  if ((crossed || here_.parameter >= std::log10(settings_.from)) && !told) report(here_, arclength_, false);
  if (crossed) {
    end(End::arrived);
    return Outcome::ended;
  }
  if (here_.parameter >= least_) return Outcome::on;
  end(End::turned_back, "the mode turned back to amplitudes below those it began with");
  return Outcome::ended;
}

// The phase stays referred to one shape while the mode is like it; then to the one at hand, which is turned to fit.
Stepper::Outcome Backbone::settle(Vec way) {
  const Outcome outcome = Stepper::settle(way);
  if (mode_.along_reference(here_.y) < least_alike) {
    mode_.refer_to(here_.y);
    UniqueVec normal = mode_.unknowns();
    check(VecCopy(here_.t, normal), doing);
    curve_->solve_across(normal, here_);
    measure_anew();
    forget_steps();
  }
  return outcome;
}

void Backbone::report(const CurvePoint &s, double arclength, bool located) {
  ++summary_.counts.points;
  const ModeState state = mode_.evaluate(s.y);
  const double begin = std::log10(settings_.from), end = std::log10(settings_.to);
  const double progress = s.parameter >= end ? 1 : (s.parameter - begin) / (end - begin);
  observer_.point({mode_, state, balance_of(mode_, state), arclength, s.newton, progress, located});
}

BranchSummary follow_backbone(HarmonicSystem &system, const NewtonSettings &newton, const BackboneSettings &settings,
                              const BackboneObserver &observer, const BranchState *state) {
  return Backbone(system, newton, settings, observer).run(state);
}

} // namespace dovetail
