// Guesses of the next point on a circle, in closed form.
#include <gtest/gtest.h>

#include "continuation/predictor.hpp"
#include "small_problems.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

// How far the guess is from the curve on its plane, with what it says of the plane.
struct Missed {
  double miss, off_plane;
};

Missed missed(SmallCurve &scene, const Predictor &predictor, const CurvePoint &here, double step) {
  const CurvePoint there = scene.on(here, step);
  const UniqueVec guess = scene.problem.unknowns(), way = scene.problem.unknowns();
  predictor.predict(here, step, guess);
  check(VecWAXPY(way, -1, guess, there.y), "");
  return {scene.curve.norm.length(way), scene.curve.norm.product(way, here.t)};
}

} // namespace

TEST(Predictor, along_the_tangent_misses_by_the_square_of_the_step) {
  SmallCurve scene(circle(), 1);
  const CurvePoint here = scene.at(1, 0);
  for (const double step : {0.1, 0.01}) {
    const Missed found = missed(scene, TangentPredictor(), here, step);
    EXPECT_NEAR(found.miss, 1 - std::sqrt(1 - step * step), 1e-12);
    EXPECT_NEAR(found.off_plane, 0, 1e-12);
  }
}

TEST(Predictor, the_cubic_through_two_points_misses_by_the_fourth_power) {
  SmallCurve scene(circle(), 1);
  const CurvePoint before = scene.at(std::cos(0.3), -std::sin(0.3));
  double miss[2];
  for (int i = 0; i < 2; ++i) {
    const double step = i == 0 ? 0.08 : 0.04;
    const CurvePoint here = scene.on(before, step);
    const Missed found = missed(scene, CubicPredictor(scene.curve.norm, before), here, 1.3 * step);
    miss[i] = found.miss;
    EXPECT_NEAR(found.off_plane, 0, 1e-12);
    EXPECT_LT(found.miss, 0.1 * missed(scene, TangentPredictor(), here, 1.3 * step).miss);
  }
  EXPECT_NEAR(miss[0] / miss[1], 16, 4);
}

// A step of no length tells nothing of the curve's bend.
TEST(Predictor, without_a_step_before_the_cubic_is_the_tangent) {
  SmallCurve scene(circle(), 1);
  const CurvePoint here = scene.at(0.8, 0.6);
  const UniqueVec straight = scene.problem.unknowns(), bent = scene.problem.unknowns();
  TangentPredictor().predict(here, 0.1, straight);
  CubicPredictor(scene.curve.norm, here).predict(here, 0.1, bent);
  EXPECT_EQ(values(straight), values(bent));
}
