// Shooting with large models: Newton's method with GMRES, derivatives by differences.
#include <algorithm>
#include <cmath>

#include "transient/shooting.hpp"

namespace dovetail {
namespace {

constexpr int most_directions = 60; // of the derivative, each for a period of the motion

// Arnoldi's method with the derivative of the period map at y, by differences: its columns of H, (j+2) each.
class Krylov {
public:
  Krylov(PeriodMap &map, const Numbers &y, const Numbers &image, const Held &held, const Numbers &start)
      : map_(map), y_(y), image_(image), held_(held), step_(3e-7 * std::max(map.motion_size(y), 1e-300)) {
    basis_.push_back(start);
    const double size = norm(start);
    for (double &value : basis_[0]) value /= size;
  }

  bool extend() {
    Numbers at = y_, next;
    add(at, step_, basis_.back());
    if (!map_.next_held(at, next, held_)) return false;
    add(next, -1, image_);
    for (double &value : next) value /= step_;
    std::vector<double> column(basis_.size() + 1);
    for (int pass = 0; pass < 2; ++pass) // the second makes up for round-off of the first
      for (std::size_t j = 0; j < basis_.size(); ++j) {
        const double share = dot(basis_[j], next);
        column[j] += share;
        add(next, -share, basis_[j]);
      }
    const double rest = column.back() = norm(next);
    columns_.push_back(column);
    complete_ = rest < 1e-10;
    if (complete_) return true;
    for (double &value : next) value /= rest;
    basis_.push_back(next);
    return true;
  }

  int steps() const { return static_cast<int>(columns_.size()); }
  bool complete() const { return complete_; } // the derivative leads nowhere new
  const Numbers &direction(int j) const { return basis_[j]; }
  double H(int i, int j) const { return i < static_cast<int>(columns_[j].size()) ? columns_[j][i] : 0; }

private:
  PeriodMap &map_;
  const Numbers &y_, &image_;
  const Held &held_;
  double step_;
  bool complete_ = false;
  std::vector<Numbers> basis_, columns_;
};

// The step d with (1 - derivative) d = r as far as GMRES has come, and what is left of |r|.
double newton_step(const Krylov &krylov, double size, Numbers &step) {
  const int m = krylov.steps();
  std::vector<Numbers> A(m, Numbers(m + 1)); // columns of 1 - H, made triangular by rotations
  Numbers b(m + 1);
  b[0] = size;
  for (int j = 0; j < m; ++j)
    for (int i = 0; i <= m; ++i) A[j][i] = (i == j) - krylov.H(i, j);
  for (int i = 0; i < m; ++i) {
    const double a = A[i][i], c = A[i][i + 1], r = std::hypot(a, c);
    if (r == 0) return size;
    const auto rotate = [&](Numbers &v) {
      const double first = v[i], second = v[i + 1];
      v[i] = (a * first + c * second) / r, v[i + 1] = (a * second - c * first) / r;
    };
    for (int j = i; j < m; ++j) rotate(A[j]);
    rotate(b);
  }
  Numbers weights(m);
  for (int i = m - 1; i >= 0; --i) {
    double sum = b[i];
    for (int j = i + 1; j < m; ++j) sum -= A[j][i] * weights[j];
    weights[i] = sum / A[i][i];
  }
  step.assign(krylov.direction(0).size(), 0);
  for (int j = 0; j < m; ++j) add(step, weights[j], krylov.direction(j));
  return std::abs(b[m]);
}

// By Arnoldi's method; exact with as many steps as the state has numbers. 0 if it could not begin.
double largest_multiplier(PeriodMap &map, const Numbers &y, const Numbers &image, const Held &held) {
  Numbers start(y.size());
  for (int i = 0; i < map.motion_numbers(); ++i) start[i] = std::sin(1 + 3.7 * i); // without structure
  Krylov krylov(map, y, image, held, start);
  while (krylov.steps() < std::min(most_directions, static_cast<int>(y.size())) && !krylov.complete())
    if (!krylov.extend()) break;
  const int m = krylov.steps();
  Dense H(m, m);
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < m; ++i) H(i, j) = krylov.H(i, j);
  double largest = 0;
  for (const auto &one : m > 0 ? eigenvalues(H) : std::vector<std::complex<double>>{})
    largest = std::max(largest, std::abs(one));
  return largest;
}

} // namespace

Orbit krylov_orbit(PeriodMap &map, Numbers y, double tolerance) {
  constexpr double linear_tolerance = 0.03, hopeless = 0.5;
  Orbit orbit;
  Numbers image, trial, trial_image;
  Held held, trial_held;
  double whole = 0, first = 0;
  bool good = map.next(y, image, held);
  for (int iteration = 0; good && !orbit.found && iteration < 15; ++iteration) {
    Numbers r = image;
    add(r, -1, y);
    whole = norm(r); // with what sliders moved that are held below: they go on from their new place
    if (iteration == 0) first = whole;
    Numbers drift(y.size());
    for (std::size_t i = 0; i < y.size(); ++i)
      if (map.is_held(i, held)) std::swap(drift[i], r[i]);
    const double size = norm(r);
    orbit.found = size == 0;
    if (orbit.found || !std::isfinite(size)) break;
    Krylov krylov(map, y, image, held, r);
    Numbers step;
    double left = size;
    while (left > linear_tolerance * size && krylov.steps() < most_directions && !krylov.complete()) {
      if (!(good = krylov.extend())) break;
      left = newton_step(krylov, size, step);
    }
    if (!good || !(left <= hopeless * size)) break;
    good = false;
    for (double part = 1; part > 0.1; part /= 2) { // shorter where the whole step makes it worse
      trial = y;
      add(trial, part, step), add(trial, 1, drift);
      if (!map.next(trial, trial_image, trial_held)) break;
      Numbers change = trial_image;
      add(change, -1, trial);
      const double scale = map.motion_size(trial), now = norm(change);
      if (now < (1 - part / 4) * whole || now < 1e-11 * scale) {
        good = true;
        orbit.nearer = now / first;
        y.swap(trial), image.swap(trial_image), held.swap(trial_held);
        // what is left of the way: as much as the linear solve left of it, or the residual where it is round-off
        orbit.found = part == 1 && (norm(step) * now / whole < tolerance * scale || now < 1e-12 * scale);
        break;
      }
    }
  }
  if (orbit.found) orbit.multiplier = largest_multiplier(map, y, image, held);
  orbit.state = map.state(y, {});
  return orbit;
}

} // namespace dovetail
