// Law cone: its likeness to law coulomb along an axis, isotropy, closed forms of circular slip, and the derivative in
// every contact state.
#include <gtest/gtest.h>

#include <random>

#include "contact/cone_law.hpp"
#include "contact/sampled_law.hpp"

using namespace dovetail;

namespace {

constexpr ContactPoint isotropic{Law::cone, 100, {40, 40}, {0.4, 0.4}, 0.1},
    orthotropic{Law::cone, 100, {40, 55}, {0.4, 0.4}, 0.1};

Standstill standstill(const ContactPoint &point, std::array<double, 3> x) {
  const StaticForce at_rest = static_force(point, x.data());
  return {x, at_rest.force, at_rest.w};
}

struct Answer {
  std::vector<double> G;
  Activity activity;
  Linearisation linear;
};

Answer evaluate(const ContactPoint &point, const Standstill &preload, const std::vector<double> &X, int samples,
                bool differentiate = true) {
  const int harmonics = static_cast<int>(X.size()) / 6;
  Answer answer{std::vector<double>(X.size(), 7.0), {}, {}};
  ConeLaw law(harmonics, samples);
  law.evaluate(point, preload, X.data(), answer.G.data(), answer.activity, differentiate ? &answer.linear : nullptr);
  return answer;
}

// d G / d X, (3n, 3n), from products.
std::vector<double> derivative(const Linearisation &linear, int width) {
  std::vector<double> full(width * width), unit(width), column(width);
  for (int col = 0; col < width; ++col) {
    unit[col] = 1;
    linear.multiply(isotropic, unit.data(), column.data());
    for (int row = 0; row < width; ++row) full[row * width + col] = column[row];
    unit[col] = 0;
  }
  return full;
}

// Largest relative deviation of the derivative from extrapolated central differences (steps h and h/2, error h^4).
double derivative_error(const ContactPoint &point, const Standstill &preload, std::vector<double> X, int samples) {
  const int width = static_cast<int>(X.size());
  const std::vector<double> dG = derivative(evaluate(point, preload, X, samples).linear, width);
  std::vector<double> slope(width);
  double worst = 0, scale = 0;
  for (int col = 0; col < width; ++col) {
    const double x = X[col];
    std::fill(slope.begin(), slope.end(), 0.0);
    for (const auto &[h, weight] : {std::pair{1e-4, -1.0 / 3}, {5e-5, 4.0 / 3}}) {
      X[col] = x + h;
      const std::vector<double> plus = evaluate(point, preload, X, samples, false).G;
      X[col] = x - h;
      const std::vector<double> minus = evaluate(point, preload, X, samples, false).G;
      for (int row = 0; row < width; ++row) slope[row] += weight * (plus[row] - minus[row]) / (2 * h);
    }
    X[col] = x;
    for (int row = 0; row < width; ++row) {
      worst = std::max(worst, std::abs(slope[row] - dG[row * width + col]));
      scale = std::max(scale, std::abs(slope[row]));
    }
  }
  return worst / scale;
}

// A circle of radius r under constant load.
std::vector<double> circle(double r) {
  std::vector<double> x(9, 0.0);
  x[1] = r, x[5] = r; // t1 = r cos, t2 = r sin
  return x;
}

} // namespace

TEST(ConeLaw, along_one_axis_equals_coulomb) { // slip, stick, lift-off
  for (const int axis : {0, 1})
    for (const double amplitude : {0.01, 0.3, 2.0}) {
      std::vector<double> x(21, 0.0), G(21);
      x[7 * axis + 1] = amplitude, x[7 * axis + 4] = 0.4 * amplitude, x[7 * axis + 5] = -0.1 * amplitude;
      x[15] = 0.3 * amplitude, x[16] = -0.2 * amplitude;
      ContactPoint coulomb = orthotropic;
      coulomb.law = Law::coulomb;
      const Standstill preload = standstill(orthotropic, {0, 0, 0.6});
      const Answer cone = evaluate(orthotropic, preload, x, 96);
      SampledLaw law(3, 96);
      Activity activity;
      Linearisation linear;
      const int which = 0;
      law.evaluate(&which, 1, &coulomb, &preload, x.data(), G.data(), &activity, &linear);
      for (int i = 0; i < 21; ++i) EXPECT_NEAR(cone.G[i], G[i], 1e-12);
      EXPECT_EQ(cone.activity.open, activity.open);
      EXPECT_EQ(cone.activity.slip, activity.slip);
      EXPECT_EQ(cone.activity.events, activity.events);
      EXPECT_NEAR(cone.activity.dissipation, activity.dissipation, 1e-12);
      std::vector<double> v(21), expected(21), product(21);
      for (int i = 0; i < 21; ++i) v[i] = i / 7 == axis || i / 7 == 2 ? 1.0 / (i + 1) : 0; // along the axis, and n
      linear.multiply(coulomb, v.data(), expected.data());
      cone.linear.multiply(orthotropic, v.data(), product.data());
      for (int i = 0; i < 21; ++i) EXPECT_NEAR(product[i], expected[i], 1e-11);
    }
}

