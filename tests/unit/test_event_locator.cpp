// Where within a step something happens, on curves in closed form.
#include <gtest/gtest.h>

#include "continuation/event_locator.hpp"
#include "small_problems.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr double tolerance = 1e-11;

double rate(CurvePoint &s) { return parameter_of(s.t); }

void put(Vec v, double x, double p) {
  check(VecSetValue(v, 0, x, INSERT_VALUES), "");
  check(VecAssemblyBegin(v), ""), check(VecAssemblyEnd(v), "");
  set_parameter(v, p);
}

} // namespace

TEST(EventLocator, finds_the_fold_of_a_circle) {
  SmallCurve scene(circle(), 1);
  const CurvePoint here = scene.at(0.3, std::sqrt(1 - 0.09)), there = scene.on(here, 0.5);
  const EventLocator locator(scene.curve, here, there, tolerance);
  const double from = parameter_of(here.t), to = parameter_of(there.t);
  ASSERT_LT(from * to, 0);
  const auto found = locator.between(here.t, {0, here.y, from}, {0.5, there.y, to}, rate);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->at.parameter, 1, 1e-12);
  EXPECT_NEAR(values(found->at.y)[0], 0, 1e-7);
  EXPECT_GT(found->along, 0);
  EXPECT_LT(found->along, 0.5);
}

// The legs p = -3 |x| meet in a fold: planes across either leg may miss the other.
TEST(EventLocator, finds_a_fold_in_a_kink) {
  SmallCurve scene(hairpin(3), 1);
  const CurvePoint here = scene.at(-0.1, -0.3);
  CurvePoint there = scene.at(0.05, -0.15);
  turn(there); // the curve comes back
  const EventLocator locator(scene.curve, here, there, tolerance);
  for (const double step : {1.0, 0.3}) {
    const auto found = locator.in_kink(step, {parameter_of(here.t), parameter_of(there.t)}, rate);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->at.parameter, 0, 1e-7);
    EXPECT_NEAR(found->along, step * 0.1 / 0.15, 1e-7); // that part of the step
  }
}

// The legs meet at (0, 0.3); on the plane across them there is only the line x = 3.
TEST(EventLocator, finds_nothing_of_another_branch_in_a_kink) {
  SmallCurve scene(one([](double x, double) { return x - 3; }, [](double, double) { return 1.0; },
                       [](double, double) { return 0.0; }),
                   1);
  CurvePoint here = scene.curve.point(), other = scene.curve.point();
  put(here.t, 0, 1), put(other.y, 0.4, 0.3), put(other.t, 1, 0);
  const EventLocator locator(scene.curve, here, other, tolerance);
  EXPECT_FALSE(locator.in_kink(1, {1, -1}, [](CurvePoint &) { return 0.5; }));
}

TEST(EventLocator, tells_a_crossing_branch_from_a_hairpin) {
  SmallCurve crossing(pitchfork(), 2);
  const CurvePoint here = crossing.at(0, -0.07), there = crossing.on(here, 0.1);
  const EventLocator at_branch(crossing.curve, here, there, tolerance);
  EXPECT_TRUE(at_branch.leads_back(0.1, 1e-3));
  const auto found = at_branch.branch_point(0.1);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->at.parameter, 0, 1e-5);

  SmallCurve folded(hairpin(30), 30);
  const CurvePoint leg = folded.at(-0.1, -3), other = folded.at(0.09, -2.7);
  EXPECT_FALSE(EventLocator(folded.curve, leg, other, tolerance).leads_back(0.1, 1e-3));
}

// Other branches cross where one would look first.
TEST(EventLocator, finds_the_crossing_that_no_point_between_hides) {
  const std::vector<double> crossings{0, -0.5 + 0.3, 0.4};
  const auto product = [crossings](double x, double p, double of_each) {
    double value = 1;
    for (const double at : crossings) value *= p - at - of_each * x * x;
    return value;
  };
  SmallCurve scene(one([=](double x, double p) { return x * product(x, p, 1); },
                       [=](double, double p) { return product(0, p, 1); }, [](double, double) { return 0.0; }),
                   1);
  const CurvePoint here = scene.at(0, -0.5), there = scene.on(here, 1);
  const auto found = EventLocator(scene.curve, here, there, tolerance).branch_point(1);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->at.parameter, 0.4, 1e-7);
  EXPECT_NEAR(found->along, 0.9, 1e-7);
}

TEST(Meeting, is_where_lines_along_tangents_are_closest) {
  SmallCurve scene(circle(), 1);
  CurvePoint here = scene.curve.point(), other = scene.curve.point();
  const auto met = [&](double turned, double ahead, double back) { // at (0, ahead)
    put(here.y, 0, 0), put(here.t, 0, 1);
    put(other.t, std::sin(turned), std::cos(turned));
    put(other.y, back * std::sin(turned), ahead + back * std::cos(turned));
    return meeting(scene.curve, here, other);
  };
  for (const double ahead : {0.25, 3.0})
    for (const double back : {0.5, -2.0}) {
      const Meeting at = met(1.1, ahead, back);
      EXPECT_NEAR(at.ahead, ahead, 1e-12);
      EXPECT_NEAR(at.back, back, 1e-12);
      EXPECT_NEAR(at.miss, 0, 1e-12);
    }
  for (const auto &[turned, ahead] : {std::pair{1.1, -0.5}, {0.02, 0.5}}) { // behind here, or too slim an angle
    const Meeting at = met(turned, ahead, 2);
    EXPECT_EQ(at.ahead, 0);
    EXPECT_NEAR(at.back, 2 + ahead * std::cos(turned), 1e-12);
    EXPECT_NEAR(at.miss, std::abs(ahead * std::sin(turned)), 1e-12); // from here to the other line
  }
}
