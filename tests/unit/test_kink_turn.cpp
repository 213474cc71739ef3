// Round the kink of a hairpin: p = -slope |x|.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>

#include "continuation/kink_turn.hpp"
#include "told_solves.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr double slope = 3;

struct Hairpin : SmallCurve {
  Hairpin() : SmallCurve(hairpin(slope), 1) {}
  CurvePoint here = at(-1e-4, -slope * 1e-4), trial = curve.point();
};

} // namespace

TEST(KinkTurn, leads_to_the_other_leg) {
  Hairpin scene;
  double turned = 0;
  bool at_kink = false;
  KinkTurn turn(scene.curve, scene.here, scene.trial, 0, false, [&](const KinkTurn::Leg &leg) {
    turned = leg.turned, at_kink = leg.at_kink;
    EXPECT_GT(leg.way, 0);
    return true;
  });
  ASSERT_TRUE(turn.turn(1e-3));
  EXPECT_TRUE(at_kink);
  EXPECT_GT(values(scene.trial.y)[0], 0);
  EXPECT_LT(parameter_of(scene.trial.t), 0); // back to smaller values
  EXPECT_EQ(scene.trial.sign, scene.here.sign);
  EXPECT_NEAR(turned, angle(scene.curve.norm, scene.here.t, scene.trial.t), 1e-12);
}

TEST(KinkTurn, of_legs_that_are_refused_it_tries_others_and_gives_up) {
  Hairpin scene;
  int offered = 0;
  KinkTurn turn(scene.curve, scene.here, scene.trial, 0, false, [&](const KinkTurn::Leg &) {
    ++offered;
    return false;
  });
  EXPECT_FALSE(turn.turn(1e-3));
  EXPECT_GT(offered, 1);
}

TEST(KinkTurn, a_smooth_curve_has_no_other_leg) {
  SmallCurve scene(circle(), 1);
  const CurvePoint here = scene.at(1, 0);
  CurvePoint trial = scene.curve.point();
  KinkTurn turn(scene.curve, here, trial, 1, false, [](const KinkTurn::Leg &) { return true; });
  EXPECT_FALSE(turn.turn(1e-3));
}

namespace {

// Legs in closed form: x = b(p), or anything else, with all places where tangents and other legs are looked for.
struct Legs : ToldProblem {
  explicit Legs(Equations equations)
      : ToldProblem(
            {equations.unknowns, equations.f, [this, slopes = equations.derivative](const double *y, double *J) {
               slopes(y, J);
               looked.push_back({y[0], y[equations_.unknowns]});
             }}) {}
  bool is_admissible(double p) const override {
    guessed.push_back(p);
    return admits;
  }
  bool is_smooth() const override { return smooth; }

  /// The leg that is taken from (x, p) where the tangent is (along x, along p), if one is.
  std::optional<KinkTurn::Leg> leg(std::array<double, 4> from, double step, double curvature = 0,
                                   bool expensive = false) {
    here = curve.point(), trial = curve.point();
    here.y = vector({from[0]}), here.t = vector({from[2]});
    set_parameter(here.y, from[1]), set_parameter(here.t, from[3]);
    if (!curve.tangent_at(here.y, here.t, trial.t, here.sign)) EXPECT_GT(told.fail_until, 0);
    if (sign) here.sign = *sign;
    told.factorisations = 0;
    looked.clear(), guessed.clear();
    std::optional<KinkTurn::Leg> taken;
    const bool turned = KinkTurn(curve, here, trial, curvature, expensive, [&](const KinkTurn::Leg &found) {
                          taken = found, normal = values(found.normal);
                          return true;
                        }).turn(step);
    EXPECT_EQ(turned, taken.has_value());
    return taken;
  }

  SolveCounts counts;
  Curve curve{*this, {1e-11, 1e-12, 30}, 1, false, counts};
  CurvePoint here, trial;
  std::vector<double> normal;
  std::vector<std::array<double, 2>> looked; ///< x and p
  mutable std::vector<double> guessed;       ///< p
  bool admits = true, smooth = true;
  std::optional<int> sign; ///< of here, unless it is what it is
};

/// x = b(p)
Equations over_p(const std::function<double(double)> &b, const std::function<double(double)> &rate) {
  return one([b](double x, double p) { return x - b(p); }, [](double, double) { return 1.0; },
             [rate](double, double p) { return -rate(p); });
}

/// p = -g(x) from (0, 0) on, and before it p = first x.
Equations over_x(const std::function<double(double)> &g, const std::function<double(double)> &rate, double first = 3) {
  return one([=](double x, double p) { return p + (x < 0 ? -first * x : g(x)); },
             [=](double x, double) { return x < 0 ? -first : rate(x); }, [](double, double) { return 1.0; });
}

const double root10 = std::sqrt(10.0);
// On that leg, so far before its end.
std::array<double, 4> before(double distance, double first = 3) {
  const double along_x = 1 / std::hypot(1, first), along_p = first * along_x;
  return {-distance * along_x, -distance * along_p, along_x, along_p};
}

} // namespace

