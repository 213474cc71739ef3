// Which trial steps are steps along the curve, asked of plane curves: tangent (1, 0) at the last point, the step's
// plane at x = 1.
#include <gtest/gtest.h>

#include <cmath>

#include "continuation/step_rules.hpp"

using namespace dovetail;
using Measure = Halvings::Measure;

TEST(StepRules, smooth_curves_and_kinks_are_followed) {
  for (const double turned : {0.05, 0.3, 0.6}) {
    const Measure arc{turned, (1 - std::cos(turned)) / std::sin(turned)};
    EXPECT_FALSE(arc.refused()) << turned;
    for (const double before : {0.0, 0.5, 0.9}) // of the step lies before the kink
      EXPECT_FALSE((Measure{turned, (1 - before) * std::tan(turned)}.refused())) << turned << " " << before;
  }
}

TEST(StepRules, another_piece_of_the_curve_is_refused_however_short_the_step) {
  for (const double turned : {0.0, 0.3, 0.5}) {
    Halvings halvings;
    for (double away = 1.1; away < 100; away *= 2) { // in steps, which become shorter
      const Measure beside{turned, away};
      EXPECT_TRUE(beside.refused()) << turned << " " << away;
      EXPECT_FALSE(halvings.add(beside)) << turned << " " << away;
    }
  }
}

TEST(StepRules, teeth_of_sampled_curves_are_stepped_over) {
  for (const double turned : {0.0, 0.2}) {
    const Measure tooth{turned, 0.8};
    EXPECT_TRUE(tooth.refused());
    EXPECT_FALSE((Measure{turned, 0.8, most_astray_sampled}.refused()));
    EXPECT_TRUE((Measure{turned, 2.0, most_astray_sampled}.refused()));
  }
}

TEST(StepRules, a_sharp_corner_is_known_by_two_halvings) {
  Halvings halvings;
  const Measure corner{1.0, std::tan(1.0)};
  EXPECT_TRUE(corner.refused());
  EXPECT_FALSE(halvings.add(corner));
  EXPECT_FALSE(halvings.add(corner));
  EXPECT_TRUE(halvings.add(corner));
}
