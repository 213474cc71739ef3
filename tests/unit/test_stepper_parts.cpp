// What a step is made of: its length, its guess, what refuses it, what is told of it; in closed form.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "small_problems.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

struct Step {
  double length, chord;
  int newton;
  bool at_kink;
};

// A walk with everything that the stepper tells.
struct Watched : Walk {
  explicit Watched(Equations equations, double range = 1, double between = 1e-3)
      : Walk({equations.unknowns,
              [this, f = equations.f](const double *y, double *out) {
                f(y, out);
                if (!tried) guess = {y[0], y[1]};
                tried = true;
              },
              equations.derivative},
             range, between) {}

  Outcome pass(Vec normal, double step, bool at_kink) override {
    guesses.push_back(guess);
    if (answer != Outcome::on) return answer;
    if (at_kink && at_kinks != Outcome::on) return at_kinks;
    steps.push_back({step, curve_->chord(here_.y, trial_.y), trial_.newton.newton, at_kink});
    return Walk::pass(normal, step, at_kink);
  }
  void halved(const std::string &why) override {
    whys.push_back(why);
    tried = false;
  }
  bool refine(CurvePoint &) override { return refinements++ < refines; }
  void stepped() override { ++told; }
  bool takes_jump(double apart) override {
    aparts.push_back(apart);
    return jumps;
  }
  void jumped() override { ++jumps_told; }
  void turned_kink(double angle, double parameter) override { kinks.push_back(angle), kink_at = parameter; }
  Outcome no_step() override {
    ++no_steps;
    return Outcome::ended;
  }
  bool iterations_are_expensive() const override {
    kinks_sought.push_back(static_cast<int>(whys.size()));
    return false;
  }
  bool is_admissible(double p) const override { return p > least; }
  bool is_smooth() const override { return smooth; }

  Outcome step() {
    tried = false;
    return advance();
  }
  double next() const { return control_.step(); }
  void fix(double step) { control_ = StepControl(false, step, 1e-3); }
  void set(double step) { control_.set(step); }
  const std::optional<CurvePoint> &before() const { return before_; }
  CurvePoint &here() { return here_; }
  std::vector<CurvePoint> &ahead() { return ahead_; }
  Curve &curve() { return own_; }
  std::string refusal() const { return refusal_; }
  void save(Archive &archive) { archive_steps(archive); }
  void remember(const CurvePoint &s) { note(before_, s); }

  std::vector<Step> steps;
  std::vector<std::array<double, 2>> guesses;
  std::array<double, 2> guess{};
  std::vector<std::string> whys;
  std::vector<double> aparts;
  mutable std::vector<int> kinks_sought; // behind so many halvings
  bool tried = false, jumps = false, smooth = true;
  Outcome answer = Outcome::on, at_kinks = Outcome::on;
  int refinements = 0, refines = 0, told = 0, jumps_told = 0, no_steps = 0;
  double least = -100, kink_at = -1;
};

using Outcome = Stepper::Outcome;

Equations line(double slope) { // x = 1 + slope p
  return one([slope](double x, double p) { return x - 1 - slope * p; }, [](double, double) { return 1.0; },
             [slope](double, double) { return -slope; });
}

double eighth(double step) { return std::exp2(std::floor(8 * std::log2(step) + 1e-9) / 8); }

// Of a step from (x, p) along (along x, along p), by the largest motion and a range.
double limited(double wanted, const std::vector<double> &y, const std::vector<double> &t, double range) {
  return eighth(std::min({wanted, 1.0, smooth_aims.parameter * range / std::abs(t[1]),
                          std::max(smooth_aims.motion * std::abs(y[0]) / std::abs(t[0]), 1e-3)}));
}

} // namespace

