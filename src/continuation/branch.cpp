#include "continuation/branch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "continuation/arc_norm.hpp"

namespace dovetail {
namespace {

// Step control. Lengths are in the weighted norm, where 1 is the largest motion so far or the whole sweep.
constexpr double longest_step = 0.1;
constexpr double longest_omega_step = 0.01;   // of the sweep: a resonance narrower than this could be stepped over
constexpr double longest_motion_step = 0.25;  // of the motion at hand, which after a resonance is far below the largest
constexpr double shortest_motion_step = 1e-3; // that limit does not hold a curve up where the motion passes zero
constexpr double shortest_step = 1e-7;
constexpr double most_angle = 0.64;   // between the tangents before and after a step [rad]
constexpr double most_correction = 2; // distance from predicted to converged point, in steps
constexpr double corner_ratio = 0.75; // halving makes angle and correction of a smooth curve 1/2 and 1/4 as large; at a
                                      // corner the angle stays and the correction halves, at a jump both stay
constexpr int corner_halvings = 2;    // so many like that, and it is a corner of the curve: it is taken
constexpr double aimed_angle = 0.25;  // between tangents [rad]
constexpr int aimed_newton = 4, most_newton = 8;
constexpr double least_newton_step = 1e-4; // shorter steps may take newton.max_iterations
constexpr int most_leaps = 20;
constexpr double leaps[] = {1e-4, 1e-3, 1e-2}; // of the sweep

class Follower {
public:
  Follower(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings, Vec y,
           const BranchObserver &observer)
      : system_(system), corrector_(system, newton), settings_(settings), observer_(observer),
        norm_(system.layout(), settings.to != settings.from ? std::abs(settings.to - settings.from) : 1,
              settings.adaptive),
        y_(y), trial_(system.unknowns()), predicted_(system.unknowns()), t_(system.unknowns()),
        turned_(system.unknowns()), row_(system.unknowns()), e_omega_(system.unknowns()) {
    const Layout &layout = system.layout();
    if (layout.owns_omega())
      check(VecSetValue(e_omega_, layout.omega_row(), 1, INSERT_VALUES), "setting up continuation");
    check(VecAssemblyBegin(e_omega_), "setting up continuation");
    check(VecAssemblyEnd(e_omega_), "setting up continuation");
  }

  BranchSummary run() {
    direction_ = settings_.to < settings_.from ? -1 : 1;
    if (!start()) return finish(BranchSummary::End::no_start);
    if (settings_.to == settings_.from) return finish(BranchSummary::End::arrived);
    while (summary_.counts.points < settings_.max_points)
      if (const auto end = advance(); end != Go::on)
        return finish(end == Go::arrived   ? BranchSummary::End::arrived
                      : end == Go::stalled ? BranchSummary::End::stalled
                                           : BranchSummary::End::turned_back);
    summary_.why = "stopped at continuation.max_points = " + std::to_string(settings_.max_points);
    return finish(BranchSummary::End::max_points);
  }

private:
  enum class Go { on, retry, arrived, stalled, turned_back };

  BranchSummary finish(BranchSummary::End end) {
    summary_.end = end;
    summary_.omega = omega_;
    return summary_;
  }

  Corrector::Outcome correct(Vec y, Vec border, double target, bool line_search = false) {
    const auto outcome = corrector_.solve(y, border, target, line_search);
    summary_.counts.newton += outcome.newton;
    summary_.counts.linear += outcome.linear;
    return outcome;
  }

  // Solution at the frequency Omega = w exactly, near y.
  Corrector::Outcome correct_at(Vec y, double w) {
    set_omega(y, w);
    auto outcome = correct(y, e_omega_, w);
    if (!outcome.converged) outcome = correct(y, e_omega_, w, true);
    if (outcome.converged) set_omega(y, w);
    return outcome;
  }

  void set_omega(Vec y, double w) {
    const Layout &layout = system_.layout();
    double *own;
    check(VecGetArray(y, &own), "setting Omega");
    if (layout.owns_omega()) own[layout.own_coefficients()] = w;
    check(VecRestoreArray(y, &own), "setting Omega");
  }

  bool start() {
    const auto outcome = correct_at(y_, settings_.from);
    omega_ = settings_.from;
    if (!outcome.converged) {
      summary_.why = "no solution was found at the first frequency: " + outcome.why;
      return false;
    }
    accept(y_, outcome, 0);
    if (settings_.to == settings_.from) return true;
    if (!corrector_.tangent(t_)) {
      summary_.why = "the Jacobian at the first frequency is singular";
      return false;
    }
    check(VecScale(t_, direction_), "computing a tangent");
    PetscReal plain;
    check(VecNorm(t_, NORM_2, &plain), "computing a tangent");
    const double length = norm_.length(t_);
    step_ = settings_.step * length / plain; // the user's arc length is in the plain norm
    check(VecScale(t_, 1 / length), "computing a tangent");
    limit_step();
    return true;
  }

