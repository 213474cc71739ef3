// Where within a step something happens, on curves in closed form.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "continuation/event_locator.hpp"
#include "told_solves.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr double tolerance = 1e-11;

double rate(CurvePoint &s) { return parameter_of(s.t); }

void put(Vec v, double x, double p) {
  check(VecSetValue(v, 0, x, INSERT_VALUES), "");
  check(VecAssemblyBegin(v), ""), check(VecAssemblyEnd(v), "");
  set_parameter(v, p);
}

} // namespace

TEST(EventLocator, finds_the_fold_of_a_circle) {
  SmallCurve scene(circle(), 1);
  const CurvePoint here = scene.at(0.3, std::sqrt(1 - 0.09)), there = scene.on(here, 0.5);
  const EventLocator locator(scene.curve, here, there, tolerance);
  const double from = parameter_of(here.t), to = parameter_of(there.t);
  ASSERT_LT(from * to, 0);
  const auto found = locator.between(here.t, {0, here.y, from}, {0.5, there.y, to}, rate);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->at.parameter, 1, 1e-12);
  EXPECT_NEAR(values(found->at.y)[0], 0, 1e-7);
  EXPECT_GT(found->along, 0);
  EXPECT_LT(found->along, 0.5);
}

// The legs p = -3 |x| meet in a fold: planes across either leg may miss the other.
TEST(EventLocator, finds_a_fold_in_a_kink) {
  SmallCurve scene(hairpin(3), 1);
  const CurvePoint here = scene.at(-0.1, -0.3);
  CurvePoint there = scene.at(0.05, -0.15);
  turn(there); // the curve comes back
  const EventLocator locator(scene.curve, here, there, tolerance);
  for (const double step : {1.0, 0.3}) {
    const auto found = locator.in_kink(step, {parameter_of(here.t), parameter_of(there.t)}, rate);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->at.parameter, 0, 1e-7);
    EXPECT_NEAR(found->along, step * 0.1 / 0.15, 1e-7); // that part of the step
  }
}

// The legs meet at (0, 0.3); on the plane across them there is only the line x = 3.
TEST(EventLocator, finds_nothing_of_another_branch_in_a_kink) {
  SmallCurve scene(one([](double x, double) { return x - 3; }, [](double, double) { return 1.0; },
                       [](double, double) { return 0.0; }),
                   1);
  CurvePoint here = scene.curve.point(), other = scene.curve.point();
  put(here.t, 0, 1), put(other.y, 0.4, 0.3), put(other.t, 1, 0);
  const EventLocator locator(scene.curve, here, other, tolerance);
  EXPECT_FALSE(locator.in_kink(1, {1, -1}, [](CurvePoint &) { return 0.5; }));
}

TEST(EventLocator, tells_a_crossing_branch_from_a_hairpin) {
  SmallCurve crossing(pitchfork(), 2);
  const CurvePoint here = crossing.at(0, -0.07), there = crossing.on(here, 0.1);
  const EventLocator at_branch(crossing.curve, here, there, tolerance);
  EXPECT_TRUE(at_branch.leads_back(0.1, 1e-3));
  const auto found = at_branch.branch_point(0.1);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->at.parameter, 0, 1e-5);

  SmallCurve folded(hairpin(30), 30);
  const CurvePoint leg = folded.at(-0.1, -3), other = folded.at(0.09, -2.7);
  EXPECT_FALSE(EventLocator(folded.curve, leg, other, tolerance).leads_back(0.1, 1e-3));
}

// Other branches cross where one would look first.
TEST(EventLocator, finds_the_crossing_that_no_point_between_hides) {
  const std::vector<double> crossings{0, -0.5 + 0.3, 0.4};
  const auto product = [crossings](double x, double p, double of_each) {
    double value = 1;
    for (const double at : crossings) value *= p - at - of_each * x * x;
    return value;
  };
  SmallCurve scene(one([=](double x, double p) { return x * product(x, p, 1); },
                       [=](double, double p) { return product(0, p, 1); }, [](double, double) { return 0.0; }),
                   1);
  const CurvePoint here = scene.at(0, -0.5), there = scene.on(here, 1);
  const auto found = EventLocator(scene.curve, here, there, tolerance).branch_point(1);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->at.parameter, 0.4, 1e-7);
  EXPECT_NEAR(found->along, 0.9, 1e-7);
}