TEST(ConeLaw, turning_the_motion_turns_the_force) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  std::vector<double> x(21), turned(21);
  for (double &value : x) value = 0.5 * normal(random);
  const double c = std::sqrt(0.5);
  const auto turn = [&](const std::vector<double> &from) {
    std::vector<double> to = from;
    for (int i = 0; i < 7; ++i) to[i] = c * (from[i] - from[7 + i]), to[7 + i] = c * (from[i] + from[7 + i]);
    return to;
  };
  const Standstill preload = standstill(isotropic, {0, 0, 0.4});
  const Answer answer = evaluate(isotropic, preload, x, 64);
  const std::vector<double> expected = turn(answer.G), G = evaluate(isotropic, preload, turn(x), 64).G;
  for (int i = 0; i < 21; ++i) EXPECT_NEAR(G[i], expected[i], 1e-12);
  EXPECT_GT(answer.activity.open, 0);
  EXPECT_GT(answer.activity.slip, 0);
}

TEST(ConeLaw, force_in_circular_slip_is_of_constant_size) {
  const double bound = 0.4 * 100 * 0.5;
  const Answer answer = evaluate(isotropic, standstill(isotropic, {0, 0, 0.6}), circle(3), 256);
  for (int d = 0; d < 2; ++d) EXPECT_NEAR(std::hypot(answer.G[3 * d + 1], answer.G[3 * d + 2]), bound, 1e-6);
  EXPECT_NEAR(answer.G[1], answer.G[5], 1e-6); // and turns with the motion: T1 = a cos + b sin, T2 = a sin - b cos
  EXPECT_NEAR(answer.G[2], -answer.G[4], 1e-6);
  EXPECT_EQ(answer.activity.slip, 1);
  EXPECT_EQ(answer.activity.events, 0);
}

TEST(ConeLaw, dissipation_in_circular_slip) {
  // The slider goes round with its force, at a right angle to its own radius: mu N / kt behind on a circle of radius
  // sqrt(r^2 - (mu N / kt)^2). Power is mu N times its speed.
  const double r = 3, bound = 0.4 * 100 * 0.5, lag = bound / 40;
  const double expected = 2 * M_PI * bound * std::sqrt(r * r - lag * lag);
  const auto error = [&](int samples) {
    return evaluate(isotropic, standstill(isotropic, {0, 0, 0.6}), circle(r), samples, false).activity.dissipation /
               expected -
           1;
  };
  EXPECT_LT(std::abs(error(8192)), 2e-4);
  EXPECT_NEAR(error(512) / error(1024), 2, 0.02); // the return along the radius is of first order in the step
}

TEST(ConeLaw, stays_linear_while_stuck_and_closed) {
  std::vector<double> x(15);
  for (int i = 0; i < 15; ++i) x[i] = 0.01 * (i % 4 - 1);
  const Answer answer = evaluate(orthotropic, standstill(orthotropic, {0.01, -0.02, 0.6}), x, 32);
  const std::vector<double> dG = derivative(answer.linear, 15);
  EXPECT_EQ(answer.activity.stick(), 1);
  EXPECT_EQ(answer.activity.events, 0);
  for (int row = 0; row < 15; ++row) {
    const double k = row < 5 ? 40 : row < 10 ? 55 : 100;
    EXPECT_NEAR(answer.G[row], k * x[row], 1e-13);
    for (int col = 0; col < 15; ++col) EXPECT_NEAR(dG[15 * row + col], row == col ? k : 0, 1e-12);
  }
}

