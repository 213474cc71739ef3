// Whether the solution curve runs smoothly between two points.
#include <gtest/gtest.h>

#include "problems/response_curve.hpp"
#include "small_model.hpp"
#include "small_problems.hpp"
#include "told_solves.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr NewtonSettings tight{1e-11, 1e-12, 30};

// Contacts that stick: a smooth curve.
struct Scene {
  HarmonicSystem system{scaled(small_preloaded(PETSC_COMM_WORLD), 0.05, {}), 3, 64, course({0, 1e-3})};
  SolveCounts counts;
  ResponseCurve curve{system, tight, 0.5, true, counts};

  CurvePoint at(double omega) {
    CurvePoint s = curve.point();
    EXPECT_TRUE(curve.solve_at(omega, s)) << s.newton.why;
    curve.norm.see(s.y);
    check(VecScale(s.t, 1 / curve.norm.length(s.t)), "");
    return s;
  }
  CurvePoint on(const CurvePoint &here, double step) { return across(curve, here, step); }
};

} // namespace

TEST(Curve, tells_what_lies_between_the_ends_of_a_step) {
  Scene scene;
  const CurvePoint here = scene.at(0.4);
  const UniqueVec middle = scene.curve.problem.unknowns();
  double off[2];
  for (int i = 0; i < 2; ++i) {
    const CurvePoint next = scene.on(here, i == 0 ? 0.02 : 0.01);
    off[i] = scene.curve.off_middle(here, next, middle).length / (i == 0 ? 0.02 : 0.01);
  }
  EXPECT_LT(off[0], 1e-3);
  EXPECT_NEAR(off[0] / off[1], 8, 3);
  const CurvePoint beyond = scene.at(1.4); // on the other side of resonances
  EXPECT_GT(scene.curve.off_middle(here, beyond, middle).length, 0.05);
}

namespace {

constexpr double unit = 0.5;

// A curve of a problem whose solver tells what it did.
struct ToldCurve {
  explicit ToldCurve(Equations equations, bool weighted = false)
      : problem(std::move(equations)), is_weighted(weighted) {}
  ToldProblem problem;
  bool is_weighted;
  SolveCounts counts;
  Curve curve{problem, {1e-10, 1e-10, 30}, unit, is_weighted, counts};

  CurvePoint at(double x, double p) {
    CurvePoint s = curve.point();
    s.y = problem.vector({x, p});
    EXPECT_TRUE(curve.solve_at(p, s)) << s.newton.why;
    return s;
  }
};

Equations upright(double x0) { // the line x = x0
  return one([x0](double x, double) { return x - x0; }, [](double, double) { return 1.0; },
             [](double, double) { return 0.0; });
}

} // namespace

// On a plane across p nothing moves but x, in one correction: 100 steps are allowed, or a hundredth of the unknowns.
TEST(Curve, gives_up_corrections_far_longer_than_the_step) {
  const auto found = [](double from, double way, double step) {
    ToldCurve scene(upright(from + way), true);
    const UniqueVec normal = scene.problem.vector({0, 2}), seen = scene.problem.vector({4, 0});
    scene.curve.norm.see(seen); // lengths of x count a quarter, those of p twice
    CurvePoint s = scene.curve.point();
    s.y = scene.problem.vector({from, 0});
    const bool converged = scene.curve.solve_across(normal, s, {.step = step});
    EXPECT_EQ(s.newton.why, converged ? "" : "Newton runs far away");
    EXPECT_NEAR(values(s.y)[0], converged ? from + way : from, 1e-12);
    return converged;
  };
  EXPECT_TRUE(found(3, 0.49, 0.01));
  EXPECT_FALSE(found(3, 0.51, 0.01));
  EXPECT_TRUE(found(-3, 0.029, 1e-6));
  EXPECT_FALSE(found(-3, 0.031, 1e-6));
  EXPECT_TRUE(found(3, 1e3, 0)); // any
}

TEST(Curve, a_point_has_a_tangent_of_length_1_whose_numbers_are_known) {
  ToldCurve scene(circle(), true);
  scene.curve.norm.see(scene.problem.vector({3, 0}));
  CurvePoint s = scene.at(0.7, 0.6);
  const auto y = values(s.y), t = values(s.t);
  EXPECT_NEAR(y[0], 0.8, 1e-10);
  EXPECT_EQ(y[1], 0.6);
  EXPECT_EQ(s.parameter, 0.6);
  EXPECT_EQ(s.sign, 1);
  EXPECT_NEAR(t[0] * t[0] / 9 + t[1] * t[1] / (unit * unit), 1, 1e-12);
  EXPECT_NEAR(t[0] / t[1], -0.75, 1e-10);
  EXPECT_GT(t[1], 0);
  CurvePoint other = across(scene.curve, s, 0.1);
  const auto next = values(other.y), along = values(other.t);
  EXPECT_EQ(other.parameter, next[1]);
  change_secretly(other.y, 1, 50), change_secretly(other.t, 1, 60);
  EXPECT_EQ(parameter_of(other.y), next[1]);
  EXPECT_NEAR(parameter_of(other.t), along[1], 1e-15);
  EXPECT_NEAR(plain_length(other.t), std::hypot(along[0], along[1]), 1e-14);
  other = scene.curve.point();
  EXPECT_EQ(values(other.y), (std::vector<double>{0, 0}));
  EXPECT_EQ(values(other.t), (std::vector<double>{0, 0}));
}

