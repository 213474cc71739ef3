// What rules steps along a curve, at its edges: thresholds, closed forms, and states that come back from an archive.
#include <gtest/gtest.h>

#include <cmath>

#include "continuation/between.hpp"
#include "continuation/progress_monitors.hpp"
#include "continuation/step_control.hpp"
#include "small_problems.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

template <class Monitor> Monitor restored(Monitor &monitor, Monitor other) {
  Archive saved;
  monitor.archive(saved);
  Archive reading(saved.fields());
  other.archive(reading);
  return other;
}

Amplitude quartic(double s) { return {std::pow(s, 4), 4 * std::pow(s, 3)}; }

} // namespace

TEST(StepMeasure, is_refused_beyond_its_limits) {
  EXPECT_FALSE((StepMeasure{1.05, 0.1}.turns_too_far()));
  EXPECT_TRUE((StepMeasure{1.051, 0.1}.turns_too_far()));
  EXPECT_FALSE((StepMeasure{0.64, 0.1, false}.turns_too_far() || StepMeasure{0.64, 0.1}.may_be_kink()));
  EXPECT_TRUE((StepMeasure{0.641, 0.1, false}.turns_too_far() && StepMeasure{0.641, 0.1}.may_be_kink()));
  EXPECT_FALSE((StepMeasure{0.3, std::tan(0.399)}.lies_too_far())); // a tenth beyond the angle
  EXPECT_TRUE((StepMeasure{0.3, std::tan(0.401)}.lies_too_far()));
  EXPECT_TRUE((StepMeasure{0.29, 0.29}.straight()));
  EXPECT_FALSE((StepMeasure{0.31, 0.29}.straight()) || (StepMeasure{0.29, 0.31}.straight()));
  EXPECT_EQ(smooth_aims.astray, 0.1);
  EXPECT_EQ(rough_aims.astray, 0.8);
}

TEST(Halvings, show_a_kink_where_angles_stay_and_corrections_halve) {
  const auto third = [](double angle, double correction) { // two alike, then one by these factors
    Halvings halvings;
    halvings.add({1, 4}), halvings.add({1, 2});
    return halvings.add({angle, 2 * correction});
  };
  EXPECT_TRUE(third(1, 0.5));
  EXPECT_TRUE(third(0.76, 1.49));
  EXPECT_FALSE(third(0.74, 0.5)); // a smooth curve
  EXPECT_FALSE(third(1, 1.51));   // another branch
  Halvings begun;
  EXPECT_FALSE(begun.add({0.1, 0.01})); // not refused: what follows is not like it
  EXPECT_FALSE(begun.add({1, 2}));
  EXPECT_FALSE(begun.add({1, 1}));
  EXPECT_TRUE(begun.add({1, 0.5}));
  EXPECT_FALSE(begun.add({0.5, 0.25})); // and the count begins anew
  EXPECT_FALSE(begun.add({0.5, 0.125}));
}

TEST(StepLengths, lengths_are_of_eighths_of_octaves_and_not_too_short) {
  const auto limited = [](double step, bool smooth, double shortest = 1e-7) {
    StepControl control(true, step, 1e-3, shortest);
    control.limit({0, 0, 0}, smooth);
    return control.step();
  };
  for (int i = 0; i < 64; ++i) // one of these lengths stays
    EXPECT_DOUBLE_EQ(limited(std::exp2(-i / 8.0), true), std::exp2(-i / 8.0));
  EXPECT_DOUBLE_EQ(limited(0.1249, true), 0.125 * std::exp2(-0.125));
  EXPECT_DOUBLE_EQ(limited(7, true), 1);
  EXPECT_DOUBLE_EQ(limited(0.0123, false), 0.0123);
  EXPECT_DOUBLE_EQ(limited(1e-9, false, 1e-4), 1e-3); // ten times the shortest
  StepControl control(true, 0.1, 1e-3), fixed(false, 0.1, 1e-3, 0.01);
  control.after(0.1, 1e-3, 2, 0.9e-3, true);
  EXPECT_DOUBLE_EQ(control.step(), 0.1 * std::pow(0.5 / 0.9, 0.25));
  EXPECT_DOUBLE_EQ(restored(control, StepControl(true, 1, 1e-3)).step(), control.step());
  control.set(0.3);
  EXPECT_EQ(control.step(), 0.3);
  EXPECT_EQ(control.between(), 1e-3);
  EXPECT_EQ(control.shortest(), 1e-7);
  EXPECT_DOUBLE_EQ(fixed.shortest(), 0.001);
}

TEST(FoldClusterMonitor, is_crowded_by_twelve_in_three_hundredths) {
  for (const auto &[spread, crowds] : {std::pair{0.0598, true}, {0.0602, false}}) { // of a range of 2
    FoldClusterMonitor monitor(2);
    monitor.folded(5); // long ago
    for (int i = 0; i < 11; ++i) monitor.folded(1 - spread * (i % 2));
    EXPECT_FALSE(monitor.crowded());
    monitor.folded(1 - spread / 2);
    EXPECT_EQ(monitor.crowded(), crowds);
    EXPECT_EQ(restored(monitor, FoldClusterMonitor(2)).crowded(), crowds);
    EXPECT_NEAR(restored(monitor, FoldClusterMonitor(2)).beyond(0.5, 1), 1.02, 1e-12); // the one at 5 does not count
    EXPECT_NEAR(monitor.beyond(1.5, 1), 1.52, 1e-12);
    EXPECT_NEAR(monitor.beyond(1.5, -1), 1.48, 1e-12); // they are forgotten
  }
}

