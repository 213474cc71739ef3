#pragma once
// Time integration that shares nothing with the program's but the law of one instant, and what is compared with it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "contact/fourier.hpp"
#include "contact/law.hpp"
#include "contact/law_traits.hpp"
#include "harmonic/dense_model.hpp"

namespace dovetail::testing {

using Numbers = std::vector<double>;

template <class Number> std::vector<Number> solve(std::vector<Number> A, std::vector<Number> b) {
  const int n = static_cast<int>(b.size());
  for (int i = 0; i < n; ++i) {
    int pivot = i;
    for (int r = i; r < n; ++r)
      if (std::abs(A[r * n + i]) > std::abs(A[pivot * n + i])) pivot = r;
    for (int j = 0; j < n; ++j) std::swap(A[i * n + j], A[pivot * n + j]);
    std::swap(b[i], b[pivot]);
    for (int r = i + 1; r < n; ++r) {
      const Number factor = A[r * n + i] / A[i * n + i];
      for (int j = i; j < n; ++j) A[r * n + j] -= factor * A[i * n + j];
      b[r] -= factor * b[i];
    }
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int j = i + 1; j < n; ++j) b[i] -= A[i * n + j] * b[j];
    b[i] /= A[i * n + i];
  }
  return b;
}

inline double largest(const Numbers &a) {
  double most = 0;
  for (const double value : a) most = std::max(most, std::abs(value));
  return most;
}

inline double distance(const Numbers &a, const Numbers &b) {
  EXPECT_EQ(a.size(), b.size());
  double most = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most / largest(b);
}

// Runge and Kutta's steps, the law of one instant applied to each and the memory moved on after it. Shares nothing with
// the integration but that law. From q, v in z and sliders at w, to where they are some periods later; counts steps
// that slip and that are open.
inline void small_steps(const DenseModel &model, double omega, int periods, int per_period, Numbers &z,
                        std::vector<Memory> &w, std::array<long, 2> &seen) {
  const int n = model.dofs();
  Numbers inverse(n * n); // of M, a column at a time
  for (int j = 0; j < n; ++j) {
    Numbers unit(n);
    unit[j] = 1;
    const Numbers column = solve(model.M, unit);
    for (int i = 0; i < n; ++i) inverse[i * n + j] = column[i];
  }
  std::vector<Memory> next_w;
  const double h = 2 * std::acos(-1) / omega / per_period;
  const auto law = [&](int p, const double *x, Memory &memory) { // force, from w to `memory`
    const ContactPoint &point = model.contact[p];
    const Standstill &rest = model.standstill[p];
    std::array<double, 3> total, g{};
    for (int d = 0; d < 3; ++d) total[d] = x[d] + rest.x[d];
    const double closing = total[2] - point.gap;
    g[2] = !may_open(point.law) ? point.kn * closing : pressed(point.kn, closing);
    seen[1] += may_open(point.law) && closing < 0;
    if (has_friction(point.law)) {
      std::array<double, 2> T{point.kt[0] * (total[0] - w[p][0]), point.kt[1] * (total[1] - w[p][1])}, along;
      const std::array<double, 2> trial = T;
      if (shares_slider(point.law)) {
        if (slips(std::hypot(T[0], T[1]), point.mu[0] * g[2])) drawn_back(point.mu[0] * g[2], T, along);
      } else {
        for (int d = 0; d < 2; ++d) T[d] = rubbed(T[d], point.mu[d] * g[2]);
      }
      seen[0] += closing > 0 && T != trial;
      for (int d = 0; d < 2; ++d) g[d] = T[d], memory[d] = total[d] - T[d] / point.kt[d];
    }
    for (int d = 0; d < 3; ++d) g[d] -= rest.force[d];
    return g;
  };
  const auto rate = [&](double t, const Numbers &at) {
    Numbers load(n), out(2 * n);
    for (int i = 0; i < n; ++i) {
      load[i] = force_coefficient(model.loads, i, 0) / 2;
      for (int k = 1; k <= highest_harmonic(model.loads); ++k)
        load[i] += force_coefficient(model.loads, i, cosine(k)) * std::cos(k * omega * t) +
                   force_coefficient(model.loads, i, sine(k)) * std::sin(k * omega * t);
      for (int j = 0; j < n; ++j) {
        const double k = model.K[i * n + j];
        load[i] -= k * at[j] + model.viscous(i * n + j) * at[n + j];
      }
    }
    for (int p = 0; p < model.points; ++p) {
      const std::array<double, 3> g = law(p, &at[model.modes + 3 * p], next_w[p]);
      for (int d = 0; d < 3; ++d) load[model.modes + 3 * p + d] -= g[d];
    }
    for (int i = 0; i < n; ++i) {
      out[i] = at[n + i];
      for (int j = 0; j < n; ++j) out[n + i] += inverse[i * n + j] * load[j];
    }
    return out;
  };
  next_w = w;
  const auto moved = [&](double by, const Numbers &slope) {
    Numbers out = z;
    for (int i = 0; i < 2 * n; ++i) out[i] += by * slope[i];
    return out;
  };
  for (long step = 0; step < static_cast<long>(periods) * per_period; ++step) {
    const double t = step * h;
    const Numbers a = rate(t, z), b = rate(t + h / 2, moved(h / 2, a)), c = rate(t + h / 2, moved(h / 2, b)),
                  d = rate(t + h, moved(h, c));
    for (int i = 0; i < 2 * n; ++i) z[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
    for (int p = 0; p < model.points; ++p) law(p, &z[model.modes + 3 * p], next_w[p]);
    w = next_w;
  }
}

/// The state after that many periods from rest, displacements before velocities, in the limit of small steps: their
/// error goes with h^`order`. `seen` as above.
inline Numbers from_rest_in_small_steps(const DenseModel &model, double omega, int periods, int order,
                                        std::array<long, 2> &seen) {
  const auto with = [&](int per_period) {
    Numbers z(2 * model.dofs());
    std::vector<Memory> w;
    for (const Standstill &rest : model.standstill) w.push_back(rest.w);
    small_steps(model, omega, periods, per_period, z, w, seen);
    return z;
  };
  const Numbers coarse = with(8000);
  Numbers fine = with(16000);
  for (std::size_t i = 0; i < fine.size(); ++i) fine[i] += (fine[i] - coarse[i]) / ((1 << order) - 1);
  return fine;
}

} // namespace dovetail::testing