  void limit_step() {
    if (!settings_.adaptive) return;
    step_ = std::min(step_, longest_step);
    if (const double rate = std::abs(system_.omega(t_)) / std::abs(settings_.to - settings_.from); rate > 0)
      step_ = std::min(step_, longest_omega_step / rate);
    if (const double rate = norm_.motion(t_); rate > 0)
      step_ = std::min(step_, std::max(longest_motion_step * norm_.motion(y_) / rate, shortest_motion_step));
    step_ = std::max(step_, 10 * shortest_step);
  }

  // One accepted step along the curve, or the news that there is none.
  Go advance() {
    double trial_step = step_;
    const double least = settings_.adaptive ? shortest_step : shortest_step * settings_.step;
    Measure measure;
    int like_a_corner = 0;
    norm_.weigh(t_, row_);
    for (; trial_step >= least; trial_step /= 2) {
      check(VecWAXPY(trial_, trial_step, t_, y_), "predicting");
      check(VecCopy(trial_, predicted_), "predicting");
      double target;
      check(VecDot(row_, trial_, &target), "predicting");
      const Measure before = std::exchange(measure, {});
      Corrector::Outcome outcome;
      if (!(system_.omega(trial_) > 0)) {
        refusal_ = "the predicted frequency is not positive";
      } else if (outcome = correct(trial_, row_, target); !outcome.converged) {
        refusal_ = outcome.why;
      } else if (const auto activity = system_.activity(); !corrector_.tangent(turned_)) {
        refusal_ = "the bordered Jacobian is singular";
      } else {
        measure = {angle_between_tangents(), correction(trial_step)};
        like_a_corner = measure.like_a_corner_after(before) ? like_a_corner + 1 : 0;
        if (settings_.adaptive && measure.refused() && like_a_corner < corner_halvings)
          refusal_ = measure.angle > most_angle ? "the curve turns too far within one step"
                                                : "the solution lies too far from the predicted one";
        else if (settings_.adaptive && outcome.newton > most_newton && trial_step > least_newton_step)
          refusal_ = "too many Newton iterations";
        else if (const auto end = take(trial_step, measure.angle, outcome, activity); end != Go::retry)
          return end;
      }
      ++summary_.counts.cuts;
      notify(BranchEvent::Kind::cut, refusal_ + ", step halved");
    }
    return settings_.adaptive ? leap() : stall();
  }

  struct Measure { // how far the curve turned within a trial step, and how far the solution lay from the prediction
    double angle = 0, correction = 0; // [rad], [steps]
    bool refused() const { return angle > most_angle || correction > most_correction; }
    bool like_a_corner_after(const Measure &longer) const { // the correction halves with the step: the same in steps
      return longer.refused() && angle > corner_ratio * longer.angle &&
             correction < 2 * corner_ratio * longer.correction;
    }
  };

  double angle_between_tangents() const {
    const double cosine = norm_.product(t_, turned_) / (norm_.length(t_) * norm_.length(turned_));
    return std::acos(std::clamp(cosine, -1.0, 1.0));
  }

  double correction(double trial_step) {
    check(VecAXPY(predicted_, -1, trial_), "measuring a correction");
    return norm_.length(predicted_) / trial_step;
  }

  Go stall() {
    summary_.why = refusal_;
    return Go::stalled;
  }

  // No step along the curve converges: on to the solution at the next frequency of the sweep, and say so.
  Go leap() {
    if (summary_.counts.leaps == most_leaps) return stall();
    const std::string reason = refusal_;
    for (const double part : leaps) {
      double next = omega_ + direction_ * part * std::abs(settings_.to - settings_.from);
      if ((next - settings_.to) * direction_ > 0) next = settings_.to;
      if (const auto wanted = passed(omega_, next); !wanted.empty()) next = wanted.front();
      check(VecCopy(y_, trial_), "predicting");
      const auto outcome = correct_at(trial_, next);
      if (!outcome.converged || !corrector_.tangent(turned_)) continue;
      ++summary_.counts.leaps;
      check(VecCopy(trial_, y_), "accepting a point");
      check(VecCopy(turned_, t_), "accepting a point");
      omega_ = next;
      notify(BranchEvent::Kind::leap,
             "the curve could not be followed here (" + reason +
                 "): went on from the solution at the next frequency; the branch may have changed");
      accept(y_, outcome, 0);
      if (next == settings_.to) return Go::arrived;
      const double length = norm_.length(t_);
      check(VecScale(t_, direction_ / length), "accepting a point");
      step_ = least_newton_step;
      return Go::on;
    }
    refusal_ = reason;
    return stall();
  }

