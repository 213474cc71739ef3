// Steps along curves in closed form, by the engine alone: nothing here knows of harmonics or contacts.
#include <gtest/gtest.h>

#include <cmath>

#include "small_problems.hpp"

using namespace dovetail;
using namespace dovetail::testing;

TEST(Stepper, a_circle_is_followed_all_round) {
  Walk walk(circle(), 1);
  walk.begin({1}, 0, 1);
  bool below = false; // until it comes up again on the side where it began
  ASSERT_TRUE(walk.go([&](const auto &y) {
    below = below || y[0] < 0;
    return !(below && y[0] > 0.1);
  }));
  ASSERT_EQ(walk.folds.size(), 2u);
  EXPECT_NEAR(walk.folds[0][1], 1, 1e-12);
  EXPECT_NEAR(walk.folds[1][1], -1, 1e-12);
  for (const auto &y : walk.points) EXPECT_NEAR(std::hypot(y[0], y[1]), 1, 1e-11);
  EXPECT_TRUE(walk.kinks.empty());
  EXPECT_LT(walk.points.size(), 400u);
}

// Of radius 1, as large as the range: its norm is the plain one.
TEST(Stepper, the_curve_between_points_is_drawn_by_cubics) {
  std::size_t before = 0;
  for (const double between : {1e-6, 1e-8, 1e-10}) { // the angle between tangents alone makes 1e-6
    Walk walk(circle(), 1, between);
    walk.begin({1}, 0, 1);
    ASSERT_TRUE(walk.go([](const auto &y) { return y[0] > -0.9; }));
    double worst = 0;
    for (std::size_t i = 1; i < walk.points.size(); ++i) {
      const auto &a = walk.points[i - 1], &b = walk.points[i], &t = walk.tangents[i - 1], &u = walk.tangents[i];
      const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
      const auto middle = [&](int k) { return (a[k] + b[k]) / 2 + length / 8 * (t[k] - u[k]); };
      worst = std::max(worst, std::abs(std::hypot(middle(0), middle(1)) - 1));
    }
    EXPECT_LT(worst, between);
    EXPECT_GT(worst, 0.25 * between); // a half is aimed at
    EXPECT_GT(walk.points.size(), before);
    before = walk.points.size();
  }
  EXPECT_LT(before, 500u);
}

TEST(Stepper, where_nothing_resonates_steps_are_as_long_as_a_straight_line_allows) {
  for (const bool resonates : {true, false}) {
    Walk walk(one([](double x, double p) { return x - 1 - p; }, [](double, double) { return 1.0; },
                  [](double, double) { return -1.0; }),
              1);
    walk.may_resonate = resonates;
    walk.begin({1}, 0, 1);
    ASSERT_TRUE(walk.go([](const auto &y) { return y[1] < 1; }));
    if (resonates)
      EXPECT_GT(walk.points.size(), 1 / smooth_aims.parameter);
    else
      EXPECT_LT(walk.points.size(), 0.8 / smooth_aims.parameter);
  }
}

// Two resonances, the second a thousandth as high and far narrower than a step: what it adds half a step away is less
// than the curve may be off by, but much of the motion there.
TEST(Stepper, a_low_resonance_behind_a_high_one_is_met) {
  constexpr double high = 0.2, width = 0.01, low = 1e-3, narrow = 1e-3;
  for (double at = 0.6; at < 0.9; at += 0.017) {
    const auto motion = [at](double p) {
      const double far = (p - high) / width, near = (p - at) / narrow;
      return 1 / (1 + far * far) + 2 * low * near / (1 + near * near);
    };
    const auto slope = [at](double p) {
      const double far = (p - high) / width, near = (p - at) / narrow, whole = 1 + near * near;
      return -2 * far / std::pow(1 + far * far, 2) / width + 2 * low * (1 - near * near) / (whole * whole) / narrow;
    };
    Walk walk(one([&](double x, double p) { return x - motion(p); }, [](double, double) { return 1.0; },
                  [&](double, double p) { return -slope(p); }),
              1);
    walk.begin({motion(0)}, 0, 1);
    ASSERT_TRUE(walk.go([](const auto &y) { return y[1] < 1; })) << at;
    double nearest = 1;
    for (const auto &y : walk.points) nearest = std::min(nearest, std::abs(y[1] - at));
    EXPECT_LT(nearest, narrow) << at;
  }
}

