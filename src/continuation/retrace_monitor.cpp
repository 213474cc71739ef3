#include "continuation/retrace_monitor.hpp"

#include <array>
#include <cmath>

namespace dovetail {
namespace {

constexpr double many = 10; // lengths of a piece: its cubic ends nearer, unless a tangent stands at 88 degrees to it

} // namespace

RetraceMonitor::Sense RetraceMonitor::add(const Problem &problem, Vec y, Vec t, double motion) {
  return add(problem.projected({y, t}), motion);
}

RetraceMonitor::Sense RetraceMonitor::add(const std::vector<Problem::Projected> &of, double motion) {
  for (const Problem::Projected &mark : of) marks_.append(mark);
  const int sense = older(motion);
  found_ = sense == 0 ? 0 : sense == sense_ ? found_ + 1 : 1;
  sense_ = sense;
  return found_ < enough ? Sense::fresh : sense > 0 ? Sense::same : Sense::opposite;
}

// The first piece from mark i on that may be near a place `far`, less the way up to i, from it.
int RetraceMonitor::first_near(int i, int last, double far) const {
  while (i + 4 < last && far - way_[i] > many * (way_[i + 1] - way_[i])) ++i;
  return i;
}

double RetraceMonitor::Weights::product(const double *a, const double *b) const {
  double sum = 0;
  for (int k = 0; k < size; ++k) sum += a[k] * b[k] * unit[k > 0] * unit[k > 0];
  return sum;
}

// The way up to each mark that has been added.
void RetraceMonitor::lengthen_way(const Weights &weights) {
  if (way_.empty()) way_.push_back(0);
  for (int i = static_cast<int>(way_.size()); i < count(); ++i) {
    const double *a = marks_.begin() + 2 * size * (i - 1), *b = a + 2 * size;
    std::array<double, size> chord;
    for (int k = 0; k < size; ++k) chord[k] = b[k] - a[k];
    way_.push_back(way_.back() + std::sqrt(weights.product(chord.data(), chord.data())));
  }
}

// Marks lie closer to each other the larger the motion that they are measured by.
int RetraceMonitor::older(double motion) {
  const int last = count() - 1;
  const Weights weights{{1 / unit_, motion > 0 ? 1 / motion : 1}};
  const double *here = marks_.begin() + 2 * size * last;
  const auto weighted = [&](const double *a, const double *b) { return weights.product(a, b); };
  std::array<double, size> chord, to;
  lengthen_way(weights);
  for (int i = 0; i + 4 < last; ++i) { // the piece from mark i to the next: a cubic over its chord
    const double *a = marks_.begin() + 2 * size * i, *b = a + 2 * size;
    for (int k = 0; k < size; ++k) chord[k] = b[k] - a[k], to[k] = here[k] - a[k];
    const double far = way_[i] + std::sqrt(weighted(to.data(), to.data()));
    if (const int next = first_near(i, last, far); next > i) {
      i = next - 1;
      continue;
    }
    const double length2 = weighted(chord.data(), chord.data()), s = weighted(chord.data(), to.data()) / length2;
    if (!(s >= 0 && s <= 1)) continue;
    const double rise_a = weighted(a + size, chord.data()) / length2,
                 rise_b = weighted(b + size, chord.data()) / length2;
    if (!(rise_a > 0 && rise_b > 0)) continue;
    std::array<double, size> away;
    for (int k = 0; k < size; ++k)
      away[k] = to[k] - (3 - 2 * s) * s * s * chord[k] -
                s * (1 - s) * ((1 - s) * a[size + k] / rise_a - s * b[size + k] / rise_b);
    if (weighted(away.data(), away.data()) > 1e-6 * length2) continue;
    met_ = i;
    return weighted(here + size, chord.data()) > 0 ? 1 : -1;
  }
  return 0;
}

} // namespace dovetail