// Along a line nothing but the limits ends growth, by four each time; lengths are of x by the largest and of p by 2.
TEST(Steps, grow_up_to_the_limits_of_where_they_are) {
  for (const auto &[slope, sense] : {std::pair{0.5, 1}, {-3.0, 1}, {1.0, -1}, {40.0, -1}}) {
    Watched walk(line(slope), 2);
    walk.begin({1}, 0, sense);
    double largest = 1;
    for (int i = 0; i < 12; ++i) {
      const double before = walk.next();
      const auto from = walk.points.back(), along = walk.tangents.back();
      ASSERT_EQ(walk.step(), Outcome::on);
      const auto &y = walk.points.back();
      EXPECT_EQ(walk.steps.back().length, before);
      EXPECT_NEAR(walk.steps.back().chord, std::hypot(y[0] - from[0], y[1] - from[1]), 1e-12);
      largest = std::max(largest, std::abs(y[0]));
      const double length = std::hypot(slope / largest, 0.5); // of the way for p + 1
      const std::vector<double> t{sense * slope / length, sense / length}, found = values(walk.here().t);
      for (int k = 0; k < 2; ++k) EXPECT_NEAR(found[k], t[k], 1e-9);
      for (int k = 0; k < 2; ++k) EXPECT_NEAR(y[k], from[k] + before * along[k], 1e-9);
      walk.tangents.back() = found; // by the metric as it is now
      EXPECT_NEAR(walk.next(), limited(4 * before, y, t, 2), 1e-12) << slope << " " << i;
    }
    EXPECT_EQ(walk.told, 12);
    EXPECT_TRUE(walk.whys.empty());
  }
}

TEST(Steps, are_as_long_as_angle_and_iterations_tell) {
  Watched walk(circle(), 1, 1e9); // drawn as it may be
  walk.begin({1}, 0, 1);
  walk.curve().norm.see(walk.here().y);
  for (int i = 0; i < 40; ++i) {
    const auto from = walk.tangents.back();
    ASSERT_EQ(walk.step(), Outcome::on);
    const auto &to = walk.tangents.back(), y = walk.points.back();
    const double turned = std::acos(from[0] * to[0] + from[1] * to[1]); // of radius 1: plain lengths
    const double factor =
        std::clamp(std::min(std::exp2((6 - walk.steps.back().newton) / 2.0), smooth_aims.angle / turned), 0.25, 4.0);
    EXPECT_NEAR(walk.next(), limited(factor * walk.steps.back().length, y, to, 1), 1e-9) << i;
  }
}

// From the lowest point of x = 100 (p - 1)^2, beside a motion of 100: by the plain norm the middle of the cubic to
// p = 1.045 lies ahead of that, so a point there would lead from middle to middle.
TEST(Steps, are_halved_where_their_middle_lies_ahead_of_their_end) {
  Watched walk(one([](double x, double p) { return x - 100 * (p - 1) * (p - 1); }, [](double, double) { return 1.0; },
                   [](double, double p) { return -200 * (p - 1); }),
               1);
  const CurvePoint large = walk.curve().point();
  check(VecSetValue(large.y, 0, 100, INSERT_VALUES), ""), check(VecAssemblyBegin(large.y), "");
  check(VecAssemblyEnd(large.y), "");
  walk.curve().norm.see(large.y);
  walk.begin({0}, 1, 1);
  walk.set(0.045);
  ASSERT_EQ(walk.step(), Outcome::on);
  ASSERT_FALSE(walk.whys.empty());
  EXPECT_EQ(walk.whys[0], "the middle of the step is not found");
  for (const CurvePoint &s : walk.ahead()) EXPECT_LE(s.parameter, 1.0225 + 1e-9);
}

