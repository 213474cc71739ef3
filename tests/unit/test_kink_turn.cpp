// Round the kink of a hairpin: p = -slope |x|.
#include <gtest/gtest.h>

#include "continuation/kink_turn.hpp"
#include "small_problems.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr double slope = 3;

struct Hairpin : SmallCurve {
  Hairpin() : SmallCurve(hairpin(slope), 1) {}
  CurvePoint here = at(-1e-4, -slope * 1e-4), trial = curve.point();
};

} // namespace

TEST(KinkTurn, leads_to_the_other_leg) {
  Hairpin scene;
  double turned = 0;
  bool at_kink = false;
  KinkTurn turn(scene.curve, scene.here, scene.trial, 0, false, [&](const KinkTurn::Leg &leg) {
    turned = leg.turned, at_kink = leg.at_kink;
    EXPECT_GT(leg.way, 0);
    return true;
  });
  ASSERT_TRUE(turn.turn(1e-3));
  EXPECT_TRUE(at_kink);
  EXPECT_GT(values(scene.trial.y)[0], 0);
  EXPECT_LT(parameter_of(scene.trial.t), 0); // back to smaller values
  EXPECT_EQ(scene.trial.sign, scene.here.sign);
  EXPECT_NEAR(turned, angle(scene.curve.norm, scene.here.t, scene.trial.t), 1e-12);
}

TEST(KinkTurn, of_legs_that_are_refused_it_tries_others_and_gives_up) {
  Hairpin scene;
  int offered = 0;
  KinkTurn turn(scene.curve, scene.here, scene.trial, 0, false, [&](const KinkTurn::Leg &) {
    ++offered;
    return false;
  });
  EXPECT_FALSE(turn.turn(1e-3));
  EXPECT_GT(offered, 1);
}

TEST(KinkTurn, a_smooth_curve_has_no_other_leg) {
  SmallCurve scene(circle(), 1);
  const CurvePoint here = scene.at(1, 0);
  CurvePoint trial = scene.curve.point();
  KinkTurn turn(scene.curve, here, trial, 1, false, [](const KinkTurn::Leg &) { return true; });
  EXPECT_FALSE(turn.turn(1e-3));
}