TEST(ConeLaw, never_touching_gives_no_force) {
  const Answer answer = evaluate(isotropic, standstill(isotropic, {0, 0, -5}), std::vector<double>(15, 0.3), 32);
  EXPECT_EQ(answer.activity.open, 1);
  for (const double value : answer.G) EXPECT_EQ(value, 0);
  for (const double value : answer.linear.dense) EXPECT_EQ(value, 0);
}

TEST(ConeLaw, without_friction_there_is_a_normal_force_only) { // no division by nothing
  ContactPoint smooth = isotropic;
  smooth.mu = {0, 0};
  const Standstill preload = standstill(smooth, {0, 0, 0.6});
  for (const double amplitude : {0.0, 0.5, 2.0}) {
    std::vector<double> x(9, 0.0);
    x[1] = x[5] = x[7] = amplitude;
    const Answer answer = evaluate(smooth, preload, x, 32);
    for (int i = 0; i < 6; ++i) EXPECT_EQ(answer.G[i], 0);
    for (const double value : answer.G) EXPECT_TRUE(std::isfinite(value));
    for (const double value : answer.linear.dense) EXPECT_TRUE(std::isfinite(value));
  }
}

TEST(ConeLaw, derivative_in_slip) { // circular and to and fro, under varying load
  std::vector<double> x(21, 0.0);
  x[1] = 2, x[4] = 0.3, x[9] = 1.5, x[8] = 0.2, x[15] = 0.1, x[16] = -0.07;
  const Standstill preload = standstill(orthotropic, {0.05, 0, 0.6});
  EXPECT_EQ(evaluate(orthotropic, preload, x, 64).activity.open, 0);
  EXPECT_LT(derivative_error(orthotropic, preload, x, 64), 1e-8);
  x[9] = 0.05, x[8] = 0.7;
  const Activity activity = evaluate(orthotropic, preload, x, 64).activity;
  EXPECT_GT(activity.slip, 0.1);
  EXPECT_GT(activity.stick(), 0.1);
  EXPECT_LT(derivative_error(orthotropic, preload, x, 64), 1e-8);
}

TEST(ConeLaw, derivative_with_lift_off_and_landing) {
  std::vector<double> x(21, 0.0);
  x[1] = 0.2, x[4] = 0.03, x[8] = -0.5, x[9] = 0.2, x[15] = 0.9, x[16] = -0.37;
  EXPECT_GT(evaluate(orthotropic, standstill(orthotropic, {0.05, 0, 0.6}), x, 64).activity.open, 0.1);
  EXPECT_LT(derivative_error(orthotropic, standstill(orthotropic, {0.05, 0, 0.6}), x, 64), 1e-8);
}

TEST(ConeLaw, derivative_after_shakedown) { // slips in the first round, sticks all through the second
  std::vector<double> x(21, 0.0);
  x[0] = 1.9, x[1] = 0.3, x[9] = -0.15, x[16] = 0.02;
  const Standstill preload = standstill(isotropic, {0, 0, 0.6});
  const Answer answer = evaluate(isotropic, preload, x, 64);
  EXPECT_EQ(answer.activity.stick(), 1);
  EXPECT_GT(std::abs(derivative(answer.linear, 21)[0] - 40), 1.0);
  EXPECT_LT(derivative_error(isotropic, preload, x, 64), 1e-8);
}

TEST(ConeLaw, derivative_of_random_motions) { // every order of states; steps across a kink excluded by their rarity
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  int good = 0;
  for (int trial = 0; trial < 40; ++trial) {
    std::vector<double> x(21);
    for (double &value : x) value = 0.6 * normal(random);
    good += derivative_error(orthotropic, standstill(orthotropic, {0.1, -0.1, 0.4}), x, 48) < 1e-6;
  }
  EXPECT_GE(good, 37);
}

TEST(ConeLaw, blocks_are_in_the_order_of_their_places) {
  std::vector<double> x(21, 0.0), blocks(7 * 49);
  x[1] = 2, x[4] = 0.3, x[9] = 1.5, x[15] = 0.1;
  const Answer answer = evaluate(orthotropic, standstill(orthotropic, {0.05, 0, 0.6}), x, 64);
  const std::vector<double> dG = derivative(answer.linear, 21);
  answer.linear.write(orthotropic, blocks.data());
  const double *next = blocks.data();
  for (const BlockPlace place : block_places(Law::cone))
    for (int i = 0; i < 7; ++i)
      for (int j = 0; j < 7; ++j) EXPECT_EQ(*next++, dG[(7 * place.row + i) * 21 + 7 * place.column + j]);
}