// Guesses lie on the plane across the tangent: the first beside the curve by the square of the step, then by its fourth
// power; and as the first again where a step is halved.
TEST(Steps, guesses_are_cubic_where_a_step_led_here_and_straight_after_a_halving) {
  Watched walk(circle(), 1, 1e9);
  walk.begin({1}, 0, 1);
  for (int i = 0; i < 12; ++i) {
    const int halvings = i == 8;
    const auto from = walk.points.back(), t = walk.tangents.back();
    ASSERT_EQ(walk.before().has_value(), i > 0);
    if (i > 0) {
      EXPECT_EQ(values(walk.before()->y), walk.points[walk.points.size() - 2]);
      EXPECT_EQ(walk.before()->parameter, walk.points[walk.points.size() - 2][1]);
      EXPECT_EQ(walk.before()->sign, walk.here().sign);
    }
    double step = walk.next();
    if (halvings) {
      walk.answer = Outcome::refused; // once
      const auto outcome = walk.step();
      EXPECT_EQ(outcome, Outcome::ended);
      EXPECT_GT(walk.whys.size(), 5u);
      const std::size_t first = 8; // guesses of the steps before
      for (std::size_t k = 0; k < 5; ++k) {
        const auto &g = walk.guesses[first + k];
        const double part = step / std::exp2(k);
        const bool on_the_line = std::hypot(g[0] - from[0] - part * t[0], g[1] - from[1] - part * t[1]) < 1e-12;
        EXPECT_EQ(on_the_line, k > 0) << k;
      }
      walk.answer = Outcome::on;
      walk.kinks_sought.clear(), walk.whys.clear(), walk.no_steps = 0;
    }
    ASSERT_EQ(walk.step(), Outcome::on);
    const auto &g = walk.guesses.back();
    step = walk.steps.back().length;
    EXPECT_NEAR((g[0] - from[0]) * t[0] + (g[1] - from[1]) * t[1], step, 1e-12);
    const double off = std::abs(std::hypot(g[0], g[1]) - 1);
    if (i == 0)
      EXPECT_NEAR(off, std::sqrt(1 + step * step) - 1, 1e-9);
    else
      EXPECT_LT(off, 3 * std::pow(step, 4)) << i;
  }
}

TEST(Steps, what_their_owner_answers_decides) {
  for (const Outcome answer : {Outcome::ended, Outcome::refined, Outcome::refused}) {
    Watched walk(line(1));
    walk.begin({1}, 0, 1);
    const double first = walk.next();
    walk.answer = answer;
    EXPECT_EQ(walk.step(), answer == Outcome::refused ? Outcome::ended : answer);
    EXPECT_EQ(walk.told, 0);
    EXPECT_EQ(walk.no_steps, answer == Outcome::refused);
    EXPECT_EQ(walk.points.size(), 1u);
    EXPECT_EQ(walk.next(), first);
    if (answer == Outcome::ended) {
      EXPECT_EQ(walk.guesses.size(), 1u);
    }
    if (answer == Outcome::refined) {
      EXPECT_EQ(walk.guesses.size(), 9u); // eight more tries
    }
  }
}

TEST(Steps, a_problem_is_refined_up_to_eight_times) {
  for (const int refines : {0, 3, 8, 100}) {
    Watched walk(line(1));
    walk.begin({1}, 0, 1);
    walk.refines = refines;
    EXPECT_EQ(walk.step(), refines > 8 ? Outcome::refined : Outcome::on);
    EXPECT_EQ(walk.refinements, std::min(refines, 8) + 1);
    EXPECT_EQ(walk.points.size(), refines > 8 ? 1u : 2u);
    EXPECT_EQ(walk.told, refines <= 8);
  }
}

// Halved down to the least, and a kink looked for from 2e-3 on, then each time steps are a twentieth as long.
TEST(Steps, are_halved_to_the_end_and_kinks_sought_now_and_then) {
  Watched walk(line(1));
  walk.begin({1}, 0, 1);
  walk.least = 0; // nothing is admissible ahead
  walk.begin({1}, 0, -1);
  walk.set(0.03);
  walk.kinks_sought.clear();
  EXPECT_EQ(walk.step(), Outcome::ended);
  EXPECT_EQ(walk.no_steps, 1);
  EXPECT_EQ(walk.refusal(), "the predicted p is not positive");
  std::vector<int> wanted;
  int halvings = 0;
  double due = 2e-3;
  for (double step = 0.03; step >= 1e-7; step /= 2) {
    ++halvings;
    if (step <= due) wanted.push_back(halvings), due = step / 20;
  }
  EXPECT_EQ(static_cast<int>(walk.whys.size()), halvings);
  EXPECT_EQ(walk.kinks_sought, wanted);
  for (const std::string &why : walk.whys) EXPECT_EQ(why, "the predicted p is not positive");
}