TEST(Meeting, is_where_lines_along_tangents_are_closest) {
  SmallCurve scene(circle(), 1);
  CurvePoint here = scene.curve.point(), other = scene.curve.point();
  const auto met = [&](double turned, double ahead, double back) { // at (0, ahead)
    put(here.y, 0, 0), put(here.t, 0, 1);
    put(other.t, std::sin(turned), std::cos(turned));
    put(other.y, back * std::sin(turned), ahead + back * std::cos(turned));
    return meeting(scene.curve, here, other);
  };
  for (const double ahead : {0.25, 3.0})
    for (const double back : {0.5, -2.0}) {
      const Meeting at = met(1.1, ahead, back);
      EXPECT_NEAR(at.ahead, ahead, 1e-12);
      EXPECT_NEAR(at.back, back, 1e-12);
      EXPECT_NEAR(at.miss, 0, 1e-12);
    }
  EXPECT_NEAR(met(0.033, 0.5, 2).ahead, 0.5, 1e-9);                          // the square of its sine is 1.09e-3
  for (const auto &[turned, ahead] : {std::pair{1.1, -0.5}, {0.031, 0.5}}) { // behind here, or too slim an angle
    const Meeting at = met(turned, ahead, 2);
    EXPECT_EQ(at.ahead, 0);
    EXPECT_NEAR(at.back, 2 + ahead * std::cos(turned), 1e-12);
    EXPECT_NEAR(at.miss, std::abs(ahead * std::sin(turned)), 1e-12); // from here to the other line
  }
}

namespace {

// The line x = 2, along which p is the arc length.
Equations upright() {
  return one([](double x, double) { return x - 2; }, [](double, double) { return 1.0; },
             [](double, double) { return 0.0; });
}

} // namespace

TEST(EventLocator, finds_zeros_of_any_function_in_few_solves) {
  struct Searched {
    std::function<double(double)> f;
    double zero;
    std::size_t most; // solves: halving alone takes 27
  };
  const Searched all[] = {
      {[](double p) { return 3 * (p - 0.3); }, 0.3, 1},
      {[](double p) { return std::exp(9 * p) - 5; }, std::log(5) / 9, 10},
      {[](double p) { return 5 - std::exp(9 * p); }, std::log(5) / 9, 10},
      {[](double p) { return std::tanh(20 * (p - 0.6)) + 0.1 * (p - 0.6); }, 0.6, 10},
      {[](double p) { return p < 0.7 ? -1.0 : 1e3; }, 0.7, 30},
      {[](double p) { return p < 0.123 ? -1e3 : 1.0; }, 0.123, 30},
      {[](double p) { return p < 0.3 ? -1.0 : 1.0; }, 0.3, 30},
      {[](double p) { return std::max(p - 0.35, 40 * (p - 0.35)); }, 0.35, 30},
      {[](double p) { return std::pow(p - 0.4, 3); }, 0.4, 30},
  };
  for (const auto &[f, zero, most] : all)
    for (const double from : {0.0, -0.5})
      for (const double newton : {1e-11, 1e-4}) {
        ToldProblem problem(upright());
        SolveCounts counts;
        Curve curve(problem, {1e-11, 1e-12, 30}, 1, false, counts);
        const CurvePoint here = curve.point(), there = curve.point();
        put(here.y, 2, from), put(here.t, 0, 1), put(there.y, 2, 1), put(there.t, 0, 1);
        std::vector<double> found;
        const auto place = EventLocator(curve, here, there, newton)
                               .between(here.t, {from, here.y, f(from)}, {1, there.y, f(1)}, [&](CurvePoint &s) {
                                 found.push_back(s.parameter);
                                 return f(s.parameter);
                               });
        ASSERT_TRUE(place);
        const double least = std::max(1e-8, newton), largest = std::max(std::abs(f(from)), std::abs(f(1))),
                     apart = std::abs(found.back() - zero);
        EXPECT_TRUE(apart <= least * (1 - from) || std::abs(f(found.back())) <= least * largest)
            << zero << " " << apart;
        EXPECT_LE(found.size(), most) << zero << " from " << from;
        EXPECT_NEAR(place->along, found.back(), 1e-9);
        EXPECT_EQ(place->at.parameter, found.back());
        EXPECT_EQ(std::count(problem.told.asked.begin(), problem.told.asked.end(), 1e-10),
                  counts.inexact - counts.newton);
        problem.told.asked.clear();
        across(curve, here, 0.1);
        EXPECT_EQ(problem.told.asked.back(), 1e-6); // as usual again
      }
}

