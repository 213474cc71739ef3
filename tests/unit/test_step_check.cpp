// Why steps are refused, each check by itself, on curves in closed form.
#include <gtest/gtest.h>

#include <tuple>
#include <utility>

#include "continuation/step_check.hpp"
#include "small_problems.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

Trial trial_between(SmallCurve &scene, const CurvePoint &from, const CurvePoint &to, double step, StepMeasure measure,
                    bool kink = false) {
  return {scene.curve, from, to, step, measure, kink, EventLocator(scene.curve, from, to, 1e-11)};
}

const StepMeasure turned{1.1, std::tan(0.55)}, beside{0.1, 2}, smooth{0.1, 0.05};

} // namespace

TEST(AngleCheck, refuses_what_turns_too_far_unless_halvings_show_a_kink) {
  SmallCurve scene(circle(), 1);
  const CurvePoint here = scene.at(1, 0), there = scene.on(here, 0.1);
  Trial wide = trial_between(scene, here, there, 0.1, turned),
        known = trial_between(scene, here, there, 0.1, turned, true),
        narrow = trial_between(scene, here, there, 0.1, beside);
  EXPECT_EQ(check_angle(wide), "the curve turns too far within one step");
  EXPECT_FALSE(check_angle(known));
  EXPECT_FALSE(check_angle(narrow));
}

TEST(DistanceCheck, refuses_another_piece_of_the_curve) {
  SmallCurve scene(circle(), 1);
  const CurvePoint here = scene.at(1, 0), there = scene.on(here, 0.1);
  Trial far = trial_between(scene, here, there, 0.1, beside),
        known = trial_between(scene, here, there, 0.1, beside, true),
        near = trial_between(scene, here, there, 0.1, turned);
  EXPECT_EQ(check_distance(far), "the solution lies too far from the predicted one");
  EXPECT_FALSE(check_distance(known));
  EXPECT_FALSE(check_distance(near));
}

// x^2 = 1: two lines, which have the same tangents.
TEST(MiddleCheck, refuses_a_step_from_one_line_to_another) {
  SmallCurve scene(one([](double x, double) { return x * x - 1; }, [](double x, double) { return 2 * x; },
                       [](double, double) { return 0.0; }),
                   1);
  const CurvePoint here = scene.at(1, 0), along = scene.at(1, 0.1);
  Trial good = trial_between(scene, here, along, 0.1, smooth);
  EXPECT_FALSE(check_middle(good));
  const CurvePoint across = scene.at(-1, 0.1);
  Trial bad = trial_between(scene, here, across, 0.1, smooth),
        tiny = trial_between(scene, here, across, step_limits.close_to_kink, smooth);
  EXPECT_EQ(check_middle(bad), "the curve does not run smoothly from one end of the step to the other");
  EXPECT_FALSE(check_middle(tiny)); // so near a kink it may not
}

TEST(OrientationCheck, refuses_a_jump_across_a_hairpin) {
  SmallCurve scene(hairpin(30), 30);
  const CurvePoint here = scene.at(-0.1, -3), there = scene.at(0.09, -2.7);
  Trial across = trial_between(scene, here, there, 0.01, smooth),
        at_kink = trial_between(scene, here, there, 1e-5, turned, true);
  EXPECT_EQ(check_orientation(across), "the curve turns round within one step");
  EXPECT_FALSE(across.branch_point);
  EXPECT_FALSE(check_orientation(at_kink));
  const CurvePoint further = scene.at(-0.09, -2.7);
  Trial along = trial_between(scene, here, further, 0.01, smooth);
  EXPECT_FALSE(check_orientation(along));
}

TEST(OrientationCheck, finds_a_branch_that_crosses) {
  SmallCurve scene(pitchfork(), 2);
  const CurvePoint here = scene.at(0, -0.07), there = scene.on(here, 0.1);
  Trial trial = trial_between(scene, here, there, 0.1, {0, 0});
  EXPECT_FALSE(check_orientation(trial));
  ASSERT_TRUE(trial.branch_point);
  EXPECT_NEAR(trial.branch_point->at.parameter, 0, 1e-5);
}

// Two branches side by side, x = +-(1e-3 + h sin^2 25 pi p), whose determinants differ in sign: no third one crosses
// between them. With h they are straight at both ends of the step, and steep where it is looked into.
TEST(OrientationCheck, refuses_a_step_to_the_branch_beside) {
  for (const double h : {0.0, 6e-3}) {
    const auto side = [h](double p) { return 1e-3 + h * std::pow(std::sin(25 * M_PI * p), 2); };
    const auto slope = [h](double p) { return 25 * M_PI * h * std::sin(50 * M_PI * p); };
    SmallCurve scene(one([side](double x, double p) { return x * x - side(p) * side(p); },
                         [](double x, double) { return 2 * x; },
                         [side, slope](double, double p) { return -2 * side(p) * slope(p); }),
                     1);
    const CurvePoint here = scene.at(side(0), 0), beside = scene.at(-side(0.1), 0.1);
    Trial trial = trial_between(scene, here, beside, 0.1, {0, 0.29});
    EXPECT_TRUE(trial.locator.leads_back(0.1, 0.029)) << h;
    EXPECT_EQ(check_orientation(trial), "the step leads to another branch") << h;
    EXPECT_FALSE(trial.branch_point) << h;
  }
}

