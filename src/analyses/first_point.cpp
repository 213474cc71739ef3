// Where a branch begins: from rest or the motion given, by Newton; if that fails by easier problems that lead there.
#include <cmath>

#include "analyses/follower.hpp"
#include "transient/steady_state.hpp"

namespace dovetail {
namespace {

constexpr double least_load = 1e-3; // part of the load that the way to the first point begins with
constexpr int most_load_steps = 200;

} // namespace

bool Follower::interrupted() {
  const bool yes = observer_.interrupted && observer_.interrupted();
  if (yes) summary_.end = End::interrupted, summary_.why = "interrupted";
  return yes;
}

// The solution at the first frequency, followed by arc length from where a small load leads: on that curve folds and
// corners are no obstacle.
bool Follower::grow_load(double omega, std::vector<double> &q) {
  HarmonicSystem loaded(*system_, system_->harmonics(), system_->samples());
  loaded.vary(std::make_unique<LoadParameter>(omega));
  BranchSettings settings;
  settings.from = least_load, settings.to = 1;
  settings.step = settings_.step, settings.max_points = most_load_steps, settings.strategies = {};
  UniqueVec y = loaded.unknowns();
  bool arrived = false;
  const auto keep_last = [&](const BranchPoint &point) {
    arrived = point.omega == 1;
    if (arrived) q = all_coefficients(loaded.layout(), point.y);
  };
  const BranchObserver observer{keep_last, [](const BranchEvent &) {}, {}, observer_.interrupted};
  const BranchSummary summary = Follower(loaded, newton_, settings, observer).run(y, "");
  summary_.counts.newton += summary.counts.newton, summary_.counts.linear += summary.counts.linear;
  summary_.counts.inexact += summary.counts.inexact;
  return arrived;
}

bool Follower::first_point(double w, Vec y, CurvePoint &first, std::string &how, Effort effort) {
  check(VecCopy(y, first.y), "starting");
  if (curve_->solve_at(w, first)) return true;
  summary_.why = "no solution was found at the first frequency: " + first.newton.why + difference();
  if (settings_.strategies.none()) return false;

  const std::vector<double> begin = all_coefficients(system_->layout(), y);
  const std::string alas = "Newton does not converge from rest; the first point comes from ";
  const auto arrive = [&](const std::vector<double> &q, const std::string &by, int times = 1) {
    set_coefficients(system_->layout(), q, first.y);
    if (!curve_->solve_at(w, first, times)) return false;
    how += (how.empty() ? "" : "; ") + alas + by;
    return true;
  };
  // q becomes the solution of `easier`
  const auto through = [&](HarmonicSystem &easier, std::vector<double> &q, int times = 1) {
    ResponseCurve curve(easier, newton_, unit_, settings_.adaptive, summary_.counts);
    CurvePoint s = curve.point();
    set_coefficients(easier.layout(), q, s.y);
    if (!curve.solve_at(w, s, times)) return false;
    q = all_coefficients(easier.layout(), s.y);
    return true;
  };

  std::vector<double> q;
  const auto from_fewer_harmonics = [&](int times) {
    if (!may(Strategy::fewer_harmonics)) return false;
    q = begin;
    for (int H = 1; H < system_->harmonics(); H = std::max(H + 1, static_cast<int>(std::lround(1.4 * H)))) {
      HarmonicSystem easier(*system_, H, system_->samples());
      if (!through(easier, q, times)) return false;
    }
    return arrive(q, "fewer harmonics", times);
  };
  if (effort == Effort::full && from_fewer_harmonics(1)) return true;
  if (interrupted()) return false;

  SteadyState steady;
  const bool patient = effort == Effort::patient, begun = summary_.counts.points > 0,
             nowhere_else = patient || settings_.to == settings_.from, begins = effort == Effort::full && !begun;
  const int H = system_->harmonics(), needed = needed_harmonics(w);
  if (system_->layout().dofs() <= most_integrated && may(Strategy::integration)) {
    IntegrationSettings settings{std::max(H, nowhere_else ? ample_harmonics(w) : needed)};
    settings.periods = patient ? patient_periods : most_periods;
    const bool limited = !patient && begun;
    if (limited || effort == Effort::brief) settings.work = std::min(brief_work, integration_left());
    steady = steady_state(dense_model(*system_), w, {}, settings);
    if (limited) integrating_ += steady.work;
    if (steady.settled && arrive(steady.coefficients, "time integration")) return true;
  }
  if (interrupted()) return false;

  q = begin;
  bool good = effort == Effort::full && may(Strategy::soft_contacts);
  for (double part = 1.0 / 1024; good && part < 1; part *= 2) {
    HarmonicSystem easier(*system_, system_->harmonics(), system_->samples(), part);
    good = through(easier, q);
  }
  if (good && arrive(q, "softer contacts")) return true;
  if (interrupted()) return false;

  q = begin;
  if (effort == Effort::full && may(Strategy::load) && grow_load(w, q) && arrive(q, "a load that grows from nothing"))
    return true;

  if (interrupted()) return false;
  bool finer = steady.settled && solve_finer(steady.coefficients, w, Resort::usual);
  if (!finer && (patient || begins) && from_fewer_harmonics(patient_newton)) return true;
  if (!finer && nowhere_else && steady.settled) {
    if (arrive(steady.coefficients, "time integration", patient_newton)) return true;
    finer = solve_finer(steady.coefficients, w, Resort::last);
  }
  if (!finer) return false;
  std::swap(first, here_);
  how += (how.empty() ? "" : "; ") + alas + "time integration, with " + std::to_string(system_->harmonics()) +
         " harmonics; the closed contact wants " + std::to_string(needed);
  return true;
}

} // namespace dovetail
