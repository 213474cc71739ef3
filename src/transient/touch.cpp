#include "transient/touch.hpp"

#include <algorithm>
#include <cmath>

#include "contact/law_traits.hpp"

namespace dovetail {
namespace {

using Kind = TouchEvent::Kind;

double dot(const std::array<double, 2> &a, const std::array<double, 2> &b) { return a[0] * b[0] + a[1] * b[1]; }

} // namespace

Touch::Touch(const ContactPoint &point, const Standstill &rest, const std::array<double, 3> &mobility, double shortest)
    : point_(point), rest_(rest), kt_(has_friction(point.law) ? point.kt : std::array<double, 2>{}),
      mu_(has_friction(point.law) ? point.mu : std::array<double, 2>{}), origin_{rest.x[0], rest.x[1],
                                                                                 rest.x[2] - point.gap} {
  double square = point.kn * mobility[2];
  for (int d = 0; d < 2; ++d) square = std::max(square, kt_[d] * mobility[d]);
  rate_ = std::sqrt(square);
  brief_ = 1e-4 * std::min(1 / rate_, shortest); // impulse of the friction force over it: 1e-8 of that of the contact
}

void Touch::reach(double displacement) {
  const double origin = std::abs(rest_.x[0]) + std::abs(rest_.x[1]) + std::abs(rest_.x[2]) + std::abs(point_.gap);
  tiny_ = 1e-14 * std::max({point_.kn, kt_[0], kt_[1]}) * (origin + displacement);
}

TouchState Touch::at(const double *x, const double *v, const Memory &w, const std::array<bool, 2> &held) const {
  TouchState state;
  state.w = w, state.held = held;
  state.closed = !may_open(point_.law) || x[2] > 0 || (x[2] == 0 && v[2] > 0);
  if (!state.closed) return state;
  const double N = point_.kn * x[2], growth = point_.kn * v[2];
  std::array<double, 2> T, V;
  for (int d = 0; d < 2; ++d) T[d] = kt_[d] * (x[d] - w[d]), V[d] = kt_[d] * v[d];
  if (cone()) {
    const double mu = mu_[0], size = std::hypot(T[0], T[1]), speed = std::hypot(V[0], V[1]);
    if (size < mu * N - tiny_ || held[0]) return state;
    if (size > tiny_)
      state.along = {T[0] / size, T[1] / size};
    else if (speed > 0) // it has just landed
      state.along = {V[0] / speed, V[1] / speed};
    state.slides = dot(state.along, V) > mu * growth;
    for (int d = 0; d < 2 && size > mu * N; ++d) state.w[d] = x[d] - mu * N * state.along[d] / kt_[d];
    state.moved[0] = std::hypot(state.w[0] - w[0], state.w[1] - w[1]);
    return state;
  }
  for (int d = 0; d < 2; ++d) {
    if (!rubs(d) || std::abs(T[d]) < mu_[d] * N - tiny_ || held[d]) continue;
    const int side = (std::abs(T[d]) > tiny_ ? T[d] : V[d]) < 0 ? -1 : 1;
    if (side * V[d] > mu_[d] * growth) state.side[d] = side;
    if (std::abs(T[d]) > mu_[d] * N) state.w[d] = x[d] - side * mu_[d] * N / kt_[d];
    state.moved[d] = std::abs(state.w[d] - w[d]);
  }
  return state;
}

void Touch::expand(const TouchState &state, int k, const double *x, double *g) {
  for (int d = 0; d < 3; ++d) x_[d][k] = x[d], force_[d][k] = 0;
  force_[2][k] = point_.kn * x[2];
  if (cone() && state.slides)
    expand_cone(state, k);
  else
    for (int d = 0; d < 2; ++d)
      if (rubs(d))
        force_[d][k] =
            state.side[d] != 0 ? state.side[d] * mu_[d] * force_[2][k] : kt_[d] * (k == 0 ? x[d] - state.w[d] : x[d]);
  for (int d = 0; d < 3; ++d) g[d] = force_[d][k];
}

// Where N begins or ends, the direction of slip is a singular equation. Very near to it, it hardly moves.
void Touch::expand_cone(const TouchState &state, int k) {
  const double mu = mu_[0];
  const Series &N = force_[2];
  Series &T1 = force_[0], &T2 = force_[1];
  if (k == 1) frozen_ = N[0] <= std::abs(N[1]) * brief_ + tiny_;
  if (k == 0 || frozen_) {
    for (int d = 0; d < 2; ++d) force_[d][k] = mu * N[k] * state.along[d];
    return;
  }
  const int j = k - 1; // the term of lambda and of T' that T' = k_t x' - lambda T wants now
  double power = 0, square = 0;
  for (int i = 0; i <= j; ++i) {
    const double order = j - i + 1;
    power +=
        order * (kt_[0] * T1[i] * x_[0][j - i + 1] + kt_[1] * T2[i] * x_[1][j - i + 1] - mu * mu * N[i] * N[j - i + 1]);
  }
  for (int i = 0; i <= j; ++i) square += mu * mu * N[i] * N[j - i];
  power_[j] = power, square_[j] = square;
  for (int i = 1; i <= j; ++i) power -= square_[i] * lambda_[j - i];
  lambda_[j] = power / square_[0];
  for (int d = 0; d < 2; ++d) {
    double sum = k * kt_[d] * x_[d][k];
    for (int i = 0; i <= j; ++i) sum -= lambda_[i] * force_[d][j - i];
    force_[d][k] = sum / k;
  }
}

double Touch::longest(const TouchState &state) const {
  if (!state.closed || !state.slides) return HUGE_VAL;
  if (frozen_) return 2 * brief_;
  const double allowed = 1e-10 * std::hypot(force_[0][0], force_[1][0]);
  double step = HUGE_VAL;
  for (const int k : {series_order - 1, series_order})
    for (int d = 0; d < 2; ++d)
      if (force_[d][k] != 0) step = std::min(step, std::pow(allowed / std::abs(force_[d][k]), 1.0 / k));
  return step;
}

// Notes the event if the guard falls below zero before it.
void Touch::look(TouchEvent &event, Kind kind, Series guard, const Series &powers, int d, int s) const {
  for (int k = 0; k <= series_order; ++k) guard[k] *= powers[k];
  guard[0] += kind == Kind::sticks ? tiny_ * rate_ : tiny_;
  const double at = first_below_zero(guard, event.at);
  if (at < event.at) event = {kind, at, d, s};
}

TouchEvent Touch::next(const TouchState &state, const Series &powers, double before) const {
  TouchEvent event;
  event.at = before;
  if (!may_open(point_.law)) return event;
  Series guard;
  const Series &N = force_[2];
  if (!state.closed) {
    for (int k = 0; k <= series_order; ++k) guard[k] = -point_.kn * x_[2][k];
    look(event, Kind::lands, guard, powers);
    return event;
  }
  look(event, Kind::opens, N, powers);
  if (cone()) {
    look_at_cone(state, event, powers);
    return event;
  }
  for (int d = 0; d < 2; ++d) {
    if (!rubs(d)) continue;
    if (const int s = state.side[d]; s != 0) { // slips as long as the slider moves to that side
      for (int k = 0; k < series_order; ++k) guard[k] = (k + 1) * (s * kt_[d] * x_[d][k + 1] - mu_[d] * N[k + 1]);
      guard[series_order] = 0;
      look(event, Kind::sticks, guard, powers, d, s);
      continue;
    }
    for (const int s : {1, -1}) {
      if (state.held[d]) continue;
      for (int k = 0; k <= series_order; ++k) guard[k] = mu_[d] * N[k] - s * force_[d][k];
      look(event, Kind::slips, guard, powers, d, s);
    }
  }
  return event;
}

void Touch::look_at_cone(const TouchState &state, TouchEvent &event, const Series &powers) const {
  const double mu = mu_[0];
  const Series &N = force_[2];
  Series guard{};
  if (state.slides) {
    if (frozen_) return;
    std::copy_n(power_.begin(), series_order, guard.begin());
    for (double &term : guard) term /= mu * N[0];
    look(event, Kind::sticks, guard, powers);
    return;
  }
  if (state.held[0]) return;
  std::array<double, 3> rest{}; // bounds of what the later terms come to
  for (int d = 0; d < 3; ++d)
    for (int k = 1; k <= series_order; ++k) rest[d] += std::abs(force_[d][k]) * powers[k];
  const double size = std::hypot(std::abs(force_[0][0]) + rest[0], std::abs(force_[1][0]) + rest[1]);
  if (mu * (N[0] - rest[2]) > size) return;
  const double scale = mu * std::abs(N[0]) + size; // (mu N)^2 - |T|^2, in the unit of a force
  for (int k = 0; k <= series_order; ++k)
    for (int i = 0; i <= k; ++i)
      guard[k] +=
          (mu * mu * N[i] * N[k - i] - force_[0][i] * force_[0][k - i] - force_[1][i] * force_[1][k - i]) / scale;
  look(event, Kind::slips, guard, powers);
}

void Touch::advance(TouchState &state, double t, const TouchEvent &event, const std::array<double, 3> &x,
                    const std::array<double, 3> &v) const {
  if (cone() && state.slides) {
    const std::array<double, 2> T{value(force_[0], t), value(force_[1], t)};
    const double size = std::hypot(T[0], T[1]);
    for (int d = 0; d < 2 && size > 0 && !frozen_; ++d) state.along[d] = T[d] / size;
  }
  const int d = event.direction;
  switch (event.kind) {
  case Kind::none:
    break;
  case Kind::opens: {
    TouchState open;
    open.held = state.held, open.moved = {HUGE_VAL, HUGE_VAL};
    state = open;
    break;
  }
  case Kind::lands: {
    const std::array<double, 3> touching{x[0], x[1], std::max(x[2], 0.0)};
    const std::array<double, 2> moved = state.moved;
    state = at(touching.data(), v.data(), {x[0], x[1]}, state.held);
    state.closed = true, state.moved = moved;
    break;
  }
  case Kind::slips:
    if (cone()) {
      const std::array<double, 2> T{value(force_[0], t), value(force_[1], t)};
      const double size = std::hypot(T[0], T[1]);
      for (int e = 0; e < 2; ++e) state.along[e] = size > 0 ? T[e] / size : e == 0;
      state.slides = true;
    } else {
      state.side[d] = event.side;
    }
    break;
  case Kind::sticks: {
    const Memory w = sliders(state, x.data());
    if (cone()) {
      state.moved[0] = std::max(state.moved[0], std::hypot(w[0] - state.w[0], w[1] - state.w[1]));
      state.w = w, state.slides = false;
    } else {
      state.moved[d] = std::max(state.moved[d], std::abs(w[d] - state.w[d]));
      state.w[d] = w[d], state.side[d] = 0;
    }
    break;
  }
  }
}

Memory Touch::sliders(const TouchState &state, const double *x) const {
  if (!has_friction(point_.law)) return rest_.w;
  Memory w = state.w;
  const double N = point_.kn * x[2];
  for (int d = 0; d < 2; ++d) {
    if (!state.closed || !rubs(d))
      w[d] = x[d];
    else if (state.slides)
      w[d] = x[d] - mu_[0] * N * state.along[d] / kt_[d];
    else if (state.side[d] != 0)
      w[d] = x[d] - state.side[d] * mu_[d] * N / kt_[d];
  }
  return w;
}

} // namespace dovetail