TEST(Curve, a_point_turned_is_the_same_the_other_way_round) {
  ToldCurve scene(circle());
  CurvePoint s = scene.at(0.8, 0.6);
  turn(s);
  EXPECT_EQ(s.sign, -1);
  EXPECT_NEAR(values(s.t)[0], 0.6, 1e-10);
  EXPECT_NEAR(values(s.t)[1], -0.8, 1e-10);
  EXPECT_EQ(angle_of(1 + 1e-15), 0);
  EXPECT_EQ(angle_of(-1 - 1e-15), M_PI);
  EXPECT_NEAR(angle_of(0), M_PI / 2, 1e-15);
  EXPECT_NEAR(angle(scene.curve.norm, scene.at(0.8, 0.6).t, scene.at(1, 0).t), std::asin(0.6), 1e-10);
}

TEST(Curve, counts_all_that_solves_took) {
  ToldCurve scene(circle());
  Told &told = scene.problem.told;
  long newton = 0;
  CurvePoint s = scene.at(0.7, 0.6);
  newton += s.newton.newton;
  CurvePoint other = across(scene.curve, s, 0.1);
  newton += other.newton.newton;
  const UniqueVec r = scene.problem.vector({1, 0}), c = scene.problem.unknowns();
  int sign;
  EXPECT_TRUE(scene.curve.correct(s, r, c));
  EXPECT_TRUE(scene.curve.tangent_at(s.y, s.t, c, sign));
  EXPECT_EQ(scene.counts.newton, newton);
  EXPECT_EQ(scene.counts.inexact, told.solves);
  EXPECT_EQ(scene.counts.linear, 3 * told.solves);
}

TEST(Curve, rounding_errors_are_those_behind_one_iteration) { // which leads from 0 to 1
  ToldCurve scene(one([](double x, double) { return x * x * x + x - 1; },
                      [](double x, double) { return 3 * x * x + 1; }, [](double, double) { return 0.0; }));
  const double last_bit = PETSC_MACHINE_EPSILON; // of 1 to greater numbers, half of it to smaller ones
  const double found = scene.curve.rounding(0.5);
  EXPECT_EQ(scene.problem.told.solves, 1);
  EXPECT_GE(found, 2 * last_bit - 1e-30);
  EXPECT_LE(found, 4 * last_bit + 1e-30);
}

// On the unit circle with plain lengths J = 2 y: what is missing by r is made up for along y, by r / 2.
TEST(Curve, corrects_by_factors_of_the_point_which_are_made_where_they_are_not_at_hand) {
  ToldCurve scene(circle());
  Told &told = scene.problem.told;
  const UniqueVec r = scene.problem.vector({0.1, 0}), c = scene.problem.unknowns();
  const auto factors = [&](const CurvePoint &s) {
    const int solves = told.solves, before = told.factorisations;
    EXPECT_TRUE(scene.curve.correct(s, r, c));
    EXPECT_EQ(told.solves, solves + 1);
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(values(c)[i], 0.05 * values(s.y)[i], 1e-9);
    return told.factorisations - before;
  };
  const CurvePoint one = scene.at(0.8, 0.6), other = scene.at(1, 0);
  EXPECT_NE(one.solve, other.solve);
  EXPECT_EQ(factors(other), 0);
  EXPECT_EQ(factors(one), 1);
  EXPECT_EQ(factors(one), 0);
  EXPECT_EQ(factors(other), 1);
  int sign;
  scene.curve.tangent_at(one.y, one.t, c, sign);
  EXPECT_EQ(factors(other), 1);
  CurvePoint failed = scene.curve.point();
  set_parameter(failed.y, 3);
  EXPECT_FALSE(scene.curve.solve_at(3, failed)); // beyond the circle
  EXPECT_EQ(factors(other), 1);
  scene.curve.recall(0);
  EXPECT_EQ(factors(other), 1);
  told.fail_at = 0, told.fail_until = 1000;
  EXPECT_FALSE(scene.curve.correct(one, r, c));
}

