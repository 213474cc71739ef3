// Law cone: its likeness to law coulomb along an axis, isotropy, closed forms of circular slip, and the derivative in
// every contact state.
#include <gtest/gtest.h>

#include "one_point.hpp"

using namespace dovetail;

namespace {

constexpr ContactPoint isotropic{Law::cone, 100, {40, 40}, {0.4, 0.4}, 0.1},
    orthotropic{Law::cone, 100, {40, 55}, {0.4, 0.4}, 0.1};

// A circle of radius r under constant load.
std::vector<double> circle(double r) {
  std::vector<double> x(9, 0.0);
  x[1] = r, x[5] = r; // t1 = r cos, t2 = r sin
  return x;
}

} // namespace

TEST(ConeLaw, along_one_axis_equals_coulomb) { // slip, stick, lift-off
  ContactPoint coulomb = orthotropic;
  coulomb.law = Law::coulomb;
  const Standstill preload = standstill(orthotropic, {0, 0, 0.6});
  OnePoint cone(orthotropic, preload, 3, 96), expected(coulomb, preload, 3, 96);
  for (const int axis : {0, 1})
    for (const double amplitude : {0.01, 0.3, 2.0}) {
      std::vector<double> x(21, 0.0), v(21);
      x[7 * axis + 1] = amplitude, x[7 * axis + 4] = 0.4 * amplitude, x[7 * axis + 5] = -0.1 * amplitude;
      x[15] = 0.3 * amplitude, x[16] = -0.2 * amplitude;
      for (int i = 0; i < 21; ++i) v[i] = i / 7 == axis || i / 7 == 2 ? 1.0 / (i + 1) : 0; // along the axis, and n
      const std::vector<double> G = cone.force(x), G_coulomb = expected.force(x), product = cone.derivative_times(v),
                                product_coulomb = expected.derivative_times(v);
      for (int i = 0; i < 21; ++i) EXPECT_NEAR(G[i], G_coulomb[i], 1e-12);
      for (int i = 0; i < 21; ++i) EXPECT_NEAR(product[i], product_coulomb[i], 1e-11);
      EXPECT_EQ(cone.activity().open, expected.activity().open);
      EXPECT_EQ(cone.activity().slip, expected.activity().slip);
      EXPECT_EQ(cone.activity().events, expected.activity().events);
      EXPECT_NEAR(cone.activity().dissipation, expected.activity().dissipation, 1e-12);
    }
}

TEST(ConeLaw, turning_the_motion_turns_the_force) {
  std::mt19937 random(2);
  const std::vector<double> x = random_motion(random, 3, 0.5);
  const double c = std::sqrt(0.5);
  const auto turn = [&](const std::vector<double> &from) {
    std::vector<double> to = from;
    for (int i = 0; i < 7; ++i) to[i] = c * (from[i] - from[7 + i]), to[7 + i] = c * (from[i] + from[7 + i]);
    return to;
  };
  OnePoint law(isotropic, standstill(isotropic, {0, 0, 0.4}), 3, 64);
  const std::vector<double> expected = turn(law.force(x)), G = law.force(turn(x));
  for (int i = 0; i < 21; ++i) EXPECT_NEAR(G[i], expected[i], 1e-12);
  EXPECT_GT(law.activity().open, 0);
  EXPECT_GT(law.activity().slip, 0);
}

TEST(ConeLaw, force_in_circular_slip_is_of_constant_size) {
  const double bound = 0.4 * 100 * 0.5;
  OnePoint law(isotropic, standstill(isotropic, {0, 0, 0.6}), 1, 256);
  const std::vector<double> G = law.force(circle(3));
  for (int d = 0; d < 2; ++d) EXPECT_NEAR(std::hypot(G[3 * d + 1], G[3 * d + 2]), bound, 1e-6);
  EXPECT_NEAR(G[1], G[5], 1e-6); // and turns with the motion: T1 = a cos + b sin, T2 = a sin - b cos
  EXPECT_NEAR(G[2], -G[4], 1e-6);
  EXPECT_EQ(law.activity().slip, 1);
  EXPECT_EQ(law.activity().events, 0);
}

TEST(ConeLaw, dissipation_in_circular_slip) {
  // The slider goes round with its force, at a right angle to its own radius: mu N / kt behind on a circle of radius
  // sqrt(r^2 - (mu N / kt)^2). Power is mu N times its speed.
  const double r = 3, bound = 0.4 * 100 * 0.5, lag = bound / 40;
  const double expected = 2 * M_PI * bound * std::sqrt(r * r - lag * lag);
  const auto error = [&](int samples) {
    return OnePoint(isotropic, standstill(isotropic, {0, 0, 0.6}), 1, samples).activity(circle(r)).dissipation /
               expected -
           1;
  };
  EXPECT_LT(std::abs(error(1024)), 1e-5);
  EXPECT_NEAR(error(128) / error(256), 4, 0.05); // a motion taken to be linear between samples is of second order
}

