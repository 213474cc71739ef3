// Guesses on the solution curve, and whether it runs smoothly between two points.
#include <gtest/gtest.h>

#include "problems/response_curve.hpp"
#include "small_model.hpp"

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
  CurvePoint on(const CurvePoint &here, double step) {
    CurvePoint s = curve.point();
    check(VecWAXPY(s.y, step, here.t, here.y), "");
    EXPECT_TRUE(curve.solve_across(here.t, s)) << s.newton.why;
    return s;
  }
};

double apart(const ArcLengthMetric &norm, Vec a, Vec b, const UniqueVec &work) {
  check(VecWAXPY(work, -1, a, b), "");
  return norm.length(work);
}

} // namespace

TEST(Curve, bent_guesses_miss_by_the_fourth_power_of_the_step) {
  Scene scene;
  const CurvePoint here = scene.at(0.4);
  const UniqueVec work = scene.system.unknowns(), guess = scene.system.unknowns();
  double straight[2], bent[2];
  for (int i = 0; i < 2; ++i) {
    const double step = i == 0 ? 0.02 : 0.01;
    const CurvePoint next = scene.on(here, step), after = scene.on(next, 1.3 * step);
    check(VecWAXPY(guess, 1.3 * step, next.t, next.y), "");
    straight[i] = apart(scene.curve.norm, guess, after.y, work);
    scene.curve.bend(here, next, 1.3 * step, guess);
    bent[i] = apart(scene.curve.norm, guess, after.y, work);
    EXPECT_NEAR(scene.curve.plane(next.t, guess), scene.curve.plane(next.t, after.y), 1e-9); // still on the plane
  }
  EXPECT_NEAR(straight[0] / straight[1], 4, 1);
  EXPECT_NEAR(bent[0] / bent[1], 16, 5);
  EXPECT_LT(bent[0], 0.1 * straight[0]);
}

TEST(Curve, tells_what_lies_between_the_ends_of_a_step) {
  Scene scene;
  const CurvePoint here = scene.at(0.4);
  double off[2];
  for (int i = 0; i < 2; ++i) {
    const CurvePoint next = scene.on(here, i == 0 ? 0.02 : 0.01);
    off[i] = scene.curve.off_middle(here, next);
  }
  EXPECT_LT(off[0], 1e-3);
  EXPECT_NEAR(off[0] / off[1], 8, 3);
  const CurvePoint beyond = scene.at(1.4); // on the other side of resonances
  EXPECT_GT(scene.curve.off_middle(here, beyond), 0.05);
}
