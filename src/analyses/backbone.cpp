#include "analyses/backbone.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "analyses/saved_points.hpp"
#include "continuation/stepper.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

using End = BranchSummary::End;

constexpr const char *doing = "following a mode";
constexpr double decade = 1;        // counts as much as the largest motion
constexpr double longest_unit = 2;  // StepAims::parameter of it is a tenth of a decade, which readers interpolate in
constexpr double begin_below = 0.5; // of the onset, where the mode is a straight line there
constexpr double begin_slipping = 1e-3; // of the next onset, where some point slips from amplitude 0 on
constexpr double short_of = 1e-9;       // relative, of the onset: the step to it ends before the corner
constexpr double least_alike = 0.9;     // cosine between the shape and the one that the phase is referred to

class Backbone : public Stepper {
public:
  Backbone(HarmonicSystem &system, const NewtonSettings &newton, const BackboneSettings &settings,
           const BackboneObserver &observer)
      : Stepper(StepControl(true, settings.step, settings.between), longest_unit, newton.step_tolerance),
        settings_(settings), observer_(observer), mode_(system), own_(mode_, newton, decade, true, counts_) {
    take_curve(own_);
  }

  BranchSummary run(const BranchState *state) {
    if (state)
      restore(*state);
    else
      begin();
    if (!ended_ && enough(load_)) {
      tell_state();
      end(End::arrived, "mode.to_force is reached at the first amplitude already");
    }
    if (!ended_ && (!straight_ || go_straight())) follow();
    summary_.counts.newton = counts_.newton, summary_.counts.linear = counts_.linear;
    summary_.counts.inexact = counts_.inexact;
    summary_.parameter = std::pow(10, here_.parameter);
    summary_.farthest = std::pow(10, std::max(farthest_, here_.parameter));
    return summary_;
  }

private:
  void begin();
  void begin_steps();
  bool go_straight();
  void follow();
  bool goes_on();
  void restore(const BranchState &state);
  BranchState state();
  void tell_state() { // results of a run before stay until there is a point
    if (observer_.state && summary_.counts.points > 0) observer_.state(state());
  }
  void archive(Archive &archive, SavedVectors &vectors);
  void set_stuck(double amplitude);
  bool solve_at(double amplitude, CurvePoint &s);
  void report(const CurvePoint &s, double arclength, bool located);
  void report_fold(Vec normal, double step);
  std::optional<Located> at_force(Vec normal, double step, double force);
  double load_at(Vec y) { return balance_of(mode_, mode_.evaluate(y)).load; }
  void keep(double load) { // infinite where the load does no work: nothing is reached there
    if (std::isfinite(load)) load_ = load;
  }
  bool enough(double load) const { return settings_.to_force > 0 && std::isfinite(load) && load >= settings_.to_force; }
  bool end(End how, const std::string &why = "") {
    summary_.end = how, summary_.why = why;
    ended_ = true;
    return false;
  }
  bool interrupted() { return observer_.interrupted && observer_.interrupted(); }
  void notify(BranchEvent::Kind kind, const std::string &text, double parameter) {
    observer_.event({kind, text, std::pow(10, parameter)});
  }

  std::vector<std::pair<double, bool>> wanted() const;
  Outcome pass_wanted(double value, bool last);
  Outcome arrive(CurvePoint &s);

  Outcome pass(Vec normal, double step, bool at_kink) override;
  Outcome settle(Vec way) override;
  void halved(const std::string &why) override {
    ++summary_.counts.cuts;
    notify(BranchEvent::Kind::cut, why + ", step halved", here_.parameter);
  }
  void turned_kink(double angle, double parameter) override {
    ++summary_.counts.corners;
    notify(BranchEvent::Kind::corner,
           "corner of the curve, turning by " + std::to_string(std::lround(angle * 180 / M_PI)) + " degrees",
           parameter);
  }
  Outcome no_step() override {
    end(End::stalled, refusal_);
    return Outcome::ended;
  }

