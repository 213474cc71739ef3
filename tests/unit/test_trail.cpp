// Whether a curve comes upon an older piece of itself, or of what was left before.
#include <gtest/gtest.h>

#include "continuation/trail.hpp"
#include "harmonic/harmonic_system.hpp"
#include "small_model.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

// A straight line: everything at rest, Omega alone changes.
struct Line {
  HarmonicSystem system{scaled(small_preloaded(PETSC_COMM_WORLD), 0.05, {}), 2, 64, {0, 1e-3}};
  Trail trail{1};
  UniqueVec y = system.unknowns(), t = system.unknowns();

  Trail::Sense add(double omega, double sense) {
    const Layout &layout = system.layout();
    if (layout.owns_omega()) {
      check(VecSetValue(y, layout.omega_row(), omega, INSERT_VALUES), "");
      check(VecSetValue(t, layout.omega_row(), sense, INSERT_VALUES), "");
    }
    for (const Vec v : {Vec(y), Vec(t)}) {
      check(VecAssemblyBegin(v), "");
      check(VecAssemblyEnd(v), "");
    }
    return trail.add(layout, y, t, 1);
  }
};

} // namespace

TEST(Trail, curves_that_were_left_are_told_from_the_one_at_hand) {
  for (const bool left : {false, true}) {
    Line line;
    for (int i = 0; i < 20; ++i) EXPECT_EQ(line.add(0.01 * i, 1), Trail::Sense::fresh);
    left ? line.trail.leave() : line.trail.interrupt();
    for (int i = 0; i < 5; ++i) EXPECT_EQ(line.add(0.155 - 0.01 * i, -1), Trail::Sense::fresh);
    EXPECT_EQ(line.add(0.105, -1), Trail::Sense::opposite);
    EXPECT_EQ(line.trail.met_left(), left);
  }
}
