#include "transient/weighted_sum.hpp"

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

} // namespace dovetail