// The section of a cusp: x^3 - 3 a x + p has two turning points at x = sqrt(a), -sqrt(a).
TEST(Stepper, both_folds_of_a_cusp_are_passed) {
  for (const double a : {0.5, 0.01}) {
    Walk walk(one([a](double x, double p) { return x * x * x - 3 * a * x + p; },
                  [a](double x, double) { return 3 * x * x - 3 * a; }, [](double, double) { return 1.0; }),
              4);
    walk.begin({2}, -2, 1);
    ASSERT_TRUE(walk.go([](const auto &y) { return y[1] < 2; })) << a;
    ASSERT_EQ(walk.folds.size(), 2u) << a;
    EXPECT_NEAR(walk.folds[0][0], std::sqrt(a), 1e-6) << a;
    EXPECT_NEAR(walk.folds[0][1], 2 * std::pow(a, 1.5), 1e-11) << a;
    EXPECT_NEAR(walk.folds[1][1], -2 * std::pow(a, 1.5), 1e-11) << a;
    EXPECT_TRUE(walk.kinks.empty()) << a;
  }
}

TEST(Stepper, kinks_are_rounded_however_sharp) {
  for (const double slope : {0.8, 3.0, 30.0}) {
    Walk walk(hairpin(slope), slope);
    walk.begin({-1}, -slope, 1);
    ASSERT_TRUE(walk.go([](const auto &y) { return y[0] < 0.5; })) << slope;
    ASSERT_EQ(walk.kinks.size(), 1u) << slope;
    for (std::size_t i = 1; i < walk.points.size(); ++i) // never back
      EXPECT_GT(walk.points[i][0], walk.points[i - 1][0]) << slope;
  }
}

TEST(Stepper, a_branch_that_crosses_is_located_and_passed) {
  Walk walk(pitchfork(), 2);
  walk.begin({0}, -1, 1);
  ASSERT_TRUE(walk.go([](const auto &y) { return y[1] < 1; }));
  ASSERT_EQ(walk.branch_points.size(), 1u);
  EXPECT_NEAR(walk.branch_points[0][1], 0, 1e-6);
  for (const auto &y : walk.points) EXPECT_EQ(y[0], 0);
}

// u'' + p exp(u) = 0 with u = 0 at both ends: no solution beyond p = 3.513830719 (Bratu, Gelfand).
TEST(Stepper, the_fold_of_bratus_problem) {
  const auto fold = [](int n) {
    const double h2 = std::pow(1.0 / (n + 1), 2);
    Walk walk({n,
               [=](const double *y, double *f) {
                 for (int i = 0; i < n; ++i)
                   f[i] = (i > 0 ? y[i - 1] : 0) - 2 * y[i] + (i + 1 < n ? y[i + 1] : 0) + h2 * y[n] * std::exp(y[i]);
               },
               [=](const double *y, double *J) {
                 for (int i = 0; i < n; ++i) {
                   double *row = J + i * (n + 1);
                   row[i] = -2 + h2 * y[n] * std::exp(y[i]);
                   if (i > 0) row[i - 1] = 1;
                   if (i + 1 < n) row[i + 1] = 1;
                   row[n] = h2 * std::exp(y[i]);
                 }
               }},
              4);
    walk.begin(std::vector<double>(n, 0.0), 0.1, 1);
    EXPECT_TRUE(walk.go([&](const auto &y) { return y[n] > 0.05; }));
    EXPECT_EQ(walk.folds.size(), 1u);
    return walk.folds.empty() ? 0.0 : walk.folds[0][n];
  };
  const double coarse = fold(15), fine = fold(31);
  EXPECT_NEAR((4 * fine - coarse) / 3, 3.513830719, 2e-4); // the error goes with the square of the width
}