TEST(KinkTurn, looks_for_other_tangents_near_and_far) {
  Legs legs(over_p([](double) { return 0.0; }, [](double) { return 0.0; }));
  for (const double step : {1e-3, 1.01e-4, 1e-4, 0.5e-4}) {
    EXPECT_FALSE(legs.leg({0, 0, 0, 1}, step));
    ASSERT_GE(legs.looked.size(), 6u);
    EXPECT_EQ(legs.looked.size() > 6, step <= 1e-4); // near it the other side is tried as well
    for (int i = 0; i < 6; ++i)
      EXPECT_DOUBLE_EQ(legs.looked[i][1], step * (std::array{1.0, 4.0, 0.25, 16.0, 64.0, 0.02}[i]));
  }
  legs.sign = 0;
  EXPECT_FALSE(legs.leg({0, 0, 0, 1}, 1e-3));
  EXPECT_TRUE(legs.looked.empty());
  EXPECT_FALSE(legs.leg({0, 0, 0, 1}, 1e-4));
  EXPECT_FALSE(legs.looked.empty());
}

// Beyond p = 0 the leg turns by an angle, and from p = 2.5 steps on by a little more.
TEST(KinkTurn, tries_each_leg_with_steps_of_three_lengths) {
  const double step = 1e-3;
  const auto guesses = [&](double turn, double more, bool expensive, int sign) {
    const double first = std::tan(turn), second = std::tan(turn + more);
    Legs legs(over_p([=](double p) { return p < 0 ? 0 : first * p; },
                     [=](double p) { return p < 0            ? 0
                                            : p < 2.5 * step ? first
                                                             : second; }));
    legs.admits = false;
    legs.sign = sign;
    EXPECT_FALSE(legs.leg({0, 0, 0, 1}, step, 0, expensive));
    return legs.guessed;
  };
  for (const int sign : {1, -1}) // of the determinant: which way round the leg is gone
    for (const bool expensive : {false, true}) {
      const auto found = guesses(0.4, 0, expensive, sign);
      ASSERT_EQ(found.size(), expensive ? 2u : 3u);
      for (std::size_t i = 0; i < found.size(); ++i)
        EXPECT_NEAR(found[i], sign * step * std::cos(0.4) * (std::array{1.0, 0.1, 8.0}[i]), 1e-15);
    }
  EXPECT_TRUE(guesses(0.29, 0, false, 1).empty()); // straight on
  EXPECT_EQ(guesses(0.31, 0, false, 1).size(), 3u);
  EXPECT_EQ(guesses(0.4, std::acos(0.9991), false, 1).size(), 3u); // alike
  EXPECT_EQ(guesses(0.4, std::acos(0.9989), false, 1).size(), 6u);
}

// All in closed form: the guess a step along the other leg's tangent lies beside the leg by 0.6 of the distance to its
// begin; the point taken is a fifth of the way from there.
TEST(KinkTurn, a_leg_is_met_close_to_where_it_begins) {
  const double step = 1e-3;
  const auto leg = [](double x) { return 3 * x; };
  for (const double distance : {1e-4, 9e-4}) {
    Legs legs(over_x(leg, [](double) { return 3.0; }));
    const auto found = legs.leg(before(distance), step);
    ASSERT_TRUE(found);
    const double far = 0.2 * (0.8 * distance + step); // cos of the angle between the legs is -0.8
    const auto y = values(legs.trial.y);
    EXPECT_NEAR(y[0], far / root10, 1e-12);
    EXPECT_NEAR(y[1], -3 * far / root10, 1e-12);
    EXPECT_TRUE(found->at_kink);
    EXPECT_EQ(found->step, step);
    EXPECT_NEAR(found->turned, std::acos(-0.8), 1e-9);
    EXPECT_NEAR(found->way, std::hypot(y[0] + distance / root10, y[1] + 3 * distance / root10), 1e-12);
    EXPECT_EQ(legs.normal, values(legs.here.t));
  }
}

TEST(KinkTurn, a_leg_is_refused_that_is_far_from_the_guess) {
  const double step = 1e-3, turn = std::atan(10) + std::atan(1); // from p = 10 x to p = -x
  for (const double steps : {1.98, 2.02}) {                      // from the guess, across the leg
    Legs legs(over_x([](double x) { return x; }, [](double) { return 1.0; }, 10));
    ASSERT_TRUE(legs.leg(before(steps * step / std::sin(turn), 10), step));
    EXPECT_EQ(legs.guessed.size() == 1, steps < 2);
  }
}

