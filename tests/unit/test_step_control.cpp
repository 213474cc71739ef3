// Which trial steps are steps along the curve, asked of plane curves: tangent (1, 0) at the last point, the step's
// plane at x = 1.
#include <gtest/gtest.h>

#include <cmath>

#include "continuation/step_control.hpp"

using namespace dovetail;
using Measure = StepMeasure;

TEST(StepControl, smooth_curves_and_kinks_are_followed) {
  for (const double turned : {0.05, 0.3, 0.6}) {
    const Measure arc{turned, (1 - std::cos(turned)) / std::sin(turned)};
    EXPECT_FALSE(arc.may_be_kink()) << turned;
    for (const double before : {0.0, 0.5, 0.9}) // of the step lies before the kink
      EXPECT_FALSE((Measure{turned, (1 - before) * std::tan(turned)}.may_be_kink())) << turned << " " << before;
  }
}

TEST(StepControl, another_piece_of_the_curve_is_refused_however_short_the_step) {
  for (const double turned : {0.0, 0.3, 0.5}) {
    Halvings halvings;
    for (double away = 1.1; away < 100; away *= 2) { // in steps, which become shorter
      const Measure beside{turned, away};
      EXPECT_TRUE(beside.may_be_kink()) << turned << " " << away;
      EXPECT_FALSE(halvings.add(beside)) << turned << " " << away;
    }
  }
}

TEST(StepControl, teeth_of_sampled_curves_are_stepped_over) {
  for (const double turned : {0.0, 0.2}) {
    const Measure tooth{turned, 0.8};
    EXPECT_TRUE(tooth.may_be_kink());
    EXPECT_FALSE((Measure{turned, 0.8, false}.may_be_kink()));
    EXPECT_TRUE((Measure{turned, 2.0, false}.may_be_kink()));
  }
}

TEST(StepControl, a_sharp_kink_is_known_by_two_halvings) {
  Halvings halvings;
  const Measure kink{1.0, std::tan(1.0)};
  EXPECT_TRUE(kink.may_be_kink());
  EXPECT_FALSE(halvings.add(kink));
  EXPECT_FALSE(halvings.add(kink));
  EXPECT_TRUE(halvings.add(kink));
}

TEST(StepControl, a_step_grows_by_few_iterations_and_small_angles_only) {
  for (const bool smooth : {false, true}) {
    const StepAims &aims = aims_of(smooth);
    StepControl control(true, 0.01, 1e-3);
    control.after(0.01, 0.01, 2, 0, smooth);
    EXPECT_DOUBLE_EQ(control.step(), aims.most_growth * 0.01);
    control.after(0.02, 2 * aims.angle, 2, 0, smooth);
    EXPECT_DOUBLE_EQ(control.step(), 0.01); // for an angle twice as large as aimed at
    control.after(0.01, 0.01, aims.newton + 2, 0, smooth);
    EXPECT_DOUBLE_EQ(control.step(), 0.005); // for two iterations more
    control.after(0.005, 3.0, 40, 0, smooth);
    EXPECT_DOUBLE_EQ(control.step(), smooth ? 0.00125 : 0.0025); // nor does it shrink by more than it may grow
  }
}

TEST(StepControl, a_step_is_as_long_as_a_cubic_draws_the_curve) {
  StepControl control(true, 0.1, 1e-3);
  const double off = 0.9e-3, fourth = off / std::pow(0.1, 4);
  control.after(0.1, 0.01, 2, off, true);
  EXPECT_LT(fourth * std::pow(control.step(), 4), 1e-3); // by the same fourth derivative
  EXPECT_GT(fourth * std::pow(control.step(), 4), 0.3e-3);
  control.after(0.1, 0.01, 2, 1e-9, true);
  EXPECT_DOUBLE_EQ(control.step(), 0.4);
}

TEST(StepControl, a_fixed_step_stays) {
  StepControl control(false, 0.01, 1e-3);
  control.after(0.01, 1, 20, 1, true);
  control.limit({1e6, 1e6, 1e-6}, true);
  EXPECT_EQ(control.step(), 0.01);
}

TEST(StepControl, limits_hold) {
  for (const bool smooth : {false, true}) {
    const auto limited = [smooth](const Rates &rates) {
      StepControl control(true, 2, 1e-3);
      control.limit(rates, smooth);
      return control.step();
    };
    const StepAims &aims = aims_of(smooth);
    const double octave = smooth ? std::exp2(-0.125) : 1 - 1e-12; // lengths of smooth curves are rounded down
    const auto expect = [&](const Rates &rates, double length) {
      EXPECT_LE(limited(rates), length * (1 + 1e-9));
      EXPECT_GE(limited(rates), length * octave);
    };
    expect({0, 0, 0}, aims.longest);
    expect({0.5, 0, 0}, aims.parameter / 0.5);
    expect({0, 1, 0.1}, aims.motion * 0.1);
    expect({0, 1, 0}, step_limits.careful);
  }
}

TEST(StepControl, lengths_of_smooth_curves_are_few) {
  StepControl control(true, 0.0123, 1e-3);
  control.limit({0, 0, 0}, true);
  const double octaves = 8 * std::log2(control.step());
  EXPECT_NEAR(octaves, std::round(octaves), 1e-9);
  EXPECT_LE(control.step(), 0.0123);
  EXPECT_GT(control.step(), 0.0123 / 1.1);
}