TEST(StepChecks, the_first_that_refuses_says_why) {
  SmallCurve scene(circle(), 1);
  const CurvePoint here = scene.at(1, 0), there = scene.on(here, 0.1);
  Trial both = trial_between(scene, here, there, 0.1, {1.1, 100}),
        none = trial_between(scene, here, there, 0.1, smooth);
  EXPECT_EQ(refused(both), "the curve turns too far within one step");
  EXPECT_FALSE(refused(none));
}

// Two lines x = d and x = -d: between points of both the cubic's middle lies between them, and one correction leads
// from there by the factors of x = d or -d to the line or beyond it: by d / 2.
TEST(MiddleCheck, refuses_what_the_curve_misses_by_more_than_a_twentieth_of_the_step) {
  for (const auto &[d, refuses] : {std::pair{0.0099, false}, {0.0101, true}}) {
    const double half = d;
    SmallCurve scene(one([half](double x, double) { return x * x - half * half; },
                         [](double x, double) { return 2 * x; }, [](double, double) { return 0.0; }),
                     1);
    const CurvePoint here = scene.at(half, 0), there = scene.at(-half, 0.1);
    for (const bool kink : {false, true}) {
      Trial trial = trial_between(scene, here, there, 0.1, smooth, kink);
      EXPECT_EQ(check_middle(trial).has_value(), refuses && !kink);
      EXPECT_NEAR(trial.off.length, kink ? 0 : d / 2, 1e-9);
      EXPECT_EQ(trial.middle != nullptr, !kink);
    }
  }
}

TEST(MiddleCheck, leaves_rough_problems_alone) {
  struct Rough : SmallProblem {
    using SmallProblem::SmallProblem;
    bool is_smooth() const override { return false; }
  } problem(one([](double x, double) { return x * x - 1; }, [](double x, double) { return 2 * x; },
                [](double, double) { return 0.0; }));
  SolveCounts counts;
  Curve curve(problem, {1e-11, 1e-12, 30}, 1, true, counts);
  CurvePoint here = curve.point(), there = curve.point();
  for (const auto &[s, x] : {std::pair{&here, 1.0}, {&there, -1.0}}) {
    check(VecSetValue(s->y, 0, x, INSERT_VALUES), "");
    check(VecAssemblyBegin(s->y), ""), check(VecAssemblyEnd(s->y), "");
    ASSERT_TRUE(curve.solve_at(x < 0 ? 0.1 : 0, *s));
  }
  Trial trial{curve, here, there, 0.1, smooth, false, EventLocator(curve, here, there, 1e-11)};
  EXPECT_FALSE(check_middle(trial));
}

TEST(OrientationCheck, asks_whether_signs_are_known_to_differ) {
  SmallCurve scene(hairpin(30), 30);
  CurvePoint here = scene.at(-0.1, -3), there = scene.at(0.09, -2.7);
  const auto refuses = [&](double step, bool kink) {
    Trial trial = trial_between(scene, here, there, step, turned, kink);
    return check_orientation(trial).has_value();
  };
  EXPECT_TRUE(refuses(1e-5, false));
  EXPECT_TRUE(refuses(1.01e-4, true));
  EXPECT_FALSE(refuses(1e-4, true)); // so near a kink
  for (CurvePoint *unknown : {&here, &there}) {
    const int sign = std::exchange(unknown->sign, 0);
    EXPECT_FALSE(refuses(1e-2, false));
    unknown->sign = sign;
  }
}

// The way back misses by 1e-3: a tenth of a correction of 0.11 steps, but not of 0.09.
TEST(OrientationCheck, looks_for_another_branch_where_the_way_leads_back_and_is_straight) {
  SmallCurve scene(one([](double x, double) { return x - 2; }, [](double, double) { return 1.0; },
                       [](double, double) { return 0.0; }),
                   1);
  CurvePoint here = scene.at(2, 0), there = scene.at(2, 0.1);
  here.sign = -1;
  check(VecSetValue(here.y, 0, 2.001, INSERT_VALUES), "");
  check(VecAssemblyBegin(here.y), ""), check(VecAssemblyEnd(here.y), "");
  for (const auto &[angle, correction, leads_back] :
       {std::tuple{0.1, 0.11, true}, {0.1, 0.09, false}, {0.5, 0.11, false}, {0.1, 0.5, false}}) {
    Trial trial = trial_between(scene, here, there, 0.1, {angle, correction});
    const auto why = check_orientation(trial);
    if (leads_back) {
      EXPECT_TRUE(!why || *why == "the step leads to another branch") << *why;
    } else {
      EXPECT_EQ(why, "the curve turns round within one step");
    }
  }
}