// Its tangent where it was felt and that where it is met: 0.64 rad apart at most.
TEST(KinkTurn, a_leg_is_refused_that_turns_too_far) {
  for (const double bend : {0.63, 0.65}) {
    const double after = std::tan(std::atan(3) - bend), at = 1.5e-4;
    Legs legs(over_x([=](double x) { return x < at ? 3 * x : 3 * at + after * (x - at); },
                     [=](double x) { return x < at ? 3 : after; }));
    const auto found = legs.leg(before(6.32e-4), 1e-3);
    EXPECT_EQ(found && legs.guessed.size() == 1, bend < 0.64);
  }
}

// Near its begin the leg is bent: where four fifths of the way back lead there, a half is gone.
TEST(KinkTurn, goes_back_as_far_as_the_leg_is_straight) {
  const double step = 1e-3;
  for (const auto &[bend, part] : {std::pair{0.63, 0.2}, {0.65, 0.5}}) {
    const double first = std::tan(std::atan(3) - bend), at = 0.15e-3; // then on the line p = -3 (x + shift)
    const double shift = first * at / 3 - at;
    Legs legs(over_x([=](double x) { return x < at ? first * x : 3 * (x + shift); },
                     [=](double x) { return x < at ? first : 3; }));
    const auto found = legs.leg(before(1e-4), step);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->step, step, 1e-15);
    const auto y = values(legs.trial.y);
    EXPECT_EQ(y[0] < at, part < 0.3);
    const double met = 4 * shift / root10, far = 0.8e-4 + step; // along the leg's tangent
    EXPECT_NEAR((y[0] - 3 * y[1]) / root10, met + part * (far - met), 1e-12);
  }
}

// A bump of the tangent ahead is no leg: the curve goes on as it was, or jumps to the side by an angle of the way.
TEST(KinkTurn, a_piece_beside_is_no_leg) {
  const double step = 1e-3, slope = 0.5, sine = slope / std::hypot(slope, 1.0), cosine = 1 / std::hypot(slope, 1.0);
  for (const bool smooth : {true, false})
    for (const auto &[angle, part] : {std::pair{0.0, 1.0}, {smooth ? 0.09 : 0.78, 1.0}, {smooth ? 0.11 : 0.82, 0.1}}) {
      const double met = step / (sine * std::tan(angle) + cosine), jump = met * std::tan(angle);
      Legs legs(over_p([=](double p) { return p < 0.3 * step ? 0 : jump; },
                       [=](double p) { return p > 0.99 * step && p < 1.01 * step ? slope : 0; }));
      legs.smooth = smooth;
      const auto found = legs.leg({0, 0, 0, 1}, step);
      ASSERT_TRUE(found) << angle;
      EXPECT_DOUBLE_EQ(found->step, part * step) << angle;
      EXPECT_EQ(found->way, found->step);
      EXPECT_FALSE(found->at_kink);
      EXPECT_NEAR(found->turned, 0, 1e-9);
      EXPECT_NEAR(legs.normal[0], sine, 1e-12);
      EXPECT_NEAR(legs.normal[1], cosine, 1e-12);
      EXPECT_NEAR(values(legs.trial.y)[1], part == 1 ? met : part * step / cosine, 1e-12);
    }
}

// In three dimensions the legs' lines may miss each other: by a twentieth of the way round.
TEST(KinkTurn, a_leg_is_refused_that_begins_elsewhere) {
  const double step = 1e-3, distance = 1e-4, back = 0.2 * (0.8 * distance + step);
  for (const auto &[part, taken] : {std::pair{0.049, true}, {0.051, false}}) {
    const double aside = part * (distance + back);
    Legs legs(
        {2, [=](const double *y, double *f) { f[0] = y[2] + 3 * std::abs(y[0]), f[1] = y[1] - (y[0] > 0 ? aside : 0); },
         [](const double *y, double *J) {
           std::fill_n(J, 6, 0.0);
           J[0] = y[0] < 0 ? -3 : 3, J[2] = 1, J[4] = 1;
         }});
    const auto found = legs.leg(before(distance), step);
    EXPECT_EQ(found && found->step == step, taken) << part;
  }
}

TEST(KinkTurn, where_no_solve_succeeds_there_is_no_leg) {
  Legs legs(over_x([](double x) { return 3 * x; }, [](double) { return 3.0; }));
  legs.told.fail_at = 0, legs.told.fail_until = 1000;
  EXPECT_FALSE(legs.leg(before(1e-4), 1e-3));
  legs.told.fail_at = 1000;
  EXPECT_TRUE(legs.leg(before(1e-4), 1e-3));
}