TEST(Steps, of_one_length_are_neither_checked_nor_turned_round_kinks) {
  Watched walk(circle(), 1);
  walk.begin({1}, 0, 1);
  walk.fix(0.9); // turns by more than a step may
  ASSERT_EQ(walk.step(), Outcome::on);
  EXPECT_EQ(walk.next(), 0.9);
  EXPECT_FALSE(walk.before());
  EXPECT_NEAR(walk.points.back()[1], 0.9, 1e-11);
  walk.answer = Outcome::refused;
  EXPECT_EQ(walk.step(), Outcome::ended);
  EXPECT_EQ(walk.whys.size(), 24u); // 0.9 to 0.9e-7
  EXPECT_TRUE(walk.kinks_sought.empty());
}

TEST(Steps, of_rough_problems_keep_to_the_tangent_and_are_not_looked_into) {
  Watched walk(circle(), 1, 1e-12);
  walk.smooth = false;
  walk.begin({1}, 0, 1);
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(walk.step(), Outcome::on);
    EXPECT_FALSE(walk.before());
    EXPECT_TRUE(walk.ahead().empty());
  }
}

// Newton's method by half steps converges in some 14 iterations: too many for a step longer than 1e-4.
TEST(Steps, that_are_short_may_take_more_iterations) {
  Watched walk(one([](double x, double p) { return x - 1 - p * p; }, [](double, double) { return 2.0; },
                   [](double, double p) { return -4 * p; }));
  walk.begin({1.25}, 0.5, 1);
  walk.set(0.01);
  ASSERT_EQ(walk.step(), Outcome::on);
  EXPECT_LE(walk.steps.back().length, 1e-4);
  EXPECT_GT(2 * walk.steps.back().length, 1e-4);
  EXPECT_GT(walk.steps.back().newton, 8);
  ASSERT_EQ(walk.whys.size(), 7u);
  for (const std::string &why : walk.whys) EXPECT_EQ(why, "too many Newton iterations");
}

// From one line to another beside it, which are as far apart as their distance across.
TEST(Steps, jumps_are_taken_if_their_owner_takes_them) {
  constexpr double gap = 5e-3, slope = 0.1;
  for (const bool takes : {true, false}) {
    Watched walk(one([](double x, double p) { return x - 1 - slope * p - (p > 0.03 ? gap : 0); },
                     [](double, double) { return 1.0; }, [](double, double) { return -slope; }));
    walk.jumps = takes;
    walk.begin({1}, 0, 1);
    Outcome outcome = Outcome::on;
    double largest = 0;
    while (walk.aparts.empty()) largest = walk.curve().norm.largest_motion(), outcome = walk.step();
    EXPECT_NEAR(walk.aparts[0], gap / std::hypot(largest, slope), 1e-4 * gap);
    if (!takes) {
      while (outcome == Outcome::on) outcome = walk.step();
      EXPECT_EQ(outcome, Outcome::ended);
      EXPECT_EQ(walk.jumps_told, 0);
      EXPECT_LT(walk.points.back()[1], 0.03);
      continue;
    }
    EXPECT_EQ(outcome, Outcome::on);
    EXPECT_EQ(walk.jumps_told, 1);
    EXPECT_TRUE(walk.steps.back().at_kink);
    EXPECT_FALSE(walk.before());
    EXPECT_NEAR(walk.points.back()[0], 1 + gap + slope * walk.points.back()[1], 1e-11);
    EXPECT_EQ(std::count_if(walk.steps.begin(), walk.steps.end(), [](const Step &s) { return s.at_kink; }), 1);
  }
}

// Where the motion is small, it limits steps as well.
TEST(Steps, round_a_kink_begin_anew_with_the_length_along_the_other_leg) {
  for (const double at : {0.0, -1.0}) { // x of the kink
    Watched walk(one([at](double x, double p) { return p + 3 * std::abs(x - at); },
                     [at](double x, double) { return x < at ? -3.0 : 3.0; }, [](double, double) { return 1.0; }),
                 3);
    walk.begin({at - 1}, -3, 1);
    double from = 0;
    while (walk.kinks.empty()) {
      from = walk.points.back()[1];
      ASSERT_EQ(walk.step(), Outcome::on);
    }
    EXPECT_EQ(walk.kink_at, from);
    EXPECT_TRUE(walk.steps.back().at_kink);
    EXPECT_FALSE(walk.before());
    EXPECT_LE(walk.next(), 2e-3);
    EXPECT_GT(walk.next(), 0.9e-3);
    const double largest = walk.curve().norm.largest_motion(), c = 1 / (largest * largest), cosine = (c - 1) / (c + 1);
    EXPECT_NEAR(walk.kinks[0], std::acos(cosine), 1e-9);
  }
}

