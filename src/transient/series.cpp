#include "transient/series.hpp"

#include <algorithm>
#include <cmath>

namespace dovetail {
namespace {

constexpr int p = series_order;
constexpr double none = 2;
constexpr int deepest = 40; // halvings: to 1e-12 of the step, where two zeros are one

// (p+1, p+1): binomial(i, k) / binomial(p, k) in row k, from powers to Bernstein's basis.
const std::array<Series, p + 1> to_bernstein = [] {
  std::array<Series, p + 1> t{};
  for (int i = 0; i <= p; ++i) {
    t[0][i] = 1;
    for (int k = 1; k <= i; ++k) t[k][i] = t[k - 1][i] * (i - k + 1) / (p - k + 1);
  }
  return t;
}();

// The one zero between low, where c is not negative, and high, where it is.
double polish(const Series &c, double low, double high) {
  double t = (low + high) / 2;
  for (int i = 0; i < 100 && high - low > 1e-16 * high; ++i) {
    double f = c[p], df = p * c[p], k = p - 1; // value and derivative, side by side
    for (auto term = c.rbegin() + 1; k > 0; --k, ++term) f = f * t + *term, df = df * t + k * *term;
    f = f * t + c[0];
    (f < 0 ? high : low) = t;
    const double newton = t - f / df;
    const double next = newton > low && newton < high ? newton : (low + high) / 2;
    if (std::abs(next - t) <= 1e-16 * high) return next;
    t = next;
  }
  return high;
}

// b: c between low and high in Bernstein's basis; c lies in the hull of these numbers.
double first_in(const Series &c, const Series &b, double low, double high, double limit, int depth) {
  if (low >= limit) return none;
  if (b[0] < 0) return low;
  int changes = 0;
  for (int i = 1; i <= p; ++i) changes += (b[i] < 0) != (b[i - 1] < 0);
  if (changes == 0) return none;
  if (changes == 1) return limit < high && value(c, limit) >= 0 ? none : polish(c, low, high);
  if (depth == deepest) return b[p] < 0 ? high : none;
  Series left, right = b; // de Casteljau at one half
  left[0] = b[0];
  for (int level = 1; level <= p; ++level) {
    for (int i = 0; i <= p - level; ++i) right[i] = (right[i] + right[i + 1]) / 2;
    left[level] = right[0];
  }
  const double middle = (low + high) / 2, first = first_in(c, left, low, middle, limit, depth + 1);
  return first <= 1 ? first : first_in(c, right, middle, high, limit, depth + 1);
}

} // namespace

double value(const Series &c, double t) {
  double sum = c[p];
  for (int k = p - 1; k >= 0; --k) sum = sum * t + c[k];
  return sum;
}

double first_below_zero(const Series &c, double limit) {
  double others = 0;
  for (int k = 1; k <= p; ++k) others += std::abs(c[k]);
  if (c[0] > others) return none;
  Series b{};
  for (int k = 0; k <= p; ++k)
    for (int i = k; i <= p; ++i) b[i] += to_bernstein[k][i] * c[k];
  return first_in(c, b, 0, 1, limit, 0);
}

} // namespace dovetail
