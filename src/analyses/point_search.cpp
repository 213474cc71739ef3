#include "analyses/point_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "analyses/load_steps.hpp"
#include "problems/needed_harmonics.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr double most_unknowns = 1500; // of a system whose harmonics are raised
constexpr StepEffort downhill{.line_search = true};
constexpr int most_integrated = 300; // dofs
constexpr int most_periods = 4000;   // little damping takes many

} // namespace

std::optional<PointSearch::Found> PointSearch::by_newton(double value, Vec y) {
  Found found{response_.curve().point(), "Newton's method", nullptr};
  check(VecCopy(y, found.point.y), "predicting");
  if (response_.curve().solve_at(value, found.point)) return found;
  check(VecSet(found.point.y, 0), "predicting");
  if (response_.curve().solve_at(value, found.point)) return found;
  return std::nullopt;
}

// From one number of harmonics to the next the motion is guess enough, most often that of one for all of them. Quickly,
// one harmonic comes from smaller loads if need be.
std::optional<PointSearch::Found> PointSearch::by_fewer_harmonics(double value, Vec y, bool quickly) {
  const auto solve = [&](Curve &curve, CurvePoint &s) {
    return quickly ? curve.solve_at(value, s, hurried) || curve.solve_at(value, s, downhill) : curve.solve_at(value, s);
  };
  HarmonicSystem &system = response_.system();
  if (system.harmonics() == 1 && !quickly) return std::nullopt;
  Found found{response_.curve().point(), "fewer harmonics", nullptr};
  std::vector<double> q = all_coefficients(system.layout(), y);
  for (int H = 1; H < system.harmonics(); H = std::max(H + 1, static_cast<int>(std::lround(1.4 * H)))) {
    const std::unique_ptr<HarmonicSystem> simpler = response_.with(H);
    ResponseCurve curve = response_.curve_of(*simpler);
    CurvePoint s = curve.point();
    set_coefficients(simpler->layout(), q, s.y);
    const bool solved = quickly && H == 1 ? curve.solve_at(value, s, hurried) ||
                                                (response_.lost_to_rounding(value, s.newton.residual).empty() &&
                                                 solve_by_load_steps(response_, *simpler, value, s.y))
                                          : solve(curve, s);
    if (!solved) return std::nullopt;
    q = all_coefficients(simpler->layout(), s.y);
    if (!quickly || H > 1) continue;
    set_coefficients(system.layout(), q, found.point.y);
    if (response_.curve().solve_at(value, found.point, hurried)) return found;
  }
  set_coefficients(system.layout(), q, found.point.y);
  if (system.harmonics() == 1 && !solve_by_load_steps(response_, system, value, found.point.y)) return std::nullopt;
  if (!solve(response_.curve(), found.point)) return std::nullopt;
  return found;
}

// Where integration has led on it may again.
double PointSearch::work_left() const {
  return (2 + 2 * counts_.integrations) * work_ * IntegrationSettings().work - integrated_;
}

// By the rule that H Omega should reach twice the frequency of the closed contact; as far as size allows.
int PointSearch::needed_harmonics(double value) {
  HarmonicSystem &system = response_.system();
  const int dofs = system.layout().dofs();
  if (dofs > most_integrated || !system.set(value)) return 0;
  const double wanted = std::ceil(2 * closed_contact_frequency(dense_model(system)) / system.setting().omega);
  return static_cast<int>(std::min(wanted, (most_unknowns / static_cast<double>(dofs) - 1) / 2));
}

std::optional<PointSearch::Found> PointSearch::by_integration(double value, Vec y, double share) {
  HarmonicSystem &system = response_.system();
  if (system.layout().dofs() > most_integrated || !system.scaled().damping.acts_in_time() || !(work_left() > 0) ||
      !system.set(value))
    return std::nullopt;
  IntegrationSettings settings{std::max(system.harmonics(), needed_harmonics(value))};
  settings.periods = most_periods;
  settings.work = std::min(settings.work, share * work_left());
  std::vector<double> start;
  if (y) start = all_coefficients(system.layout(), y);
  const SteadyState steady = steady_state(dense_model(system), system.setting().omega, start, settings);
  integrated_ += steady.work;
  if (!steady.settled) return std::nullopt;
  Found found{response_.curve().point(), "time integration", nullptr};
  set_coefficients(system.layout(), steady.coefficients, found.point.y);
  if (!response_.curve().solve_at(value, found.point)) return with_more_harmonics(value, steady);
  return found;
}

// The motion is no solution for these harmonics.
std::optional<PointSearch::Found> PointSearch::with_more_harmonics(double value, const SteadyState &steady) {
  const int needed = needed_harmonics(value), H = response_.system().harmonics();
  for (int more = 2 * H; more < 2 * needed; more *= 2) {
    const int tried = std::min(more, needed);
    std::unique_ptr<HarmonicSystem> system = response_.with(tried);
    ResponseCurve curve = response_.curve_of(*system);
    CurvePoint s = curve.point();
    set_coefficients(system->layout(), steady.coefficients, s.y);
    if (curve.solve_at(value, s))
      return Found{std::move(s),
                   "time integration, with " + std::to_string(tried) + " harmonics; the closed contact wants " +
                       std::to_string(needed),
                   std::move(system)};
    if (!steady.opens) break; // what is missing is not harmonics
  }
  return std::nullopt;
}

} // namespace dovetail