// Duffing's oscillator, one harmonic: q'' + c q' + q + q^3 = f cos w t. On the backbone w^2 = 1 + 3/4 A^2 the load is
// balanced by the damper alone: A = f / (c w).
TEST(Stepper, duffings_resonance_bends_over) {
  const double c = 0.05, f = 0.2;
  const auto stiffness = [](double a, double b, double w) { return 1 - w * w + 0.75 * (a * a + b * b); };
  Walk walk({2,
             [=](const double *y, double *out) {
               const double a = y[0], b = y[1], w = y[2], k = stiffness(a, b, w);
               out[0] = k * a + c * w * b - f, out[1] = k * b - c * w * a;
             },
             [=](const double *y, double *J) {
               const double a = y[0], b = y[1], w = y[2], k = stiffness(a, b, w);
               const double rows[] = {k + 1.5 * a * a,     1.5 * a * b + c * w, c * b - 2 * w * a,
                                      1.5 * a * b - c * w, k + 1.5 * b * b,     -c * a - 2 * w * b};
               std::copy(std::begin(rows), std::end(rows), J);
             }},
            2.5);
  walk.begin({0.3, 0}, 0.3, 1);
  ASSERT_TRUE(walk.go([](const auto &y) { return y[2] < 2.8; }));
  ASSERT_EQ(walk.folds.size(), 2u);
  double top = 0, at = 0;
  for (const auto &y : walk.points)
    if (const double A = std::hypot(y[0], y[1]); A > top) top = A, at = y[2];
  // closed form of the peak: A^2 (1 + 3/4 A^2) = (f / c)^2
  const double ratio = f / c, peak = std::sqrt((std::sqrt(1 + 3 * ratio * ratio) - 1) / 1.5);
  EXPECT_NEAR(top, peak, 0.01 * peak);
  EXPECT_NEAR(at, std::sqrt(1 + 0.75 * peak * peak), 0.02);
}

// Where no solution lies ahead nothing moves, and it says so.
TEST(Stepper, ends_where_the_curve_ends) {
  Walk walk(one([](double x, double p) { return p < 0 ? x : x + std::sqrt(p) * 1e9 + 1; },
                [](double, double) { return 1.0; },
                [](double, double p) { return p <= 0 ? 0.0 : 0.5e9 / std::sqrt(p); }),
            1);
  walk.begin({0}, -0.5, 1);
  EXPECT_FALSE(walk.go([](const auto &y) { return y[1] < 0.5; }));
  EXPECT_LT(walk.points.back()[1], 1e-6);
}

namespace {

constexpr double gap = 5e-3; // of x, at p = 0.3

struct Jumper : Walk {
  explicit Jumper(double longest)
      : Walk(one([](double x, double p) { return x - 1 - 0.1 * p - (p > 0.3 ? gap : 0); },
                 [](double, double) { return 1.0; }, [](double, double) { return -0.1; }),
             1),
        longest_jump(longest) {}
  bool takes_jump(double apart) override { return apart < longest_jump; }
  double longest_jump;
};

} // namespace

TEST(Stepper, a_jump_is_passed_where_the_curve_allows_it) {
  Jumper walk(2 * gap);
  walk.begin({1}, 0, 1);
  ASSERT_TRUE(walk.go([](const auto &y) { return y[1] < 1; }));
  EXPECT_LT(walk.points.size(), 60u);
  EXPECT_NEAR(walk.points.back()[0], 1 + 0.1 * walk.points.back()[1] + gap, 1e-11);
}

TEST(Stepper, a_longer_jump_is_none_of_the_curve) {
  Jumper walk(0.5 * gap);
  walk.begin({1}, 0, 1);
  ASSERT_FALSE(walk.go([](const auto &y) { return y[1] < 1; }));
  EXPECT_NEAR(walk.points.back()[1], 0.3, 1e-3);
}

namespace {

// Goes over to the line x1 = p, x2 = 2 p, which has one unknown more.
struct Changed : Walk {
  using Walk::Walk;
  void change() {
    take_curve(line.curve);
    ASSERT_TRUE(line.curve.solve_at(0.1, here_));
    measure_anew();
    limit_step();
    points = {values(here_.y)};
  }
  SmallCurve line{{2, [](const double *y, double *f) { f[0] = y[0] - y[2], f[1] = y[1] - 2 * y[2]; },
                   [](const double *, double *J) { J[0] = 1, J[2] = -1, J[4] = 1, J[5] = -2; }},
                  1};
};

} // namespace

TEST(Stepper, on_a_curve_taken_over_nothing_is_left_of_the_one_before) {
  Changed walk(circle(), 1);
  walk.begin({1}, 0, 1);
  ASSERT_TRUE(walk.go([](const auto &y) { return y[1] < 0.5; }));
  walk.change();
  ASSERT_TRUE(walk.go([](const auto &y) { return y[2] < 0.5; }));
  EXPECT_GT(walk.points.size(), 2u);
  for (const auto &y : walk.points) EXPECT_NEAR(y[1], 2 * y[0], 1e-11);
}
