// Derivatives of what goes on at a contact point.
#include <algorithm>
#include <cmath>

#include "transient/touch.hpp"
#include "transient/weighted_sum.hpp"

namespace dovetail {
namespace {

using Kind = TouchEvent::Kind;

enum Row { x1, x2, T1, T2, N, power, square, lambda, rows }; // of tangents_

// Of the direction of a vector (2) that changes by `change` (2, width).
void turn_direction(const std::array<double, 2> &vector, const std::vector<double> &change, int width, double *out) {
  const double size = std::hypot(vector[0], vector[1]), along[] = {vector[0] / size, vector[1] / size};
  for (int j = 0; j < width; ++j) {
    const double across = (along[0] * change[width + j] - along[1] * change[j]) / size;
    out[j] = -along[1] * across, out[width + j] = along[0] * across;
  }
}

} // namespace

// Of where a slider is left that its bound drags along: x_d - mu N e_d / k_t. side: e_d; turn: mu N / k_t.
void Touch::slid(int d, double side, double turn, int width, const double *dx, const double *de, double *out) const {
  std::copy_n(dx + d * width, width, out);
  add_scaled(width, -side * mu_[cone() ? 0 : d] * point_.kn / kt_[d], dx + 2 * width, out);
  if (turn != 0) add_scaled(width, -turn, de + d * width, out);
}

void Touch::begin_tangents(const TouchState &state, const std::array<double, 3> &x, const std::array<double, 3> &v,
                           const Memory &w, const std::vector<double> &dx, const std::vector<double> &dv, double *dw,
                           double *de) const {
  if (!state.closed) return;
  const int width = static_cast<int>(dx.size()) / 3;
  const double bound = mu_[0] * point_.kn * x[2];
  const std::array<double, 2> T{kt_[0] * (x[0] - w[0]), kt_[1] * (x[1] - w[1])};
  const bool gave = state.w != w;
  if (cone() && (state.slides || gave)) {
    const bool pulled = std::hypot(T[0], T[1]) > tiny_;
    std::vector<double> change(2 * width);
    for (int d = 0; d < 2; ++d) {
      add_scaled(width, kt_[d], (pulled ? dx : dv).data() + d * width, &change[d * width]);
      if (pulled) add_scaled(width, -kt_[d], dw + d * width, &change[d * width]);
    }
    turn_direction(pulled ? T : std::array<double, 2>{kt_[0] * v[0], kt_[1] * v[1]}, change, width, de);
  }
  for (int d = 0; d < 2 && gave; ++d) {
    if (cone())
      slid(d, state.along[d], bound / kt_[d], width, dx.data(), de, dw + d * width);
    else if (rubs(d) && state.w[d] != w[d])
      slid(d, T[d] < 0 ? -1 : 1, 0, width, dx.data(), de, dw + d * width);
  }
}

void Touch::expand_tangents(const TouchState &state, int k, int width, const double *dx, const double *dw,
                            const double *de, double *dg) {
  std::fill_n(dg, 3 * width, 0.0);
  add_scaled(width, point_.kn, dx + 2 * width, dg + 2 * width);
  if (cone() && state.slides) {
    expand_cone_tangents(state, k, width, dx, de);
    for (int d = 0; d < 2; ++d)
      std::copy_n(&tangents_[((T1 + d) * (series_order + 1) + k) * width], width, dg + d * width);
    return;
  }
  for (int d = 0; d < 2; ++d) {
    if (!rubs(d)) continue;
    if (state.side[d] != 0) {
      add_scaled(width, state.side[d] * mu_[d] * point_.kn, dx + 2 * width, dg + d * width);
      continue;
    }
    add_scaled(width, kt_[d], dx + d * width, dg + d * width);
    if (k == 0) add_scaled(width, -kt_[d], dw + d * width, dg + d * width);
  }
}

// Line by line that of expand_cone.
void Touch::expand_cone_tangents(const TouchState &state, int k, int width, const double *dx, const double *de) {
  const double mu = mu_[0];
  tangents_.resize(static_cast<std::size_t>(rows) * (series_order + 1) * width);
  const auto row = [&](int which, int order) {
    return &tangents_[static_cast<std::size_t>(which * (series_order + 1) + order) * width];
  };
  for (int d = 0; d < 2; ++d) std::copy_n(dx + d * width, width, row(x1 + d, k));
  std::fill_n(row(N, k), width, 0.0);
  add_scaled(width, point_.kn, dx + 2 * width, row(N, k));
  for (int d = 0; d < 2; ++d) std::fill_n(row(T1 + d, k), width, 0.0);
  if (k == 0 || frozen_) {
    for (int d = 0; d < 2; ++d) {
      add_scaled(width, mu * state.along[d], row(N, k), row(T1 + d, k));
      add_scaled(width, mu * force_[2][k], de + d * width, row(T1 + d, k));
    }
    return;
  }
  const int j = k - 1;
  double *dpower = row(power, j), *dsquare = row(square, j), *dlambda = row(lambda, j);
  std::fill_n(dsquare, width, 0.0), std::fill_n(dpower, width, 0.0);
  for (int i = 0; i <= j; ++i) {
    const int other = j - i + 1;
    for (int d = 0; d < 2; ++d) {
      add_scaled(width, other * kt_[d] * x_[d][other], row(T1 + d, i), dpower);
      add_scaled(width, other * kt_[d] * force_[d][i], row(x1 + d, other), dpower);
    }
    add_scaled(width, -other * mu * mu * force_[2][other], row(N, i), dpower);
    add_scaled(width, -other * mu * mu * force_[2][i], row(N, other), dpower);
    add_scaled(width, 2 * mu * mu * force_[2][i], row(N, j - i), dsquare);
  }
  std::copy_n(dpower, width, dlambda);
  for (int i = 0; i <= j; ++i) add_scaled(width, -lambda_[j - i], row(square, i), dlambda);
  for (int i = 1; i <= j; ++i) add_scaled(width, -square_[i], row(lambda, j - i), dlambda);
  for (int m = 0; m < width; ++m) dlambda[m] /= square_[0];
  for (int d = 0; d < 2; ++d) {
    double *dT = row(T1 + d, k);
    add_scaled(width, kt_[d], row(x1 + d, k), dT);
    for (int i = 0; i <= j; ++i) {
      add_scaled(width, -force_[d][j - i] / k, row(lambda, i), dT);
      add_scaled(width, -lambda_[i] / k, row(T1 + d, j - i), dT);
    }
  }
}

std::array<double, 2> Touch::turning(double t) const {
  std::array<double, 2> T{}, rate{};
  for (int d = 0; d < 2 && !frozen_; ++d)
    for (int k = series_order; k >= 0; --k) rate[d] = rate[d] * t + T[d], T[d] = T[d] * t + force_[d][k];
  if (frozen_) return {};
  std::vector<double> change{rate[0], rate[1]};
  std::array<double, 2> out;
  turn_direction(T, change, 1, out.data());
  return out;
}

void Touch::advance_tangents(const TouchState &state, double t, const TouchEvent &event, const std::array<double, 3> &x,
                             const std::array<double, 3> &v, const std::vector<double> &dx, double *dw,
                             double *de) const {
  const int width = static_cast<int>(dx.size()) / 3, d = event.direction;
  const Kind kind = event.kind;
  std::vector<double> change(2 * width);
  const bool slid_along = cone() && !frozen_ && (kind == Kind::sticks || (kind == Kind::none && state.slides));
  if (slid_along) {
    for (int e = 0; e < 2; ++e)
      for (int k = series_order; k >= 0; --k)
        scale_and_add(width, t, &tangents_[static_cast<std::size_t>((T1 + e) * (series_order + 1) + k) * width],
                      &change[e * width]);
    turn_direction({value(force_[0], t), value(force_[1], t)}, change, width, de);
  }
  if (kind == Kind::sticks) {
    for (int e = 0; e < 2; ++e)
      if (cone())
        slid(e, state.along[e], mu_[0] * point_.kn * x[2] / kt_[e], width, dx.data(), de, dw + e * width);
      else if (e == d)
        slid(e, event.side, 0, width, dx.data(), de, dw + e * width);
  } else if (kind == Kind::slips && cone()) {
    for (int e = 0; e < 2; ++e) {
      add_scaled(width, kt_[e], &dx[e * width], &change[e * width]);
      add_scaled(width, -kt_[e], dw + e * width, &change[e * width]);
    }
    turn_direction({kt_[0] * (x[0] - state.w[0]), kt_[1] * (x[1] - state.w[1])}, change, width, de);
  } else if (kind == Kind::lands) {  // the sooner by dx_n / v_n
    std::fill_n(de, 2 * width, 0.0); // whither a cone began to slip is forgotten at once
    for (int e = 0; e < 2; ++e) {
      std::copy_n(&dx[e * width], width, dw + e * width);
      add_scaled(width, -v[e] / v[2], &dx[2 * width], dw + e * width);
    }
  }
}

void Touch::slider_tangents(const TouchState &state, const std::array<double, 3> &x, const std::vector<double> &dx,
                            const double *dw, const double *de, double *out) const {
  const int width = static_cast<int>(dx.size()) / 3;
  for (int d = 0; d < 2; ++d) {
    double *own = out + d * width;
    std::copy_n(dw + d * width, width, own);
    if (!has_friction(point_.law))
      std::fill_n(own, width, 0.0);
    else if (!state.closed || !rubs(d))
      std::copy_n(&dx[d * width], width, own);
    else if (state.slides)
      slid(d, state.along[d], mu_[0] * point_.kn * x[2] / kt_[d], width, dx.data(), de, own);
    else if (state.side[d] != 0)
      slid(d, state.side[d], 0, width, dx.data(), de, own);
  }
}

} // namespace dovetail
