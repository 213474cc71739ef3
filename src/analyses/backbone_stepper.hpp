#pragma once
// Steps along a nonlinear mode, over the decimal logarithm of its amplitude.
#include <cmath>
#include <optional>

#include "analyses/backbone.hpp"
#include "analyses/saved_points.hpp"
#include "continuation/stepper.hpp"

namespace dovetail {

class Backbone : public Stepper {
public:
  static constexpr double decade = 1; ///< counts as much as the largest motion
  /// StepAims::parameter of it is a tenth of a decade, which readers interpolate in.
  static constexpr double longest_unit = 2;

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
      end(BranchSummary::End::arrived, "mode.to_force is reached at the first amplitude already");
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
  bool end(BranchSummary::End how, const std::string &why = "") {
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
    end(BranchSummary::End::stalled, refusal_);
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

} // namespace dovetail
