#include "continuation/branch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "continuation/arc_norm.hpp"

namespace dovetail {
namespace {

// Step control. Lengths are in the weighted norm, where 1 is the largest motion so far or the whole sweep.
constexpr double longest_step = 0.1; // of the motion
constexpr double longest_omega_step =
    0.01; // of the sweep: narrower resonances than this are met with care only if seen
constexpr double shortest_step = 1e-7;
constexpr double most_angle = 0.64;   // between the tangents before and after a step [rad]
constexpr double corner_ratio = 0.75; // of that angle after halving to before: a smooth curve gives 1/2, a corner 1
constexpr int corner_halvings = 2;    // so many without effect and the turn is a corner of the curve: it is taken
constexpr double aimed_angle = 0.25;  // between them [rad]
constexpr int aimed_newton = 4, most_newton = 8;
constexpr double least_newton_step = 1e-4; // shorter steps may take as many iterations as newton.max_iterations allows

class Follower {
public:
  Follower(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings, Vec y,
           const BranchObserver &observer)
      : system_(system), corrector_(system, newton), settings_(settings), observer_(observer),
        norm_(system.layout(), settings.to != settings.from ? std::abs(settings.to - settings.from) : 1,
              settings.adaptive),
        y_(y), trial_(system.unknowns()), t_(system.unknowns()), turned_(system.unknowns()), row_(system.unknowns()),
        e_omega_(system.unknowns()) {
    const Layout &layout = system.layout();
    if (layout.owns_omega())
      check(VecSetValue(e_omega_, layout.omega_row(), 1, INSERT_VALUES), "setting up continuation");
    check(VecAssemblyBegin(e_omega_), "setting up continuation");
    check(VecAssemblyEnd(e_omega_), "setting up continuation");
  }

  BranchSummary run() {
    direction_ = settings_.to < settings_.from ? -1 : 1;
    std::copy_if(settings_.at.begin(), settings_.at.end(), std::back_inserter(wanted_),
                 [&](double w) { return w != settings_.from && w != settings_.to; });
    wanted_.push_back(settings_.to);
    if (!start()) return finish(BranchSummary::End::no_start);
    if (settings_.to == settings_.from) return finish(BranchSummary::End::arrived);
    while (summary_.points < settings_.max_points)
      if (const auto end = advance(); end != Go::on)
        return finish(end == Go::arrived   ? BranchSummary::End::arrived
                      : end == Go::stalled ? BranchSummary::End::stalled
                                           : BranchSummary::End::turned_back);
    summary_.why = "stopped at continuation.max_points = " + std::to_string(settings_.max_points);
    return finish(BranchSummary::End::max_points);
  }

private:
  enum class Go { on, arrived, stalled, turned_back };

  BranchSummary finish(BranchSummary::End end) {
    summary_.end = end;
    summary_.omega = omega_;
    return summary_;
  }

  Corrector::Outcome correct(Vec y, Vec border, double target, bool line_search = false) {
    const auto outcome = corrector_.solve(y, border, target, line_search);
    summary_.newton += outcome.newton;
    summary_.linear += outcome.linear;
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
    const double omega_rate = std::abs(system_.omega(t_)) / std::abs(settings_.to - settings_.from);
    step_ = std::min({step_, longest_step, omega_rate > 0 ? longest_omega_step / omega_rate : longest_step});
  }

  // One accepted step along the curve, or the news that there is none.
  Go advance() {
    double trial_step = step_, angle = 0;
    int blunt = 0; // halvings in a row that did not make the curve turn less
    norm_.weigh(t_, row_);
    for (;; trial_step /= 2) {
      if (trial_step < shortest_step * (settings_.adaptive ? 1 : settings_.step)) {
        summary_.why = refusal_;
        return Go::stalled;
      }
      check(VecWAXPY(trial_, trial_step, t_, y_), "predicting");
      double target;
      check(VecDot(row_, trial_, &target), "predicting");
      const double predicted = system_.omega(trial_);
      Corrector::Outcome outcome;
      const double wider = angle;
      angle = 0;
      if (!(predicted > 0)) {
        refusal_ = "the predicted frequency is not positive";
      } else if (outcome = correct(trial_, row_, target); !outcome.converged) {
        refusal_ = outcome.why;
      } else if (const auto states = system_.states(); !corrector_.tangent(turned_)) {
        refusal_ = "the bordered Jacobian is singular";
      } else if (angle = turn(); !settings_.adaptive) {
        return take(trial_step, angle, outcome, states);
      } else if (blunt = angle > corner_ratio * wider && wider > most_angle ? blunt + 1 : 0;
                 angle > most_angle && blunt < corner_halvings) {
        refusal_ = "the curve turns too far within one step";
      } else if (outcome.newton > most_newton && trial_step > least_newton_step) {
        refusal_ = "too many Newton iterations";
      } else {
        return take(trial_step, angle, outcome, states);
      }
      ++summary_.cuts;
      notify(BranchEvent::Kind::cut, refusal_ + ", step halved");
    }
  }

