// Curves that lead nowhere, by numbers alone.
#include <gtest/gtest.h>

#include "continuation/progress_monitors.hpp"

using namespace dovetail;

TEST(ProgressMonitors, folds_that_crowd_are_told_from_folds_far_apart) {
  FoldClusterMonitor far(1), close(1);
  for (int i = 0; i < 12; ++i) far.folded(0.1 * i), close.folded(0.5 + 0.001 * i);
  EXPECT_FALSE(far.crowded());
  EXPECT_TRUE(close.crowded());
  EXPECT_NEAR(close.beyond(0.5, 1), 0.511 + 0.01, 1e-12);
  EXPECT_FALSE(close.crowded()); // it was told
}

TEST(ProgressMonitors, the_place_beyond_lies_in_the_sense_of_the_range) {
  FoldClusterMonitor monitor(1);
  for (int i = 0; i < 12; ++i) monitor.folded(0.5 + 0.001 * i);
  EXPECT_NEAR(monitor.beyond(0.505, -1), 0.5 - 0.01, 1e-12);
}

TEST(ProgressMonitors, a_curve_that_goes_on_never_winds) {
  NoProgressMonitor monitor(1);
  monitor.begin(0, 0, 1);
  for (int i = 1; i <= 100; ++i) {
    monitor.stepped(0.02 * i, 100 * i);
    EXPECT_FALSE(monitor.winds(0.02 * i, 100 * i, 400));
  }
}

TEST(ProgressMonitors, patience_is_shared_by_the_times_that_a_curve_is_left) {
  NoProgressMonitor monitor(1);
  monitor.begin(0.5, 0, -1);
  EXPECT_FALSE(monitor.winds(0.5, 400, 400));
  EXPECT_TRUE(monitor.winds(0.5, 401, 400));
  monitor.left(0.5);
  monitor.restart_count(401);
  EXPECT_FALSE(monitor.winds(0.5, 401 + 200, 400));
  EXPECT_TRUE(monitor.winds(0.5, 401 + 201, 400));
  monitor.stepped(0.4, 900); // in the sense of the range it went on
  EXPECT_FALSE(monitor.winds(0.4, 900 + 400, 400));
}

TEST(ProgressMonitors, where_no_way_on_was_found_it_takes_more_before_the_next_try) {
  NoProgressMonitor monitor(1);
  monitor.begin(0, 0, 1);
  monitor.stayed(0.1);
  monitor.restart_count(401);
  EXPECT_FALSE(monitor.winds(0.1, 401 + 401, 400));
  EXPECT_TRUE(monitor.winds(0.1, 401 + 801, 400));
  EXPECT_TRUE(monitor.winds(0.2, 401 + 401, 400)); // unless it has been farther
}

TEST(ProgressMonitors, three_steps_of_mean_positions_are_a_drift) {
  DriftMonitor monitor;
  for (const double swing : {1e-9, 1e-9}) monitor.stepped(swing, 1);
  EXPECT_FALSE(monitor.drifts());
  monitor.stepped(1e-9, 1);
  EXPECT_TRUE(monitor.drifts());
  monitor.stepped(0.1, 1);
  EXPECT_FALSE(monitor.drifts());
}

TEST(ProgressMonitors, state_survives_an_archive) {
  NoProgressMonitor monitor(1), restored(1);
  monitor.begin(0, 0, 1);
  monitor.left(0.3);
  monitor.restart_count(50);
  Archive saved;
  monitor.archive(saved);
  Archive reading(saved.fields());
  restored.archive(reading);
  for (const long newton : {249L, 251L})
    EXPECT_EQ(monitor.winds(0.3, newton, 400), restored.winds(0.3, newton, 400)) << newton;
  EXPECT_TRUE(restored.winds(0.3, 251, 400));
}