  Go take(double trial_step, double angle, const Corrector::Outcome &outcome, const std::vector<Activity> &activity) {
    const double next = system_.omega(trial_), before = omega_;
    UniqueVec end; // the solution exactly there, when the step reaches the end of the sweep
    Corrector::Outcome at_end;
    const bool ends = (settings_.to - before) * (settings_.to - next) <= 0;
    if (ends) end = system_.unknowns();
    if (ends && !(at_end = correct_between(end, before, next, settings_.to)).converged) {
      refusal_ = "no solution exactly at the end of the sweep: " + at_end.why;
      return Go::retry;
    }
    for (const double w : passed(before, ends ? settings_.to : next)) {
      UniqueVec exact = system_.unknowns();
      const auto at_exact = correct_between(exact, before, next, w);
      omega_ = w;
      if (at_exact.converged) {
        accept(exact, at_exact, (w - before) / (next - before) * trial_step);
      } else {
        ++summary_.counts.missed;
        notify(BranchEvent::Kind::missed, "no solution at this frequency of continuation.at: " + at_exact.why);
      }
      if (summary_.counts.points >= settings_.max_points) return Go::on;
    }
    if (ends) {
      omega_ = settings_.to;
      const double part = (settings_.to - before) / (next - before);
      system_.residual(end, predicted_); // the activity there, after those of the points in between
      accept(end, at_end, part * trial_step);
      return Go::arrived;
    }
    omega_ = next;
    if ((next - settings_.from) * direction_ < 0) {
      summary_.why = "the branch turned back and left the sweep at its beginning";
      return Go::turned_back;
    }
    const double rate_before = system_.omega(t_), rate_after = system_.omega(turned_);
    check(VecCopy(trial_, y_), "accepting a point");
    activity_ = activity;
    report(y_, outcome, step_length(trial_step));
    if (rate_before * rate_after < 0) {
      ++summary_.counts.folds;
      notify(BranchEvent::Kind::fold, "turning point: the curve goes on towards " +
                                          std::string(rate_after > 0 ? "higher" : "lower") + " frequencies");
    }
    norm_.see(y_);
    check(VecCopy(turned_, t_), "accepting a point");
    const double length = norm_.length(t_);
    if (settings_.adaptive) {
      const double by_newton = std::pow(2.0, (aimed_newton - outcome.newton) / 2.0);
      const double by_angle = aimed_angle / std::max(angle, 1e-3);
      step_ = trial_step * std::clamp(std::min(by_newton, by_angle), 0.5, 2.0);
    }
    check(VecScale(t_, 1 / length), "accepting a point");
    limit_step();
    return Go::on;
  }

  // Solution exactly at w, from the line between the last point and the trial one.
  Corrector::Outcome correct_between(Vec y, double before, double next, double w) {
    check(VecWAXPY(y, -1, y_, trial_), "interpolating");
    check(VecAYPX(y, (w - before) / (next - before), y_), "interpolating");
    return correct_at(y, w);
  }

  // Frequencies of `at` that lie between two points, in the order they are passed.
  std::vector<double> passed(double before, double next) const {
    std::vector<double> found;
    for (const double w : settings_.at)
      if ((w - before) * (w - next) < 0) found.push_back(w);
    if (next < before)
      std::sort(found.rbegin(), found.rend());
    else
      std::sort(found.begin(), found.end());
    return found;
  }

  double step_length(double trial_step) const { // in the plain norm
    PetscReal plain;
    check(VecNorm(t_, NORM_2, &plain), "measuring arc length");
    return trial_step * plain;
  }

  void accept(Vec y, const Corrector::Outcome &outcome, double trial_step) {
    activity_ = system_.activity();
    report(y, outcome, trial_step > 0 ? step_length(trial_step) : 0);
    norm_.see(y);
  }

  void report(Vec y, const Corrector::Outcome &outcome, double beyond) {
    const double whole = settings_.to - settings_.from;
    ++summary_.counts.points;
    if (y == y_) arclength_ += beyond; // points in between do not move the branch on
    const double arclength = y == y_ ? arclength_ : arclength_ + beyond;
    observer_.point({y, system_, omega_, arclength, outcome, activity_, nullptr,
                     whole == 0 ? 1 : (omega_ - settings_.from) / whole});
  }

  void notify(BranchEvent::Kind kind, const std::string &text) { observer_.event({kind, text, omega_, 0}); }

  HarmonicSystem &system_;
  Corrector corrector_;
  const BranchSettings &settings_;
  const BranchObserver &observer_;
  ArcNorm norm_;
  BranchSummary summary_;
  Vec y_; // last accepted point
  UniqueVec trial_, predicted_, t_, turned_, row_, e_omega_;
  std::vector<Activity> activity_; // of the point reported next
  std::string refusal_;
  double omega_ = 0, step_ = 0, arclength_ = 0;
  int direction_ = 1;
};

} // namespace

BranchSummary follow_branch(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings, Vec y,
                            const BranchObserver &observer, const BranchState *) {
  return Follower(system, newton, settings, y, observer).run();
}

} // namespace dovetail
