#include "transient/shooting.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "support/dense.hpp"

namespace dovetail {
namespace {

constexpr std::size_t few_numbers = 100; // with more the whole derivative takes longer than GMRES may
constexpr int most_iterations = 40;
constexpr double shortest_part = 1.0 / 64; // of a Newton step

// The derivative of the period map at y where no slider is held, with zeros for those that are; false if the motion
// runs away.
bool free_derivative(PeriodMap &map, const Numbers &y, const Held &held, Dense &out) {
  Numbers image;
  Dense whole;
  if (!map.next_with_derivative(y, held, 0, image, whole)) return false;
  const int N = static_cast<int>(y.size());
  out.reset(N, N);
  for (int j = 0; j < N; ++j)
    for (int i = 0; i < N && !map.is_held(j, held); ++i)
      if (!map.is_held(i, held)) out(i, j) = whole(i, j);
  return true;
}

double largest_multiplier(PeriodMap &map, const Numbers &y, const Held &held) {
  Dense derivative;
  double largest = 0;
  if (free_derivative(map, y, held, derivative))
    for (const auto &one : eigenvalues(derivative)) largest = std::max(largest, std::abs(one));
  return largest;
}

// By how much the period misses its beginning: what moves, and the sliders that hardly do.
void split(const PeriodMap &map, const Numbers &y, const Numbers &image, const Held &held, Numbers &r, Numbers &drift) {
  r = image, drift.assign(y.size(), 0);
  add(r, -1, y);
  for (std::size_t i = 0; i < y.size(); ++i)
    if (map.is_held(i, held)) std::swap(drift[i], r[i]);
}

// Newton's method, its steps shortened where the next correction by the same derivative would not fall: what a period
// misses by grows with the multipliers, and says little (P. Deuflhard, Newton Methods for Nonlinear Problems, 2004,
// section 3.3).
Orbit newton_orbit(PeriodMap &map, Numbers y, double tolerance) {
  Orbit orbit;
  Numbers image, r, drift;
  Held held;
  orbit.state = map.state(y, {});
  if (!map.next(y, image, held)) return orbit;
  split(map, y, image, held, r, drift);
  const double first = norm(r) + norm(drift);
  orbit.found = first == 0;
  double part = 1;
  for (int iteration = 0; !orbit.found && iteration < most_iterations; ++iteration) {
    Dense A;
    if (!free_derivative(map, y, held, A)) break;
    for (double &entry : A.values) entry = -entry;
    for (int i = 0; i < A.rows; ++i) A(i, i) += 1;
    Factors factors;
    if (!factors.factor(A)) break;
    Numbers step = r;
    factors.solve(step.data());
    const double length = norm(step);
    bool good = false;
    for (part = std::min(1.0, 4 * part); part >= shortest_part; part /= 2) {
      Numbers trial = y, trial_image, trial_r, trial_drift;
      Held trial_held;
      add(trial, part, step), add(trial, 1, drift);
      if (!map.next(trial, trial_image, trial_held)) break;
      split(map, trial, trial_image, held, trial_r, trial_drift);
      Numbers next = trial_r;
      factors.solve(next.data());
      const double scale = map.motion_size(trial), correction = norm(next), now = norm(trial_r) + norm(trial_drift);
      if (!(correction < (1 - part / 4) * length || now < 1e-11 * scale)) continue;
      good = true;
      orbit.nearer = now / first;
      orbit.found = part == 1 && (correction + norm(trial_drift) < tolerance * scale || now < 1e-12 * scale);
      y.swap(trial), image.swap(trial_image), held.swap(trial_held);
      split(map, y, image, held, r, drift);
      break;
    }
    if (!good) break;
  }
  if (orbit.found) orbit.multiplier = largest_multiplier(map, y, held);
  orbit.state = map.state(y, {});
  return orbit;
}

} // namespace

Orbit periodic_orbit(Flow &flow, const Flow::State &start, double tolerance, int periods, bool far) {
  PeriodMap map(flow, periods);
  const Numbers y = map.numbers(start);
  const std::vector<double> &w2 = flow.modes().w2;    // in rising order; a body held by its joint alone has zeros,
  const bool walks = w2.front() <= 1e-10 * w2.back(); // to round-off: where it stands is not determined
  Orbit orbit = (far && !walks && y.size() <= few_numbers ? newton_orbit : krylov_orbit)(map, y, tolerance);
  orbit.periods = static_cast<int>(map.used());
  return orbit;
}

} // namespace dovetail
