// What modes leave out of one index, where the answers to some probes are such modes and nothing but round-off is left.
#include <gtest/gtest.h>

#include <cmath>

#include "reduction/sector_left_out.hpp"
#include "some_sector.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr int n = 4;

ComplexDense identity() {
  ComplexDense one(n, n);
  for (int i = 0; i < n; ++i) one(i, i) = 1;
  return one;
}

// Of s alone, mass 1; Hermitian, with its modes.
struct Scene {
  ComplexDense S = ComplexDense(n, n);
  ElasticModesOfIndex modes;
  Scene() {
    for (int i = 0; i < n; ++i)
      for (int j = 0; j <= i; ++j) {
        S(i, j) = {i == j ? 2.0 + i : 0.5 * scattered(i, j), i == j ? 0 : 0.5 * scattered(i, 10 + j)};
        S(j, i) = std::conj(S(i, j));
      }
    HermitianModes all = lowest_modes(ComplexDense(S), identity(), n);
    modes = {std::move(all.squares), std::move(all.shapes)};
  }
  ComplexDense shape(int j, double factor) const {
    ComplexDense v = modes.shapes.block(0, j, n, 1);
    for (auto &value : v.values) value *= factor;
    return v;
  }
};

} // namespace

// Moving contacts ask of the first mode, which is kept, and of the second; loads of the third.
TEST(LeftOutOfIndex, is_what_is_asked_of_other_modes_in_any_unit) {
  const Scene scene;
  for (const double unit : {1.0, 1e12, 1e-12}) {
    ElasticIndex elastic{{}, {}, scene.S, identity(), ComplexDense(n, 2), {scene.shape(2, unit), ComplexDense(n, 1)}};
    for (int i = 0; i < n; ++i)
      elastic.carried(i, 0) = unit * scene.modes.shapes(i, 0), elastic.carried(i, 1) = unit * scene.modes.shapes(i, 1);
    const LeftOutIndex found = left_out(elastic, {{scene.modes.squares[0]}, scene.shape(0, 1)}, 0, false);
    ASSERT_EQ(found.squares.size(), 2u) << unit;
    for (int j = 0; j < 2; ++j) EXPECT_NEAR(found.squares[j] / scene.modes.squares[1 + j], 1, 1e-12) << unit;
    EXPECT_NEAR(std::abs(found.coupling(1, 0)) / unit, 1, 1e-12);
    EXPECT_NEAR(std::abs(found.loads[0](1, 0)) / unit, 1, 1e-12);
    EXPECT_NEAR(std::abs(found.loads[0](0, 0)) / unit, 0, 1e-12);
    EXPECT_NEAR(std::abs(found.coupling(0, 0)) / unit, 0, 1e-12);
    EXPECT_EQ(std::abs(found.loads[1](0, 0)), 0); // a pattern without a load
  }
}
