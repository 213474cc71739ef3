#include "transient/weighted_sum.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "contact/wide.hpp"

namespace dovetail {

DOVETAIL_WIDE void combine(int rows, int columns, const double *weights, const double *table, double *out) {
  int j = 0;
  for (; j + lane_count <= columns; j += lane_count) { // two sums: an addition takes longer than its turn
    Lanes even{}, odd{};
    const double *row = table + j;
    int i = 0;
    for (; i + 2 <= rows; i += 2, row += 2 * columns)
      even += weights[i] * load<Lanes>(row), odd += weights[i + 1] * load<Lanes>(row + columns);
    if (i < rows) even += weights[i] * load<Lanes>(row);
    store<Lanes>(even + odd, out + j);
  }
  for (; j < columns; ++j) {
    double sum = 0;
    for (int i = 0; i < rows; ++i) sum += weights[i] * table[static_cast<std::size_t>(i) * columns + j];
    out[j] = sum;
  }
}

DOVETAIL_WIDE void next_term(const NextTerm &of, double share, double by_stiffness, double by_mass, const double *now,
                             const double *then, const double *table, double *out) {
  for (int i = 0; i < of.rows; ++i) {
    const double *a = now + static_cast<std::size_t>(i) * of.columns, *b = then + (a - now);
    double *to = out + (a - now);
    for (int j = 0; j + lane_count <= of.columns; j += lane_count) {
      const Lanes rate = load<Lanes>(b + j);
      Lanes sum = of.w2[i] * (load<Lanes>(a + j) + by_stiffness * rate) + by_mass * rate;
      for (int c = 0; c < of.pulled; ++c)
        sum += of.weights[static_cast<std::size_t>(c) * of.stride + i] *
               load<Lanes>(table + static_cast<std::size_t>(c) * of.columns + j);
      store<Lanes>(-share * sum, to + j);
    }
  }
}

DOVETAIL_WIDE void add_scaled(int count, double a, const double *x, double *y) {
  for (int i = 0; i < count; ++i) y[i] += a * x[i];
}

DOVETAIL_WIDE void scale_and_add(int count, double a, const double *x, double *y) {
  for (int i = 0; i < count; ++i) y[i] = x[i] + a * y[i];
}

DOVETAIL_WIDE double largest_of(int count, const double *x) {
  Lanes largest{};
  int i = 0;
  for (; i + lane_count <= count; i += lane_count) {
    const Lanes value = load<Lanes>(x + i), size = value < 0 ? -value : value;
    largest = size > largest ? size : largest;
  }
  double out = 0;
  for (; i < count; ++i) out = std::max(out, std::abs(x[i]));
  for (int j = 0; j < lane_count; ++j) out = std::max(out, largest[j]);
  return out;
}

} // namespace dovetail
