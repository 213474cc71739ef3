#include "transient/period_map.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dovetail {

double dot(const Numbers &a, const Numbers &b) { return std::inner_product(a.begin(), a.end(), b.begin(), 0.0); }
double norm(const Numbers &a) { return std::sqrt(dot(a, a)); }
void add(Numbers &y, double factor, const Numbers &x) {
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += factor * x[i];
}

PeriodMap::PeriodMap(Flow &flow, long periods) : flow_(flow), left_(periods) {
  for (const double w2 : flow.modes().w2) weights_.push_back(std::max(std::sqrt(w2), flow.omega()));
  weights_.resize(2 * weights_.size(), 1.0);
  for (const ContactPoint &point : flow.model().contact)
    for (int d = 0; d < 2; ++d) weights_.push_back(has_friction(point.law) ? std::sqrt(point.kt[d]) : 1);
}

Numbers PeriodMap::numbers(const Flow::State &state) const {
  Numbers y = state.eta;
  y.insert(y.end(), state.rate.begin(), state.rate.end());
  const std::vector<Memory> w = flow_.sliders(state);
  for (std::size_t point = 0; point < w.size(); ++point)
    for (int d = 0; d < 2; ++d) y.push_back(w[point][d] - flow_.model().standstill[point].w[d]);
  for (std::size_t i = 0; i < y.size(); ++i) y[i] *= weights_[i];
  return y;
}

// Sliders of that motion.
std::vector<Memory> PeriodMap::memories(const Numbers &y) const {
  std::vector<Memory> w;
  for (int point = 0; point < flow_.model().points; ++point) {
    const Memory &at_rest = flow_.model().standstill[point].w;
    const int i = motion_numbers() + 2 * point;
    w.push_back({y[i] / weights_[i] + at_rest[0], y[i + 1] / weights_[i + 1] + at_rest[1]});
  }
  return w;
}

Flow::State PeriodMap::state(Numbers y, const Held &held) const {
  const std::vector<Memory> w = memories(y);
  for (std::size_t i = 0; i < y.size(); ++i) y[i] /= weights_[i];
  const int n = flow_.modes().count;
  return flow_.modal_state({y.begin(), y.begin() + n}, {y.begin() + n, y.begin() + 2 * n}, w, held);
}

bool PeriodMap::next(const Numbers &y, Numbers &out, Held &still) {
  Flow::State at = state(y, {});
  if (!march(at, out)) return false;
  still.clear();
  for (const TouchState &touch : at.touch)
    still.push_back({touch.moved[0] <= 1e-5 * flow_.reach(), touch.moved[1] <= 1e-5 * flow_.reach()});
  return true;
}

bool PeriodMap::next_held(const Numbers &y, Numbers &out, const Held &held) {
  Flow::State at = state(y, held);
  return march(at, out);
}

bool PeriodMap::next_with_derivative(const Numbers &y, const Held &held, double turning, Numbers &out,
                                     Dense &derivative) {
  if (left_-- <= 0) return false;
  ++used_;
  const int n = flow_.modes().count, N = static_cast<int>(size());
  Flow::State at = state(y, held);
  Tangents tangents = flow_.tangents(N);
  tangents.turning = turning;
  for (int i = 0; i < N; ++i) {
    Dense &of = i < n ? tangents.eta : i < 2 * n ? tangents.rate : tangents.slider;
    of(i, i < n ? i : i < 2 * n ? i - n : i - 2 * n) = 1 / weights_[i];
  }
  flow_.begin(at, memories(y), tangents);
  if (!flow_.period(at, tangents)) return false;
  out = numbers(at);
  const Dense sliders = flow_.slider_tangents(at, tangents);
  derivative.reset(N, N + 1);
  for (int i = 0; i < N; ++i) {
    const double *row = i < n       ? tangents.eta.column(i)
                        : i < 2 * n ? tangents.rate.column(i - n)
                                    : sliders.column(i - 2 * n);
    for (int j = 0; j <= N; ++j) derivative(i, j) = weights_[i] * row[j];
  }
  return std::isfinite(norm(derivative.values));
}

bool PeriodMap::is_held(std::size_t i, const Held &held) const {
  const int slider = static_cast<int>(i) - motion_numbers();
  return slider >= 0 && held[slider / 2][slider % 2];
}

bool PeriodMap::march(Flow::State &at, Numbers &out) {
  if (left_-- <= 0) return false;
  ++used_;
  if (!flow_.period(at, 0, motion_)) return false;
  out = numbers(at);
  return true;
}

} // namespace dovetail