TEST(EventLocator, ends_where_rounding_errors_are_all_that_is_left) {
  for (double noise = 1e-7; noise > 1e-9; noise /= 1.7) {
    SmallCurve scene(upright(), 1);
    const CurvePoint here = scene.curve.point(), there = scene.curve.point();
    put(here.y, 2, 0), put(there.y, 2, 1);
    put(here.t, 0, 1);
    int solves = 0;
    const auto f = [&](double p) { return std::sin(p) - 0.3 + noise * std::sin(1e11 * p); };
    const auto place = EventLocator(scene.curve, here, there, tolerance)
                           .between(here.t, {0, here.y, f(0)}, {1, there.y, f(1)}, [&](CurvePoint &s) {
                             ++solves;
                             return f(s.parameter);
                           });
    ASSERT_TRUE(place);
    EXPECT_NEAR(place->along, std::asin(0.3), 3 * noise + 1e-8);
    EXPECT_LE(solves, 8) << noise;
  }
}

// Places on a circle, guessed on the chord or on the cubic by the tangents.
TEST(EventLocator, tangents_spare_iterations) {
  long spent[2];
  for (const bool known : {false, true}) {
    SmallCurve scene(circle(), 1);
    const CurvePoint here = scene.at(0.3, std::sqrt(1 - 0.09)), there = scene.on(here, 0.5);
    const long before = scene.counts.newton;
    const auto found = EventLocator(scene.curve, here, there, tolerance)
                           .between(here.t, {0, here.y, parameter_of(here.t), known ? Vec(here.t) : nullptr},
                                    {0.5, there.y, parameter_of(there.t), known ? Vec(there.t) : nullptr}, rate);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->at.parameter, 1, 1e-12);
    spent[known] = scene.counts.newton - before;
  }
  EXPECT_LT(spent[1], spent[0]);
}

TEST(EventLocator, finds_nothing_where_newton_fails) {
  ToldProblem problem(upright());
  SolveCounts counts;
  Curve curve(problem, {1e-11, 1e-12, 30}, 1, false, counts);
  const CurvePoint here = curve.point(), there = curve.point();
  put(here.y, 2, 0), put(here.t, 0, 1), put(there.y, 2, 1), put(there.t, 0, 1);
  problem.told.fail_at = 0, problem.told.fail_until = 1000;
  const EventLocator locator(curve, here, there, tolerance);
  EXPECT_FALSE(locator.between(here.t, {0, here.y, -1}, {1, there.y, 1}, [](CurvePoint &s) { return s.parameter; }));
  EXPECT_FALSE(locator.leads_back(1, 1));
  EXPECT_FALSE(locator.branch_point(1));
}

// Legs that meet at (0, 0); planes across the sum of both tangents are those of equal x. Zero before, at or behind it.
TEST(EventLocator, finds_what_passes_zero_on_either_leg_of_a_kink) {
  SmallCurve scene(hairpin(3), 1);
  const CurvePoint here = scene.at(-0.1, -0.3);
  CurvePoint there = scene.at(0.05, -0.15);
  turn(there);
  for (const double sense : {1.0, -1.0})
    for (const double zero : {-0.07, 0.02}) {
      const auto f = [&](CurvePoint &s) { return sense * (values(s.y)[0] - zero); };
      const auto found = EventLocator(scene.curve, here, there, tolerance)
                             .in_kink(0.3, {sense * (-0.1 - zero), sense * (0.05 - zero)}, f);
      ASSERT_TRUE(found) << zero;
      EXPECT_NEAR(values(found->at.y)[0], zero, 1e-8);
      EXPECT_NEAR(found->along, 0.3 * (zero + 0.1) / 0.15, 1e-7);
    }
}

