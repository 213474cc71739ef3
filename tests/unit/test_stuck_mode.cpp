// Where nonlinear modes begin: a mass on one contact point, whose modes and events are in closed form.
#include <gtest/gtest.h>

#include <cmath>

#include "harmonic/stuck_mode.hpp"
#include "support/error.hpp"

using namespace dovetail;

namespace {

constexpr double N = 10;
constexpr std::array<double, 3> ground{1, 4, 9};

// A mass of 1 on springs to the ground, with its point at rest as given.
StuckMode mode_of(const ContactPoint &point, const Standstill &at, const ModeWish &wish,
                  const std::array<double, 3> &springs = ground) {
  PreloadedModel model;
  ReducedModel &reduced = model.reduced;
  reduced.comm = PETSC_COMM_WORLD, reduced.points = 1;
  reduced.own_points = own_share(reduced.comm, 1), reduced.own_modes = own_share(reduced.comm, 0);
  if (reduced.own_points.size() == 1) {
    reduced.kxx = {springs[0], 0, 0, 0, springs[1], 0, 0, 0, springs[2]};
    reduced.mxx = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    model.contact = {point}, model.standstill = {at};
  }
  Case study;
  study.mode = wish;
  study.given = {{"mode.number", "case.toml:3"}, {"mode.near", "case.toml:4"}};
  return stuck_mode(model, study);
}

ContactPoint point_of(Law law, double mu = 0.3) { return {law, 50, {20, 30}, {mu, mu}, 0.05}; }
Standstill pressed_with(double t1, double t2) { return {{0, 0, 0.05 + N / 50}, {t1, t2, N}, {}}; }

void expect_onset(const StuckMode &mode, double amplitude, const std::string &what, bool straight = true) {
  if (std::isinf(amplitude)) {
    EXPECT_EQ(mode.onset.amplitude, amplitude);
  } else {
    EXPECT_NEAR(mode.onset.amplitude, amplitude, 1e-9);
    EXPECT_EQ(mode.onset.point, 1);
  }
  EXPECT_EQ(mode.onset.what, what);
  EXPECT_EQ(mode.straight, straight);
}

} // namespace

TEST(StuckMode, slips_where_friction_is_used_up_on_the_nearer_side) {
  const ContactPoint point = point_of(Law::coulomb);
  for (const double sense : {1.0, -1.0}) {
    const StuckMode mode = mode_of(point, pressed_with(sense * 1, 0), {1});
    EXPECT_NEAR(mode.omega, std::sqrt(1 + 20), 1e-12);
    EXPECT_NEAR(mode.largest, 1, 1e-12);
    expect_onset(mode, (0.3 * N - 1) / 20, "slips");
    expect_onset(mode_of(point, pressed_with(0, sense * 2), {2}), (0.3 * N - 2) / 30, "slips");
    expect_onset(mode_of(point, pressed_with(sense * 3, 0), {1}), 2 * 0.3 * N / 20, "slips", false);    // at its bound
    expect_onset(mode_of(point, pressed_with(sense * 1, 0), {3}), (0.3 * N - 1) / (0.3 * 50), "slips"); // as N sways
  }
}

TEST(StuckMode, without_friction_it_lifts_off_or_nothing_happens) {
  for (const ContactPoint &point : {point_of(Law::coulomb, 0), point_of(Law::unilateral)}) {
    const StuckMode aside = mode_of(point, pressed_with(0, 0), {1}), away = mode_of(point, pressed_with(0, 0), {3});
    EXPECT_NEAR(away.omega, std::sqrt(9 + 50), 1e-12);
    expect_onset(away, N / 50, "lifts off");
    if (point.mu[0] == 0) {
      EXPECT_NEAR(aside.omega, 1, 1e-12);
    }
    EXPECT_EQ(aside.onset.amplitude, INFINITY);
  }
  expect_onset(mode_of(point_of(Law::bilateral), pressed_with(0, 0), {3}), INFINITY, "");
}

TEST(StuckMode, an_open_point_closes) {
  const Standstill open{{0, 0, -0.1}, {0, 0, 0}, {}};
  for (const Law law : {Law::coulomb, Law::cone, Law::unilateral}) {
    const StuckMode mode = mode_of(point_of(law), open, {3});
    EXPECT_NEAR(mode.omega, 3, 1e-12);
    expect_onset(mode, 0.05 + 0.1, "closes");
    EXPECT_EQ(mode_of(point_of(law), open, {1}).onset.amplitude, INFINITY);
  }
}

TEST(StuckMode, a_cone_slips_where_its_friction_is_as_long_as_it_may_be) {
  const ContactPoint point = point_of(Law::cone);
  for (const double sense : {1.0, -1.0}) {
    expect_onset(mode_of(point, pressed_with(sense * 1, 2), {1}), (std::sqrt(5) - 1) / 20, "slips");
    expect_onset(mode_of(point, pressed_with(sense * 1, 2), {3}), (N - std::sqrt(5) / 0.3) / 50, "slips");
    EXPECT_FALSE(mode_of(point, pressed_with(sense * 3, 0), {1}).straight);
  }
  expect_onset(mode_of(point_of(Law::cone, 0), pressed_with(0, 0), {3}), N / 50, "lifts off");
}

TEST(StuckMode, is_the_one_of_that_number_or_near_that_frequency) {
  const ContactPoint point = point_of(Law::coulomb);
  for (const auto &[near, number] : {std::pair{0.1, 1}, {5.1, 1}, {5.3, 2}, {6.7, 2}, {6.8, 3}, {100.0, 3}})
    EXPECT_EQ(mode_of(point, pressed_with(0, 0), {0, near}).number, number) << near;
  const Standstill open{{0, 0, -0.1}, {0, 0, 0}, {}};
  EXPECT_EQ(mode_of(point, open, {0, 0.1}, {0, 4, 9}).number, 2); // no rigid motion
  const auto refused = [&](const ModeWish &wish, const std::array<double, 3> &springs) {
    try {
      mode_of(point, open, wish, springs);
    } catch (const InputError &error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refused({4}, ground).find("case.toml:3: mode.number = 4: the structure has 3 modes"), std::string::npos);
  EXPECT_NE(refused({1}, {0, 4, 9}).find("case.toml:3: mode.number = 1: is a rigid motion"), std::string::npos);
  EXPECT_NE(refused({0, 1}, {0, 0, 0}).find("case.toml:4: mode.near: the structure has no mode"), std::string::npos);
}
