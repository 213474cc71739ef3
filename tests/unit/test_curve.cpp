// Whether the solution curve runs smoothly between two points.
#include <gtest/gtest.h>

#include "problems/response_curve.hpp"
#include "small_model.hpp"
#include "small_problems.hpp"

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
  const auto length = [&](const CurvePoint &a, const CurvePoint &b) {
    const UniqueVec way = scene.curve.problem.unknowns();
    check(VecWAXPY(way, -1, a.y, b.y), "measuring");
    return scene.curve.norm.length(way);
  };
  double off[2];
  for (int i = 0; i < 2; ++i) {
    const CurvePoint next = scene.on(here, i == 0 ? 0.02 : 0.01);
    off[i] = scene.curve.off_middle(here, next, length(here, next), middle) / (i == 0 ? 0.02 : 0.01);
  }
  EXPECT_LT(off[0], 1e-3);
  EXPECT_NEAR(off[0] / off[1], 8, 3);
  const CurvePoint beyond = scene.at(1.4); // on the other side of resonances
  EXPECT_GT(scene.curve.off_middle(here, beyond, length(here, beyond), middle), 0.05);
}
