#pragma once
// A number with its derivatives by a few others.
#include <array>
#include <cmath>

namespace dovetail {

template <int n> struct Jet {
  double value = 0;
  std::array<double, n> by{};

  Jet(double v = 0) : value(v) {} // a constant
  static Jet variable(double v, int i) {
    Jet x(v);
    x.by[i] = 1;
    return x;
  }
  Jet chain(double v, double slope) const { // of a function of this
    Jet out(v);
    for (int i = 0; i < n; ++i) out.by[i] = slope * by[i];
    return out;
  }

  friend Jet operator+(const Jet &a, const Jet &b) {
    Jet out(a.value + b.value);
    for (int i = 0; i < n; ++i) out.by[i] = a.by[i] + b.by[i];
    return out;
  }
  friend Jet operator-(const Jet &a, const Jet &b) { return a + b.chain(-b.value, -1); }
  friend Jet operator*(const Jet &a, const Jet &b) {
    Jet out(a.value * b.value);
    for (int i = 0; i < n; ++i) out.by[i] = a.by[i] * b.value + a.value * b.by[i];
    return out;
  }
  friend Jet operator/(const Jet &a, const Jet &b) { return a * b.chain(1 / b.value, -1 / (b.value * b.value)); }
};

inline double value_of(double x) { return x; }
template <int n> double value_of(const Jet<n> &x) { return x.value; }
template <int n> Jet<n> sqrt(const Jet<n> &x) {
  const double root = std::sqrt(x.value);
  return x.chain(root, root > 0 ? 0.5 / root : 0);
}
template <int n> Jet<n> exp(const Jet<n> &x) { return x.chain(std::exp(x.value), std::exp(x.value)); }

/// log(1 + x) / x
inline double log_mean(double x) {
  return std::abs(x) > 1e-4 ? std::log1p(x) / x : 1 - x * (0.5 - x * (1.0 / 3 - x / 4));
}
template <int n> Jet<n> log_mean(const Jet<n> &x) {
  const double mean = log_mean(x.value), v = x.value;
  return x.chain(mean, std::abs(v) > 1e-4 ? (1 / (1 + v) - mean) / v : -0.5 + v * (2.0 / 3 - 0.75 * v));
}

} // namespace dovetail