TEST(Steps, a_leg_may_be_refused_or_end_the_curve) {
  for (const Outcome answer : {Outcome::refused, Outcome::ended}) {
    Watched walk(hairpin(3), 3);
    walk.begin({-1}, -3, 1);
    walk.at_kinks = answer;
    Outcome last = Outcome::on;
    while (last == Outcome::on) last = walk.step();
    EXPECT_EQ(last, Outcome::ended);
    EXPECT_EQ(walk.no_steps, answer == Outcome::refused);
    EXPECT_EQ(walk.kinks.size(), answer == Outcome::ended ? 1u : 0u);
    EXPECT_LT(walk.points.back()[0], 0);
  }
}

// Ends of steps that are kept are taken as they are, unless they lie behind, or on nothing that hangs together.
TEST(Steps, that_are_kept_come_first) {
  for (const double angle : {0.2, -0.2, 2.5}) {
    Watched walk(circle(), 1);
    walk.begin({1}, 0, 1);
    walk.curve().norm.see(walk.here().y);
    CurvePoint kept = walk.curve().point();
    check(VecSetValue(kept.y, 0, std::cos(angle), INSERT_VALUES), "");
    check(VecAssemblyBegin(kept.y), ""), check(VecAssemblyEnd(kept.y), "");
    ASSERT_TRUE(walk.curve().solve_at(std::sin(angle), kept));
    check(VecScale(kept.t, 2.5), ""); // of another length by now
    const auto y = values(kept.y);
    walk.ahead().push_back(std::move(kept));
    const double next = walk.next();
    ASSERT_EQ(walk.step(), Outcome::on);
    EXPECT_EQ(walk.told, 1);
    EXPECT_TRUE(walk.ahead().empty());
    EXPECT_EQ(walk.points.back() == y, angle == 0.2);
    EXPECT_NEAR(walk.steps.back().length, angle == 0.2 ? std::sin(0.2) : next, 1e-9);
    EXPECT_NEAR(std::hypot(values(walk.here().t)[0], values(walk.here().t)[1]), 1, 1e-9);
  }
}

TEST(Steps, that_are_kept_may_end_the_curve) {
  Watched walk(circle(), 1);
  walk.begin({1}, 0, 1);
  CurvePoint kept = across(walk.curve(), walk.here(), 0.2);
  walk.ahead().push_back(std::move(kept));
  walk.answer = Outcome::ended;
  EXPECT_EQ(walk.step(), Outcome::ended);
  EXPECT_EQ(walk.guesses.size(), 1u);
  EXPECT_EQ(walk.told, 0);
}

// To the last bit, from what is saved, the point, and the one before.
TEST(Steps, go_on_as_they_would_have_from_an_archive) {
  Watched one(circle(), 1, 1e-7), other(circle(), 1, 1e-7);
  one.begin({1}, 0, 1), other.begin({1}, 0, 1);
  int taken = 0;
  for (; taken < 7 || !one.ahead().empty(); ++taken) ASSERT_EQ(one.step(), Outcome::on);
  Archive saved;
  one.save(saved);
  check(VecCopy(one.here().y, other.here().y), ""), check(VecCopy(one.here().t, other.here().t), "");
  other.here().parameter = one.here().parameter;
  other.remember(*one.before());
  other.curve().norm.see(one.here().y);
  Archive reading(saved.fields());
  other.here().sign = 0, other.here().newton.newton = -1;
  other.save(reading);
  EXPECT_EQ(other.here().sign, one.here().sign);
  EXPECT_EQ(other.here().newton.newton, one.here().newton.newton);
  EXPECT_EQ(other.next(), one.next());
  EXPECT_EQ(plain_length(other.here().t), plain_length(one.here().t));
  Archive again;
  other.save(again);
  EXPECT_EQ(again.fields().numbers, saved.fields().numbers);
  EXPECT_NE(saved.fields().numbers[3], 0); // the curvature
  EXPECT_NEAR(saved.fields().numbers[3], 1, 0.1);
}