// Nor what is twice as far from the kink as here, where another branch may be; nor where the legs meet behind here.
TEST(EventLocator, finds_nothing_far_from_a_kink) {
  SmallCurve scene(hairpin(3), 1);
  const CurvePoint here = scene.at(-0.01, -0.03);
  CurvePoint there = scene.at(0.5, -1.5);
  turn(there);
  for (const auto &[zero, finds] : {std::pair{0.0198, true}, {0.0202, false}}) {
    const double x0 = zero;
    const auto f = [x0](CurvePoint &s) { return values(s.y)[0] - x0; };
    EXPECT_EQ(EventLocator(scene.curve, here, there, tolerance).in_kink(1, {-0.01 - x0, 0.5 - x0}, f).has_value(),
              finds);
  }
  CurvePoint behind = scene.curve.point();
  put(behind.y, -0.05, 0), put(behind.t, 1, 0); // its line meets here's at (0, 0) only
  CurvePoint from = scene.at(0.01, -0.03);
  turn(from);
  EXPECT_FALSE(
      EventLocator(scene.curve, from, behind, tolerance).in_kink(1, {-1, 1}, [](CurvePoint &) { return 1.0; }));
}

// A point 2 % of the way ahead of where the way back ends, and beside it.
TEST(EventLocator, a_way_leads_back_if_it_misses_a_tenth_of_a_correction_at_most) {
  SmallCurve scene(upright(), 1);
  const CurvePoint here = scene.curve.point(), there = scene.curve.point();
  put(here.t, 0, 1), put(there.y, 2, 0.1), put(there.t, 0, 1);
  for (const auto &[beside, missed, leads] : {std::tuple{0.9e-3, 1e-2, true},
                                              {1.1e-3, 1e-2, false},
                                              {0.9e-5, 0.0, true},
                                              {1.1e-5, 0.0, false},
                                              {0.0, 0.0, true}}) {
    put(here.y, 2 + beside, 0.002);
    EXPECT_EQ(EventLocator(scene.curve, here, there, tolerance).leads_back(0.1, missed), leads) << beside;
  }
}

// x = d and x = -d, from one to the other: as close as a thousandth of the step it counts as one that is crossed.
TEST(EventLocator, branches_beside_each_other_do_not_cross_unless_they_all_but_touch) {
  for (const auto &[d, finds] : {std::pair{0.45e-4, true}, {0.55e-4, false}}) {
    const double half = d;
    SmallCurve scene(one([half](double x, double) { return x * x - half * half; },
                         [](double x, double) { return 2 * x; }, [](double, double) { return 0.0; }),
                     1);
    const CurvePoint here = scene.at(half, 0), there = scene.at(-half, 0.1);
    const auto found = EventLocator(scene.curve, here, there, tolerance).branch_point(0.1);
    EXPECT_EQ(found.has_value(), finds);
  }
}

TEST(EventLocator, a_crossing_is_located_to_a_hundred_millionth_of_the_step) {
  SmallCurve scene(pitchfork(), 2);
  const double step = 0.1, from = -0.03;
  const CurvePoint here = scene.at(0, from), there = scene.on(here, step);
  const auto found = EventLocator(scene.curve, here, there, tolerance).branch_point(step);
  ASSERT_TRUE(found);
  const double rate = values(here.t)[1];
  EXPECT_NEAR(found->at.parameter, 0, 2e-9);
  EXPECT_NEAR(rate * found->along, -from, 2e-9);
  EXPECT_NEAR(found->at.parameter - from, rate * found->along, 1e-12);
}

TEST(Located, is_the_point_with_all_that_belongs_to_it) {
  SmallCurve scene(circle(), 1);
  CurvePoint s = scene.at(0.8, 0.6);
  s.data = std::make_shared<PointData>();
  const Located found = located_at(scene.curve, s, 0.25);
  EXPECT_EQ(found.along, 0.25);
  EXPECT_EQ(values(found.at.y), values(s.y));
  EXPECT_EQ(values(found.at.t), values(s.t));
  EXPECT_EQ(found.at.sign, 1);
  EXPECT_EQ(found.at.parameter, 0.6);
  EXPECT_EQ(found.at.newton.newton, s.newton.newton);
  EXPECT_TRUE(found.at.newton.converged);
  EXPECT_EQ(found.at.data, s.data);
}
