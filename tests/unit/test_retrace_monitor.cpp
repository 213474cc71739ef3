// Whether a curve comes upon an older piece of itself, or of what was left before.
#include <gtest/gtest.h>

#include "continuation/retrace_monitor.hpp"
#include "problems/forced_response.hpp"
#include "small_model.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

// A straight line: everything at rest, Omega alone changes.
struct Line {
  HarmonicSystem system{scaled(small_preloaded(PETSC_COMM_WORLD), 0.05, {}), 2, 64, course({0, 1e-3})};
  ForcedResponse problem{system};
  RetraceMonitor trail{1};
  UniqueVec y = system.unknowns(), t = system.unknowns();

  RetraceMonitor::Sense add(double omega, double sense, double motion = 0) { // of every unknown
    check(VecSet(y, motion), "");
    set_parameter(y, omega), set_parameter(t, sense);
    return trail.add(problem, y, t, 1);
  }
};

} // namespace

TEST(RetraceMonitor, curves_that_were_left_are_told_from_the_one_at_hand) {
  for (const bool left : {false, true}) {
    Line line;
    for (int i = 0; i < 20; ++i) EXPECT_EQ(line.add(0.01 * i, 1), RetraceMonitor::Sense::fresh);
    if (left) line.trail.leave();
    for (int i = 0; i < 5; ++i) EXPECT_EQ(line.add(0.155 - 0.01 * i, -1), RetraceMonitor::Sense::fresh);
    EXPECT_EQ(line.add(0.105, -1), RetraceMonitor::Sense::opposite);
    EXPECT_EQ(line.trail.met_left(), left);
  }
}

TEST(RetraceMonitor, a_way_that_is_run_again_has_the_same_sense) {
  Line line;
  for (int i = 0; i < 20; ++i) EXPECT_EQ(line.add(0.01 * i, 1), RetraceMonitor::Sense::fresh);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(line.add(0.055 + 0.01 * i, 1), RetraceMonitor::Sense::fresh);
  EXPECT_EQ(line.add(0.105, 1), RetraceMonitor::Sense::same);
}

TEST(RetraceMonitor, points_beside_an_older_piece_are_fresh) {
  Line line;
  for (int i = 0; i < 20; ++i) line.add(0.01 * i, 1);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(line.add(0.155 - 0.01 * i, -1, 1e-3), RetraceMonitor::Sense::fresh);
}

TEST(RetraceMonitor, beside_is_measured_in_units_of_the_parameter) {
  Line line;
  line.trail = RetraceMonitor(1e-3);
  for (int i = 0; i < 20; ++i) line.add(0.01 * i, 1);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(line.add(0.155 - 0.01 * i, -1, 1e-5), RetraceMonitor::Sense::fresh);
  EXPECT_EQ(line.add(0.105, -1, 1e-5), RetraceMonitor::Sense::opposite);
}
