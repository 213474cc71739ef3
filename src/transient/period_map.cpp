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

Flow::State PeriodMap::state(Numbers y, const Held &held) const {
  for (std::size_t i = 0; i < y.size(); ++i) y[i] /= weights_[i];
  const int n = flow_.modes().count;
  std::vector<Memory> w;
  for (int point = 0; point < flow_.model().points; ++point) {
    const Memory &at_rest = flow_.model().standstill[point].w;
    const double *own = &y[2 * n + 2 * point];
    w.push_back({own[0] + at_rest[0], own[1] + at_rest[1]});
  }
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
