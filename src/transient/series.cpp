#include "transient/series.hpp"

#include <algorithm>
#include <cmath>

#include "transient/weighted_sum.hpp"

namespace dovetail {
namespace {

constexpr double none = 2;
constexpr int deepest = 40; // halvings: to 1e-12 of the step, where two zeros are one

constexpr int width = 24; // of a row of these tables, and of numbers in Bernstein's basis: whole vectors
using Bernstein = std::array<double, width>;
using Table =
    std::array<double, (series_order + 1) * width>; // by rows, (series_order+1, series_order+1) of it not zero

// binomial(i, k) / binomial(series_order, k) in row k, from powers to Bernstein's basis.
const Table to_bernstein = [] {
  Table t{};
  for (int i = 0; i <= series_order; ++i) {
    t[i] = 1;
    for (int k = 1; k <= i; ++k) t[k * width + i] = t[(k - 1) * width + i] * (i - k + 1) / (series_order - k + 1);
  }
  return t;
}();

// binomial(i, k) / 2^i in row k, column i: the basis of the first half, by de Casteljau's method.
const Table to_first_half = [] {
  Table t{};
  t[0] = 1;
  for (int i = 1; i <= series_order; ++i)
    for (int k = 0; k <= i; ++k)
      t[k * width + i] = (t[k * width + i - 1] + (k > 0 ? t[(k - 1) * width + i - 1] : 0)) / 2;
  return t;
}();

// Of the second half: the same from the other side.
const Table to_second_half = [] {
  Table t{};
  for (int k = 0; k <= series_order; ++k)
    for (int i = 0; i <= series_order; ++i)
      t[k * width + i] = to_first_half[(series_order - k) * width + series_order - i];
  return t;
}();

// The sum and its derivative: four sums of every fourth term side by side, since each addition waits for the one
// before.
std::array<double, 2> value_and_slope(const Series &c, double t) {
  constexpr int parts = 4;
  static_assert(series_order % parts == 0);
  const double power = t * t * t * t;
  std::array<double, parts> f{c[series_order]}, df{}; // of the power
  for (int first = series_order - parts; first >= 0; first -= parts)
    for (int i = 0; i < parts; ++i) df[i] = df[i] * power + f[i], f[i] = f[i] * power + c[first + i];
  return {f[0] + t * (f[1] + t * (f[2] + t * f[3])),
          f[1] + t * (2 * f[2] + t * (3 * f[3] + t * 4 * (df[0] + t * (df[1] + t * (df[2] + t * df[3])))))};
}

// The one zero between low, where c is not negative, and high, where it is; t: about there. Nearer than rounding allows
// it is not to be had.
double polish(const Series &c, double low, double high, double t) {
  double size = 0;
  for (const double term : c) size += std::abs(term);
  for (int i = 0; i < 100 && high - low > 1e-16 * high; ++i) {
    const auto [f, slope] = value_and_slope(c, t);
    if (std::abs(f) <= 2e-16 * size) return t;
    (f < 0 ? high : low) = t;
    const double newton = t - f / slope, next = newton > low && newton < high ? newton : (low + high) / 2;
    if (std::abs(next - t) <= 1e-16 * high) return next;
    t = next;
  }
  return high;
}

// b: c between low and high in Bernstein's basis; c lies in the hull of these numbers.
double first_in(const Series &c, const Bernstein &b, double low, double high, double limit, int depth) {
  if (low >= limit) return none;
  if (b[0] < 0) return low;
  int changes = 0;
  for (int i = 1; i <= series_order; ++i) changes += (b[i] < 0) != (b[i - 1] < 0);
  if (changes == 0) return none;
  if (changes == 1) {
    if (limit < high && value(c, limit) >= 0) return none;
    const auto i = std::find_if(b.begin(), b.end(), [](double value) { return value < 0; }) - b.begin();
    return polish(c, low, high, low + (high - low) * (i - 1 + b[i - 1] / (b[i - 1] - b[i])) / series_order);
  }
  if (depth == deepest) return b[series_order] < 0 ? high : none;
  Bernstein half;
  combine(series_order + 1, width, b.data(), to_first_half.data(), half.data());
  const double middle = (low + high) / 2, first = first_in(c, half, low, middle, limit, depth + 1);
  if (first <= 1) return first;
  combine(series_order + 1, width, b.data(), to_second_half.data(), half.data());
  return first_in(c, half, middle, high, limit, depth + 1);
}

} // namespace

double value(const Series &c, double t) {
  double sum = c[series_order];
  for (int k = series_order - 1; k >= 0; --k) sum = sum * t + c[k];
  return sum;
}

double first_below_zero(const Series &c, double limit) {
  double others = 0;
  for (int k = 1; k <= series_order; ++k) others += std::abs(c[k]);
  if (c[0] > others) return none;
  Bernstein b;
  combine(series_order + 1, width, c.data(), to_bernstein.data(), b.data());
  return first_in(c, b, 0, 1, limit, 0);
}

} // namespace dovetail