TEST(ConeLaw, stays_linear_while_stuck_and_closed) {
  OnePoint law(orthotropic, standstill(orthotropic, {0.01, -0.02, 0.6}), 2, 32);
  std::vector<double> x(15);
  for (int i = 0; i < 15; ++i) x[i] = 0.01 * (i % 4 - 1);
  const std::vector<double> G = law.force(x), dG = law.derivative();
  EXPECT_EQ(law.activity().stick(), 1);
  EXPECT_EQ(law.activity().events, 0);
  for (int row = 0; row < 15; ++row) {
    const double k = row < 5 ? 40 : row < 10 ? 55 : 100;
    EXPECT_NEAR(G[row], k * x[row], 1e-13);
    for (int col = 0; col < 15; ++col) EXPECT_NEAR(dG[15 * row + col], row == col ? k : 0, 1e-12);
  }
}

TEST(ConeLaw, never_touching_gives_no_force) {
  OnePoint law(isotropic, standstill(isotropic, {0, 0, -5}), 2, 32);
  for (const double value : law.force(std::vector<double>(15, 0.3))) EXPECT_EQ(value, 0);
  EXPECT_EQ(law.activity().open, 1);
  for (const double value : law.derivative()) EXPECT_EQ(value, 0);
}

TEST(ConeLaw, without_friction_there_is_a_normal_force_only) { // no division by nothing
  ContactPoint smooth = isotropic;
  smooth.mu = {0, 0};
  OnePoint law(smooth, standstill(smooth, {0, 0, 0.6}), 1, 32);
  for (const double amplitude : {0.0, 0.5, 2.0}) {
    std::vector<double> x(9, 0.0);
    x[1] = x[5] = x[7] = amplitude;
    const std::vector<double> G = law.force(x);
    for (int i = 0; i < 6; ++i) EXPECT_EQ(G[i], 0);
    for (const double value : G) EXPECT_TRUE(std::isfinite(value));
    for (const double value : law.derivative()) EXPECT_TRUE(std::isfinite(value));
  }
}

TEST(ConeLaw, derivative_in_slip) { // circular and to and fro, under varying load
  std::vector<double> x(21, 0.0);
  x[1] = 2, x[4] = 0.3, x[9] = 1.5, x[8] = 0.2, x[15] = 0.1, x[16] = -0.07;
  OnePoint law(orthotropic, standstill(orthotropic, {0.05, 0, 0.6}), 3, 64);
  EXPECT_EQ(law.activity(x).open, 0);
  EXPECT_LT(law.derivative_error(x, 1e-4), 1e-8);
  x[9] = 0.05, x[8] = 0.7;
  EXPECT_GT(law.activity(x).slip, 0.1);
  EXPECT_GT(law.activity().stick(), 0.1);
  EXPECT_LT(law.derivative_error(x, 1e-4), 1e-8);
}

TEST(ConeLaw, derivative_with_lift_off_and_landing) {
  std::vector<double> x(21, 0.0);
  x[1] = 0.2, x[4] = 0.03, x[8] = -0.5, x[9] = 0.2, x[15] = 0.9, x[16] = -0.37;
  OnePoint law(orthotropic, standstill(orthotropic, {0.05, 0, 0.6}), 3, 64);
  EXPECT_GT(law.activity(x).open, 0.1);
  EXPECT_LT(law.derivative_error(x, 1e-4), 1e-8);
}

TEST(ConeLaw, derivative_after_shakedown) { // slips in the first round, sticks all through the second
  std::vector<double> x(21, 0.0);
  x[0] = 1.9, x[1] = 0.3, x[9] = -0.15, x[16] = 0.02;
  OnePoint law(isotropic, standstill(isotropic, {0, 0, 0.6}), 3, 64);
  EXPECT_EQ(law.activity(x).stick(), 1);
  EXPECT_GT(std::abs(law.derivative(x)[0] - 40), 1.0);
  EXPECT_LT(law.derivative_error(x, 1e-4), 1e-8);
}

TEST(ConeLaw, derivative_of_random_motions) { // every order of states; steps across a kink excluded by their rarity
  std::mt19937 random(7);
  OnePoint law(orthotropic, standstill(orthotropic, {0.1, -0.1, 0.4}), 3, 48);
  int good = 0;
  for (int trial = 0; trial < 40; ++trial)
    good += law.derivative_error(random_motion(random, 3, 0.6), {1e-4, 1e-5}, 1) < 1e-8;
  EXPECT_GE(good, 39);
}

TEST(ConeLaw, products_with_the_derivative_agree_with_its_blocks) {
  std::mt19937 random(3);
  OnePoint law(orthotropic, standstill(orthotropic, {0.05, 0, 0.6}), 3, 64);
  for (int trial = 0; trial < 10; ++trial) {
    const std::vector<double> x = random_motion(random, 3, trial % 2 ? 0.6 : 0.1);
    EXPECT_LT(law.product_error(x, random_motion(random, 3, 1)), 1e-13);
  }
}

// Slip in a circle a little wider than the slip limit: the slider creeps up to its loop for many rounds, and has
// forgotten where it began only then.
TEST(ConeLaw, marches_on_until_the_memory_closes_its_loop) {
  const double limit = 0.4 * 0.5 * 100 / 40;
  Standstill here = standstill(isotropic, {0, 0, 0.6}), elsewhere = here;
  elsewhere.w = {0.3 * limit, -0.2 * limit};
  OnePoint law(isotropic, here, 1, 64), moved(isotropic, elsewhere, 1, 64);
  for (const double wider : {1.01, 1.1, 2.0}) {
    const std::vector<double> G = law.force(circle(wider * limit)), other = moved.force(circle(wider * limit));
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(other[i], G[i], 1e-7);
  }
}
