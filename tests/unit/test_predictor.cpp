// Guesses of the next point on a circle, in closed form.
#include <gtest/gtest.h>

#include <random>

#include "continuation/predictor.hpp"
#include "told_solves.hpp"

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

// Any two points with any tangents, in weighted lengths: Hermite's cubic, prolonged, and brought back onto the plane.
TEST(Predictor, the_cubic_is_hermites) {
  constexpr int n = 4;
  std::mt19937 random(2);
  std::normal_distribution<double> some;
  SmallProblem problem({n - 1, nullptr, nullptr});
  const auto norm = problem.metric(0.7, true);
  const auto fill = [&](Vec v) {
    for (int i = 0; i < n; ++i) check(VecSetValue(v, i, some(random), INSERT_VALUES), "");
    check(VecAssemblyBegin(v), ""), check(VecAssemblyEnd(v), "");
  };
  for (int round = 0; round < 20; ++round) {
    CurvePoint before, here;
    for (CurvePoint *s : {&before, &here}) {
      s->y = problem.unknowns(), s->t = problem.unknowns();
      fill(s->y), fill(s->t);
      norm->see(s->y);
      s->parameter = values(s->y).back();
    }
    check(VecScale(here.t, 1 / norm->length(here.t)), ""); // that before need not be of length 1 any more
    const UniqueVec way = problem.unknowns(), straight = problem.unknowns(), bent = problem.unknowns();
    check(VecWAXPY(way, -1, before.y, here.y), "");
    const double step = 0.1 + std::abs(some(random)), last = norm->length(way), of_before = norm->length(before.t);
    const auto a = values(before.y), b = values(here.y), ta = values(before.t), tb = values(here.t);
    TangentPredictor().predict(here, step, straight);
    CubicPredictor(*norm, before).predict(here, step, bent);
    const auto plain = values(straight), cubic = values(bent);
    UniqueVec off = problem.unknowns();
    double *at;
    check(VecGetArray(off, &at), "");
    for (int i = 0; i < n; ++i) {
      EXPECT_NEAR(plain[i], b[i] + step * tb[i], 1e-13);
      const double s = 1 + step / last, m0 = last * ta[i] / of_before,
                   m1 = last * tb[i]; // from 0 to 1 between the points
      at[i] = a[i] * (1 + 2 * s) * (1 - s) * (1 - s) + m0 * s * (1 - s) * (1 - s) + b[i] * s * s * (3 - 2 * s) +
              m1 * s * s * (s - 1) - plain[i];
    }
    check(VecRestoreArray(off, &at), "");
    check(VecAXPY(off, -norm->product(off, here.t), here.t), "");
    const auto more = values(off);
    for (int i = 0; i < n; ++i) EXPECT_NEAR(cubic[i], plain[i] + more[i], 1e-12 * (1 + std::abs(cubic[i]))) << round;
    change_secretly(straight, n - 1, 50), change_secretly(bent, n - 1, 60);
    EXPECT_NEAR(parameter_of(straight), plain.back(), 1e-13); // as they are known without a look
    EXPECT_NEAR(parameter_of(bent), cubic.back(), 1e-12 * (1 + std::abs(cubic.back())));
  }
}