  double turn() const { // angle between the tangents before and after the trial step
    return std::acos(std::clamp(norm_.product(t_, turned_) / (norm_.length(t_) * norm_.length(turned_)), -1.0, 1.0));
  }

  Go take(double trial_step, double angle, const Corrector::Outcome &outcome, const std::array<long, 3> &states) {
    const double next = system_.omega(trial_), before = omega_;
    for (const double w : passed(before, next)) {
      UniqueVec exact = system_.unknowns();
      const double part = (w - before) / (next - before);
      check(VecWAXPY(exact, -1, y_, trial_), "interpolating");
      check(VecAYPX(exact, part, y_), "interpolating");
      const auto at_exact = correct_at(exact, w);
      if (at_exact.converged) {
        omega_ = w;
        accept(exact, at_exact, part * trial_step);
      }
      if (w == settings_.to) {
        if (at_exact.converged) return Go::arrived;
        refusal_ = at_exact.why;
        summary_.why = "at the end of the sweep: " + refusal_;
        return Go::stalled;
      }
      if (!at_exact.converged)
        notify(BranchEvent::Kind::cut, "no solution at a frequency of continuation.at: " + at_exact.why);
      if (summary_.points >= settings_.max_points) return Go::on;
    }
    omega_ = next;
    if ((next - settings_.from) * direction_ < 0) {
      summary_.why = "the branch turned back and left the sweep at its beginning";
      return Go::turned_back;
    }
    const double rate_before = system_.omega(t_), rate_after = system_.omega(turned_);
    check(VecCopy(trial_, y_), "accepting a point");
    states_ = states;
    report(y_, outcome, step_length(trial_step));
    if (rate_before * rate_after < 0) {
      ++summary_.folds;
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

  // Frequencies wanted exactly that lie between two points, in the order they are passed.
  std::vector<double> passed(double before, double next) const {
    std::vector<double> found;
    for (const double w : wanted_)
      if ((w - before) * (w - next) <= 0 && w != before) found.push_back(w);
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
    states_ = system_.states();
    report(y, outcome, trial_step > 0 ? step_length(trial_step) : 0);
    norm_.see(y);
  }

  void report(Vec y, const Corrector::Outcome &outcome, double beyond) {
    const double whole = settings_.to - settings_.from;
    ++summary_.points;
    if (y == y_) arclength_ += beyond; // points in between do not move the branch on
    const double arclength = y == y_ ? arclength_ : arclength_ + beyond;
    observer_.point({y, omega_, arclength, outcome, states_, whole == 0 ? 1 : (omega_ - settings_.from) / whole});
  }

  void notify(BranchEvent::Kind kind, const std::string &text) { observer_.event({kind, text, omega_}); }

  HarmonicSystem &system_;
  Corrector corrector_;
  const BranchSettings &settings_;
  const BranchObserver &observer_;
  ArcNorm norm_;
  BranchSummary summary_;
  Vec y_; // last accepted point
  UniqueVec trial_, t_, turned_, row_, e_omega_;
  std::vector<double> wanted_; // frequencies to be hit, the end among them
  std::array<long, 3> states_{};
  std::string refusal_;
  double omega_ = 0, step_ = 0, arclength_ = 0;
  int direction_ = 1;
};

} // namespace

BranchSummary follow_branch(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings, Vec y,
                            const BranchObserver &observer) {
  return Follower(system, newton, settings, y, observer).run();
}

} // namespace dovetail
