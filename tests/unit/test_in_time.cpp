// Curves that are followed in time have the turning points, maxima and changes of stability that harmonic balance finds
// with many harmonics.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "analyses/branch.hpp"
#include "one_mass.hpp"
#include "transient/steady_state.hpp"
#include "turning_point.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

// Pressed on, with a force across the contact.
HarmonicSystem pressed_mass(double force, double damping, int harmonics) {
  return one_mass({1, 1, 1}, {0, 0, -10}, {0, 0, force}, {Law::coulomb, 20, {10, 10}, {0.3, 0.3}, 0}, damping,
                  harmonics);
}

// Of a sweep, by kind.
std::vector<BranchEvent> events(HarmonicSystem &system, double from, double to, bool in_time, int &points_in_time) {
  const UniqueVec y = system.unknowns();
  BranchSettings settings;
  settings.from = from, settings.to = to, settings.step = 0.01, settings.max_points = 300;
  settings.in_time = in_time, settings.stability = true;
  std::vector<BranchEvent> all;
  const BranchObserver observer{
      [](const BranchPoint &) {}, [&](const BranchEvent &event) { all.push_back(event); }, {}, {}};
  const auto summary = follow_branch(system, {1e-10, 1e-11, 30}, settings, y, observer);
  EXPECT_EQ(summary.end, BranchSummary::End::arrived) << summary.why;
  points_in_time = summary.counts.in_time;
  return all;
}

BranchEvent nearest(const std::vector<BranchEvent> &events, BranchEvent::Kind kind, double omega) {
  BranchEvent found{kind, "", HUGE_VAL};
  for (const BranchEvent &event : events)
    if (event.kind == kind && std::abs(event.omega - omega) < std::abs(found.omega - omega)) found = event;
  return found;
}

} // namespace

TEST(InTime, places_are_those_of_harmonic_balance) {
  using Kind = BranchEvent::Kind;
  struct Known {
    Kind kind;
    double omega, accuracy;
  };
  struct {
    double force, damping;
    std::vector<Known> places;
  } models[] = {{15, 0.1, {{Kind::fold, 1.6724, 1e-8}, {Kind::peak, 1.6997, 3e-6}}},
                {25, 0.2, {{Kind::peak, 1.7075, 1e-5}, {Kind::stability, 1.2097, 3e-6}}}};
  for (const auto &model : models) {
    std::vector<BranchEvent> all[2];
    for (const bool in_time : {false, true}) {
      HarmonicSystem system = pressed_mass(model.force, model.damping, 50);
      int points;
      all[in_time] = events(system, 1.2, 30, in_time, points);
      EXPECT_EQ(points > 50, in_time);
    }
    for (const auto &[kind, omega, accuracy] : model.places) {
      const BranchEvent balanced = nearest(all[0], kind, omega), timed = nearest(all[1], kind, omega);
      EXPECT_NEAR(balanced.omega, omega, 1e-3);
      EXPECT_NEAR(timed.omega, balanced.omega, accuracy * omega);
      if (kind == Kind::peak) EXPECT_NEAR(timed.amplitude, balanced.amplitude, 1e-7 * balanced.amplitude);
    }
  }
}

// A hairpin by lift-off, round which harmonic balance goes as round a corner: the place does not depend on steps or
// harmonics, and is that of the motions in time.
TEST(InTime, turning_point_in_a_hairpin) {
  std::vector<double> found;
  for (const int harmonics : {20, 40})
    for (const double from : {4.6, 4.9}) {
      HarmonicSystem system = pressed_mass(1.3, 0.02, harmonics);
      int points;
      const std::vector<BranchEvent> all = events(system, from, 0.1, false, points);
      found.push_back(nearest(all, BranchEvent::Kind::fold, 4.277).omega);
      EXPECT_TRUE(
          std::any_of(all.begin(), all.end(), [](const auto &e) { return e.kind == BranchEvent::Kind::corner; }));
    }
  const DenseModel model = dense_model(pressed_mass(1.3, 0.02, 1));
  const SteadyState steady = steady_state(model, 3.9, {}, {.periods = 2000});
  OrbitCurve curve(model, 3.9, 1);
  ASSERT_TRUE(curve.begin(steady.end, 1));
  while (curve.here()->rises()) ASSERT_TRUE(curve.step());
  const OrbitCurve::PlacePtr place = turning_point(curve, 1e-8);
  ASSERT_TRUE(place);
  for (const double omega : found) EXPECT_NEAR(omega, curve.omega(*place), 1e-6 * omega);
}