TEST(Curve, the_middle_of_a_step_is_corrected_once_by_the_factors_at_hand) {
  ToldCurve scene(circle());
  const CurvePoint a = scene.at(0.8, 0.6), b = across(scene.curve, a, 0.5);
  const UniqueVec middle = scene.problem.unknowns();
  const auto ya = values(a.y), yb = values(b.y), ta = values(a.t), tb = values(b.t);
  const double length = scene.curve.chord(a.y, b.y); // the norm of tangents of length 1 is the plain one here
  EXPECT_NEAR(length, std::hypot(yb[0] - ya[0], yb[1] - ya[1]), 1e-14);
  std::vector<double> cubic(2);
  for (int i = 0; i < 2; ++i) cubic[i] = (ya[i] + yb[i]) / 2 + length / 8 * (ta[i] - tb[i]);
  const double missed = cubic[0] * cubic[0] + cubic[1] * cubic[1] - 1;
  const auto expect = [&](double of_missed, const char *whose) { // along a's radius, across its tangent
    const Curve::Off off = scene.curve.off_middle(a, b, middle);
    EXPECT_NEAR(off.length, std::abs(of_missed * missed), 1e-9) << whose;
    EXPECT_NEAR(off.part, std::abs(of_missed * missed * ya[0] / values(middle)[0]), 1e-9) << whose;
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(values(middle)[i], cubic[i] - of_missed * missed * ya[i], 1e-9) << whose;
  };
  expect(0.5 / (ya[0] * yb[0] + ya[1] * yb[1]), "at b, where the last solve led across a's tangent");
  scene.at(1, 0);
  expect(0.5, "at a, made anew");
  expect(0.5, "at a, at hand");
  scene.problem.told.fail_at = 0, scene.problem.told.fail_until = 1000;
  scene.curve.recall(0);
  EXPECT_TRUE(std::isnan(scene.curve.off_middle(a, b, middle).length));
}

TEST(Curve, a_tangent_anywhere_looks_to_the_side_of_the_normal) {
  ToldCurve scene(circle());
  const UniqueVec t = scene.problem.unknowns();
  int sign;
  for (const double side : {1.0, -1.0}) {
    ASSERT_TRUE(scene.curve.tangent_at(scene.problem.vector({3, 4}), scene.problem.vector({0, side}), t, sign));
    EXPECT_EQ(sign, side);
    EXPECT_NEAR(values(t)[0], -0.8 * side, 1e-12);
    EXPECT_NEAR(values(t)[1], 0.6 * side, 1e-12);
  }
  EXPECT_FALSE(scene.curve.tangent_at(scene.problem.vector({0, 0}), scene.problem.vector({0, 1}), t, sign));
}

TEST(Curve, a_point_without_a_tangent_is_none) {
  ToldCurve scene(circle());
  Told &told = scene.problem.told;
  CurvePoint s = scene.curve.point();
  s.y = scene.problem.vector({0, 2}); // at the top, where x alone cannot change anything
  EXPECT_FALSE(scene.curve.solve_across(scene.problem.vector({0, 1}), s));
  CurvePoint other = scene.curve.point();
  other.y = scene.problem.vector({0.8, 0.6});
  told.fail_at = -1;
  EXPECT_TRUE(scene.curve.solve_at(0.6, other));
  EXPECT_TRUE(other.newton.converged);
}

TEST(Curve, a_point_whose_tangent_is_not_finite_is_none) {
  ToldCurve scene(circle());
  Told &told = scene.problem.told;
  scene.at(0.7, 0.6);
  told.spoil_at = 2 * told.solves; // the tangent comes last
  CurvePoint s = scene.curve.point();
  s.y = scene.problem.vector({0.7, 0.6});
  EXPECT_FALSE(scene.curve.solve_at(0.6, s, {}));
  EXPECT_FALSE(s.newton.converged);
  EXPECT_EQ(s.newton.why, "the bordered Jacobian is singular");
  EXPECT_EQ(told.solves, told.spoil_at);
  EXPECT_TRUE(scene.curve.solve_at(0.6, s, {}));
}

// x -> -x and back, unless a line search is made.
TEST(Curve, at_a_value_a_line_search_follows_where_newton_fails) {
  const auto f = [](double x, double) { return std::atan(x); };
  const auto slope = [](double x, double) { return 1 / (1 + x * x); };
  ToldCurve scene(one(f, slope, [](double, double) { return 0.0; }));
  CurvePoint s = scene.curve.point();
  s.y = scene.problem.vector({3, 0.2});
  EXPECT_FALSE(scene.curve.solve_at(0.3, s, {}));
  EXPECT_TRUE(scene.curve.solve_at(0.3, s));
  EXPECT_NEAR(values(s.y)[0], 0, 1e-10);
  EXPECT_EQ(values(s.y)[1], 0.3);
  s.y = scene.problem.vector({3, 0.2});
  EXPECT_FALSE(scene.curve.solve_at(0.3, s, {.line_search = true, .most = 1}));
  EXPECT_EQ(s.newton.why, "too many Newton iterations");
  EXPECT_FALSE(scene.curve.solve_at(0.3, s, {.exact = true}));
  EXPECT_EQ(s.newton.why, "linear solves leave more than was asked");
  EXPECT_FALSE(scene.curve.solve_at(0.3, s, {.steady = true}));
  EXPECT_EQ(s.newton.why, "Newton runs astray");
  const UniqueVec up = scene.problem.vector({0, 1});
  for (const auto &[effort, why] : {std::pair<StepEffort, const char *>{{.most = 1}, "too many Newton iterations"},
                                    {{.exact = true}, "linear solves leave more than was asked"},
                                    {{.steady = true}, "Newton runs astray"}}) {
    EXPECT_FALSE(scene.curve.solve_across(up, s, effort));
    EXPECT_EQ(s.newton.why, why);
  }
  EXPECT_TRUE(scene.curve.solve_across(up, s, {.line_search = true}));
}
