// Where within a step something happens, on curves in closed form.
#include <gtest/gtest.h>

#include "continuation/event_locator.hpp"
#include "small_problems.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr double tolerance = 1e-11;

double rate(CurvePoint &s) { return parameter_of(s.t); }

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
  const auto found = locator.in_kink(1, {parameter_of(here.t), parameter_of(there.t)}, rate);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->at.parameter, 0, 1e-7);
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
