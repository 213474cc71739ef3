// Values at the ends of a grid's cells, by sums for few harmonics and by transforms for many, against sums written out.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "contact/fourier.hpp"
#include "contact/trigonometric.hpp"
#include "contact/wide.hpp"

using namespace dovetail;

TEST(Grid, samples_values_and_slopes) {
  for (const int H : {1, 10, 47, 48, 61, 200}) {
    std::vector<double> q(coefficient_count(H));
    for (std::size_t i = 0; i < q.size(); ++i) q[i] = std::sin(1 + 1.7 * static_cast<double>(i)) / (1 + 0.1 * i);
    const Grid grid(H);
    EXPECT_GE(grid.cells, 8 * H);
    EXPECT_GT(grid.ends, grid.cells);
    for (const auto &[first, last] : {std::pair(0, grid.cells - 1), std::pair(grid.cells / 3, grid.cells / 2)}) {
      std::vector<double> value(grid.ends), slope(grid.ends);
      grid.sample(q.data(), first, last, value.data(), slope.data());
      for (int j = first; j <= last + 1; ++j) {
        double f = q[0] / 2, df = 0;
        for (int k = 1; k <= H; ++k) {
          const double c = std::cos(k * j * grid.width), s = std::sin(k * j * grid.width);
          f += q[cosine(k)] * c + q[sine(k)] * s, df += k * (q[sine(k)] * c - q[cosine(k)] * s);
        }
        ASSERT_NEAR(value[j], f, 1e-11) << H << " " << j;
        ASSERT_NEAR(slope[j], df, 1e-11 * H) << H << " " << j;
      }
    }
  }
}

// Some vectors at a time, and no more than those that hold what is asked for.
TEST(Grid, samples_no_more_than_is_asked_for) {
  constexpr int H = 10, together = at_a_time * lane_count;
  const Grid grid(H);
  const std::vector<double> q(coefficient_count(H), 1.0);
  for (const auto &[first, from, to] : {std::array{0, 0, together}, {together + 3, together, 2 * together}}) {
    std::vector<double> value(grid.ends, 99.0), slope(grid.ends, 99.0);
    grid.sample(q.data(), first, to - 2, value.data(), slope.data());
    for (int j = 0; j < grid.ends; ++j) {
      EXPECT_EQ(value[j] != 99, from <= j && j < to) << first << " " << j;
      EXPECT_EQ(slope[j] != 99, from <= j && j < to) << first << " " << j;
    }
  }
}