  const BackboneSettings &settings_;
  const BackboneObserver &observer_;
  SolveCounts counts_;
  BranchSummary summary_;
  NonlinearMode mode_;
  Curve own_;
  double arclength_ = 0, load_ = 0; // at here_
  double least_ = 0;                // log10 of the amplitude it begins at
  bool straight_ = false;           // here_ lies where the mode is a straight line
  double at_force_ = INFINITY;      // amplitude there with the force to be reached
  double farthest_ = -HUGE_VAL;     // log10 of the largest amplitude of a point so far
  bool ended_ = false;
};

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
  auto fold = locator().between(normal, {0, here_.y, parameter_of(here_.t), here_.t},
                                {step, trial_.y, parameter_of(trial_.t), trial_.t},
                                [](CurvePoint &s) { return parameter_of(s.t); });
  if (!fold) return;
  ++summary_.counts.folds;
  if (fold->at.parameter < std::log10(settings_.from)) return;
  report(fold->at, arclength_ + curve_->chord(here_.y, fold->at.y), true);
  notify(BranchEvent::Kind::fold, "the mode turns back in its amplitude", fold->at.parameter);
}

// Where the load of the case has reached the factor within the step.
std::optional<Located> Backbone::at_force(Vec normal, double step, double force) {
  return locator().between(normal, {0, here_.y, load_ - settings_.to_force, here_.t},
                           {step, trial_.y, force - settings_.to_force, trial_.t},
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

BranchState Backbone::state() {
  const Layout &layout = mode_.system().layout();
  BranchState state;
  state.harmonics = mode_.system().harmonics(), state.samples = mode_.system().samples();
  SavedVectors vectors(layout);
  vectors.add(here_.y), vectors.add(here_.t);
  Archive brought, saved;
  archive(brought, vectors);
  vectors.bring();
  state.y = vectors.take(), state.tangent = vectors.take();
  state.counts = summary_.counts;
  state.counts.newton = counts_.newton, state.counts.linear = counts_.linear, state.counts.inexact = counts_.inexact;
  archive(saved, vectors);
  state.fields = saved.fields();
  return state;
}

void Backbone::restore(const BranchState &state) {
  const Layout &layout = mode_.system().layout();
  set_numbers(layout, state.y, here_.y);
  set_numbers(layout, state.tangent, here_.t);
  here_.parameter = parameter_of(here_.y);
  summary_.counts = state.counts;
  static_cast<SolveCounts &>(counts_) = state.counts;
  Archive saved(state.fields);
  SavedVectors vectors(layout);
  archive(saved, vectors);
}

// Cosine and sine of the own dofs, in the places of the first harmonic in y.
void archive_shape(Archive &archive, SavedVectors &vectors, const Layout &layout, Vec y, std::vector<double> &shape) {
  const auto exchange = [&](bool into) {
    double *own;
    check(VecGetArray(y, &own), doing);
    for (std::size_t i = 0; i < shape.size(); ++i) {
      double &place = own[i / 2 * layout.width + (i % 2 ? sine(1) : cosine(1))];
      (into ? place : shape[i]) = into ? shape[i] : place;
    }
    check(VecRestoreArray(y, &own), doing);
  };
  if (!archive.restores()) exchange(true);
  vectors.field(archive, "reference", y);
  if (archive.restores()) exchange(false);
}

// Saved and restored by the same list.
void Backbone::archive(Archive &archive, SavedVectors &vectors) {
  const Layout &layout = mode_.system().layout();
  archive.field("straight", straight_);
  archive.field("at_force", at_force_);
  archive.field("arclength", arclength_);
  archive.field("load", load_);
  archive.field("least", least_);
  archive.field("farthest_parameter", farthest_);
  archive.part("stepper", [&] { archive_steps(archive); });

  std::vector<double> reference = mode_.reference();
  archive_shape(archive, vectors, layout, mode_.unknowns(), reference);
  if (archive.restores()) mode_.refer_to(std::move(reference));

  double largest = curve_->norm.largest_motion();
  archive.field("largest_motion", largest);
  if (archive.restores()) { // the metric sees a vector that is so long
    const UniqueVec seen = mode_.unknowns();
    if (layout.rank == 0) check(VecSetValue(seen, 0, largest, INSERT_VALUES), doing);
    check(VecAssemblyBegin(seen), doing);
    check(VecAssemblyEnd(seen), doing);
    curve_->norm.see(seen);
  }
  vectors.point(archive, "before", *curve_, before_);
  vectors.ahead(archive, *curve_, ahead_, [](CurvePoint &) {});
  archive_memory(archive, *curve_);
  if (observer_.archive) observer_.archive(archive);
}

} // namespace

BranchSummary follow_backbone(HarmonicSystem &system, const NewtonSettings &newton, const BackboneSettings &settings,
                              const BackboneObserver &observer, const BranchState *state) {
  return Backbone(system, newton, settings, observer).run(state);
}

} // namespace dovetail