TEST(NoProgressMonitor, counts_anew_a_hundredth_on_and_forgets_what_lies_far_behind) {
  NoProgressMonitor monitor(2);
  monitor.begin(1, 10, -1);
  monitor.stepped(0.981, 50);
  EXPECT_TRUE(monitor.winds(0.981, 111, 100));
  EXPECT_FALSE(monitor.winds(0.981, 110, 100));
  monitor.stepped(0.979, 50);
  EXPECT_FALSE(monitor.winds(0.979, 111, 100));
  EXPECT_TRUE(monitor.winds(0.979, 151, 100));
  monitor.spare(5);
  EXPECT_FALSE(monitor.winds(0.979, 151, 100));
  monitor.stayed(0.979);
  monitor.left(0.979);
  EXPECT_EQ(monitor.times_left(), 1);
  EXPECT_EQ(monitor.times_stayed(), 0);
  monitor.stepped(0.92, 200);
  EXPECT_EQ(monitor.times_left(), 1);
  monitor.stepped(0.918, 200);
  EXPECT_EQ(monitor.times_left(), 0);
}

TEST(NoProgressMonitor, is_farther_by_more_than_a_hundredth) {
  NoProgressMonitor monitor(100);
  monitor.begin(0, 0, 1);
  monitor.stayed(5);
  for (const double farthest : {6.0, 6.001}) EXPECT_EQ(monitor.winds(farthest, 150, 100), farthest > 6);
}

TEST(NoProgressMonitor, comes_back_from_an_archive) {
  NoProgressMonitor monitor(1);
  monitor.begin(0.5, 7, -1);
  monitor.left(0.4);
  monitor.stayed(0.3), monitor.stayed(0.2);
  NoProgressMonitor other = restored(monitor, NoProgressMonitor(1));
  EXPECT_EQ(other.times_left(), 1);
  EXPECT_EQ(other.times_stayed(), 2);
  for (const double farthest : {0.2, 0.191, 0.189})
    for (const long newton : {57L, 58L, 157L, 158L}) {
      const bool winds = newton > (farthest < 0.19 ? 57 : 157); // a half of the patience, thrice that where it stayed
      EXPECT_EQ(monitor.winds(farthest, newton, 100), winds) << farthest << " " << newton;
      EXPECT_EQ(other.winds(farthest, newton, 100), winds) << farthest << " " << newton;
    }
  other.stepped(0.36, 0);
  EXPECT_EQ(other.times_left(), 0); // it was left at 0.4
}

TEST(DriftMonitor, takes_three_steps_in_a_row) {
  for (const auto &[swing, still] : {std::pair{1.99e-6, true}, {2.01e-6, false}}) { // of a way of 2
    DriftMonitor monitor;
    for (int i = 0; i < 3; ++i) {
      EXPECT_FALSE(monitor.drifts());
      monitor.stepped(swing, 2);
    }
    EXPECT_EQ(monitor.drifts(), still);
    monitor.forget();
    EXPECT_FALSE(monitor.drifts());
  }
}

TEST(BetweenInClosedForm, of_a_quartic_are_in_closed_form) { // its cubic is off by h^4 / 16
  BetweenPoints between;
  double s = 0.5;
  between.begin(quartic(s));
  std::vector<double> found;
  for (const double step : {0.2, 0.1, 0.2, 0.15, 0.3}) {
    s += step;
    found.push_back(between.add(step, quartic(s)) * quartic(s).value);
    if (found.size() > 2) {
      EXPECT_NEAR(found.back(), std::pow(step, 4) / 16, 1e-12) << step;
    }
  }
  EXPECT_TRUE(std::isnan(found[0]));
  EXPECT_NEAR(found[1], std::pow(0.2 * 0.1, 2) / 2, 1e-12); // two pieces do not tell whether there is a kink
}

TEST(BetweenInClosedForm, of_a_kink_are_an_eighth_of_its_jump_at_most) { // 0 up to 0.05, then a line that rises by 1
  const auto kinked = [](double s) { return Amplitude{std::max(0.0, s - 0.05), s > 0.05 ? 1.0 : 0.0}; };
  BetweenPoints between;
  between.begin({0, 0});
  for (const double s : {-0.3, -0.2, -0.1, 0.0}) between.add(0.1, kinked(s));
  const double value = 0.05, off = std::abs(0.5 * value - 0.2 / 8), askew = std::abs(1.5 * value / 0.2 - 0.25) * 0.1;
  EXPECT_NEAR(between.add(0.1, kinked(0.1)) * value, std::min(0.1 / 8, 0.5 * std::max(off, askew)), 1e-12);
  BetweenPoints nothing;
  nothing.begin({0, 0});
  for (int i = 0; i < 3; ++i) nothing.add(0.1, {0, 0});
  EXPECT_EQ(nothing.add(0.1, {0, 0}), 0); // nothing moves
}

TEST(Projections, the_first_is_the_parameter_and_the_others_are_of_the_rest) {
  SmallProblem problem({3, nullptr, nullptr});
  const auto projected = [&](double x, double p) {
    const UniqueVec y = problem.unknowns();
    check(VecSet(y, x), "");
    set_parameter(y, p);
    return problem.projected({y})[0];
  };
  const auto one = projected(1, 5), other = projected(2, 7);
  EXPECT_EQ(one[0], 5);
  EXPECT_EQ(other[0], 7);
  for (std::size_t k = 1; k < one.size(); ++k) {
    EXPECT_NE(one[k], 0);
    EXPECT_EQ(other[k], 2 * one[k]);
  }
}
