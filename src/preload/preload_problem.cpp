#include "preload/preload_problem.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace dovetail {
namespace {

constexpr int most_iterations = 60;       // of Newton's method
constexpr double holding_friction = 1000; // times its own, with which closed points stick
constexpr double smallest_ratio = 1.001;  // of friction, from one step to the next

} // namespace

PreloadProblem::PreloadProblem(const ReducedModel &model, const std::vector<ContactPoint> &contact)
    : model_(model), contact_(contact), tangent_(model) {}

PreloadProblem::State PreloadProblem::at(const std::vector<double> &x, double load, bool stuck) const {
  State state{tangent_.structure_times(x.data()), std::vector<PreloadTangent::Slope>(contact_.size())};
  double sizes[] = {0, 0}; // the latter: of R, and of the springs of the points that are closed
  for (std::size_t p = 0; p < contact_.size(); ++p) {
    const StaticForce g = law(p, &x[3 * p], stuck);
    state.slopes[p] = g.slope;
    for (int d = 0; d < 3; ++d) {
      const double pushed = load * model_.r[3 * p + d];
      double &residual = state.residual[3 * p + d];
      residual += g.force[d] + pushed;
      sizes[0] += residual * residual, sizes[1] += pushed * pushed;
    }
    // An open point's spring is not at work, however far it is from closing.
    if (g.slope[2][2] > 0) sizes[1] += std::pow(contact_[p].kn * contact_[p].gap, 2);
  }
  MPI_Allreduce(MPI_IN_PLACE, sizes, 2, MPI_DOUBLE, MPI_SUM, model_.comm);
  state.left = std::sqrt(sizes[0]), state.force = std::max(std::sqrt(sizes[1]), 1e-287);
  return state;
}

// Newton from x, which is left alone unless it converges: at the tolerance, relative to the forces at work, or where
// round-off holds the residual above it and Newton repeats itself.
bool PreloadProblem::solve(std::vector<double> &x, double load, bool stuck) {
  std::vector<double> trial = x, step;
  double before = INFINITY;
  for (int i = 0; i <= most_iterations; ++i) {
    const State state = at(trial, load, stuck);
    if (!std::isfinite(state.left)) return false;
    if (state.left <= 1e-13 * state.force || (state.left <= 1e-10 * state.force && state.left > before / 2)) {
      x = trial;
      return true;
    }
    before = state.left;
    if (!tangent_.solve(state.slopes, state.residual, step)) return false;
    for (std::size_t d = 0; d < trial.size(); ++d) trial[d] -= step[d];
  }
  return false;
}

StaticForce PreloadProblem::law(std::size_t p, const double *x, bool stuck) const {
  ContactPoint point = contact_[p];
  for (double &mu : point.mu) mu *= friction_;
  if (!stuck) return static_force(point, x);
  StaticForce g;
  for (int d = 0; d < 2 && has_friction(point.law); ++d) g.force[d] = point.kt[d] * x[d], g.slope[d][d] = point.kt[d];
  g.force[2] = point.kn * (x[2] - point.gap), g.slope[2][2] = point.kn;
  return g;
}

bool PreloadProblem::load_in_steps(std::vector<double> &x, double load) { // x: solution with the joint stuck
  double reached = 0, step = 0.1;
  while (reached < 1 && step > 1e-4) {
    const double next = std::min(1.0, reached + step);
    std::vector<double> trial = x;
    if (reached == 0)
      for (double &value : trial) value *= next;
    if (solve(trial, next * load, false))
      x = trial, reached = next, step *= 2;
    else
      step /= 4;
  }
  return reached == 1;
}

bool PreloadProblem::lower_friction(std::vector<double> &x, double load) { // x: solution with the joint stuck
  double ratio = 4;
  friction_ = holding_friction;
  bool found = solve(x, load, false);
  while (found && friction_ > 1 && ratio > smallest_ratio) {
    const double before = std::exchange(friction_, std::max(1.0, friction_ / ratio));
    const bool on = solve(x, load, false);
    ratio = on ? ratio * ratio : std::sqrt(ratio);
    if (!on) friction_ = before;
  }
  found = found && friction_ == 1;
  friction_ = 1;
  return found;
}

bool PreloadProblem::find(std::vector<double> &x, double load, std::string &note) {
  tangent_.forget();
  if (solve(x, load, false)) return true;
  std::vector<double> stuck = x, trial;
  if (!solve(stuck, load, true)) return false;
  const std::pair<const char *, std::function<bool()>> ways[] = {
      {"started again from the closed and sticking joint", [&] { return solve(trial, load, false); }},
      {"loaded in steps", [&] { return load_in_steps(trial, load); }},
      {"friction lowered in steps", [&] { return lower_friction(trial, load); }}};
  for (const auto &[how, finds] : ways) {
    trial = stuck;
    if (!finds()) continue;
    note = std::string("contact preload: plain Newton failed, ") + how;
    x = trial;
    return true;
  }
  return false;
}

std::vector<PreloadTangent::Slope> PreloadProblem::slopes(const std::vector<double> &x) const {
  std::vector<PreloadTangent::Slope> all;
  for (std::size_t p = 0; p < contact_.size(); ++p) all.push_back(law(p, &x[3 * p], false).slope);
  return all;
}

std::vector<double> PreloadProblem::follow(const std::vector<double> &x, const std::vector<double> &change) {
  std::vector<double> dx;
  if (!tangent_.solve(slopes(x), change, dx)) dx.assign(x.size(), NAN);
  for (double &value : dx) value = -value;
  return dx;
}

} // namespace dovetail
