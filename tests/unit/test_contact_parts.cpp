// Small parts of contact, at their edges: the law at one instant, the table of parameters, work, waves all round.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "contact/activity.hpp"
#include "contact/contact_change.hpp"
#include "contact/fourier.hpp"
#include "contact/law_traits.hpp"
#include "contact/wave_transform.hpp"

using namespace dovetail;

TEST(LawAtOneInstant, edges_of_contact_and_of_sticking) {
  EXPECT_EQ(pressed(2.0, 3.0), 6);
  EXPECT_EQ(pressed(2.0, 0.0), 0);
  EXPECT_EQ(pressed(2.0, -3.0), 0);
  for (const double side : {1.0, -1.0}) {
    EXPECT_EQ(rubbed(side * 0.5, 1.0), side * 0.5);
    EXPECT_EQ(rubbed(side, 1.0), side);
    EXPECT_EQ(rubbed(side * 3, 2.0), side * 2);
    EXPECT_EQ(rubbed(side * 3, 0.0), 0);
    EXPECT_EQ(slips(side * 0.999, 1), 0);
    EXPECT_EQ(slips(side, 1), 0); // a slider that comes back to where it last slipped
    EXPECT_EQ(slips(side * (1 + 1e-13), 1), 0);
    EXPECT_EQ(slips(side * (1 + 1e-11), 1), side);
    EXPECT_EQ(slips(side * 1e-30, 0), side);
  }
}

TEST(LawAtOneInstant, the_cone_draws_back_along_the_trial) {
  std::array<double, 2> T{3, -4}, e{};
  EXPECT_DOUBLE_EQ(drawn_back(10, T, e), 2);
  EXPECT_DOUBLE_EQ(T[0], 6);
  EXPECT_DOUBLE_EQ(T[1], -8);
  EXPECT_DOUBLE_EQ(e[0], 0.6);
  EXPECT_DOUBLE_EQ(e[1], -0.8);
  EXPECT_EQ(drawn_back(0, T, e), 0);
  EXPECT_EQ(T, (std::array<double, 2>{0, 0}));
  EXPECT_EQ(drawn_back(1, T, e), 0);
  EXPECT_EQ(e, (std::array<double, 2>{0, 0}));
}

TEST(LawAtOneInstant, at_a_standstill_that_touches_pulls_or_is_open) {
  const double touching[] = {0.5, -0.25, 0.1}, open[] = {0.5, -0.25, 0.05};
  for (const Law law : {Law::coulomb, Law::cone, Law::unilateral, Law::bilateral}) {
    const ContactPoint point{law, 5, {3, 4}, {0.2, 0.2}, 0.1};
    const bool rubs = has_friction(law);
    const StaticForce here = static_force(point, touching), there = static_force(point, open);
    for (int d = 0; d < 3; ++d)
      for (int e = 0; e < 3; ++e) {
        EXPECT_EQ(here.slope[d][e], d != e ? 0 : d == 2 ? 5 : rubs ? point.kt[d] : 0);
        EXPECT_EQ(there.slope[d][e], law == Law::bilateral && d == 2 && e == 2 ? 5 : 0);
      }
    EXPECT_EQ(here.force, (std::array<double, 3>{}));
    EXPECT_EQ(there.force, (std::array<double, 3>{0, 0, law == Law::bilateral ? 5 * (0.05 - 0.1) : 0}));
    EXPECT_EQ(here.w, (rubs ? Memory{0.5, -0.25} : Memory{}));
    EXPECT_EQ(there.w, (rubs ? Memory{0.5, -0.25} : Memory{}));
  }
}

TEST(Laws, what_is_asked_of_them) {
  EXPECT_TRUE(may_open(Law::coulomb) && may_open(Law::cone) && may_open(Law::unilateral) && !may_open(Law::bilateral));
  EXPECT_TRUE(shares_slider(Law::cone) && !shares_slider(Law::coulomb) && !shares_slider(Law::unilateral));
  for (const Law law : {Law::coulomb, Law::unilateral}) {
    const double kt = law == Law::coulomb;
    EXPECT_EQ(stuck_springs({law, 5, {3, 4}, {1, 1}, 0}), (std::array<double, 3>{3 * kt, 4 * kt, 5}));
  }
  EXPECT_EQ(enough_samples(0), 256);
  EXPECT_EQ(enough_samples(6), 256);
  EXPECT_EQ(enough_samples(7), 512);
  EXPECT_EQ(enough_samples(13), 1024);
}

TEST(Parameters, each_sets_its_own_numbers_and_no_other) {
  const auto numbers = [](const Setting &s) {
    return std::vector<double>{s.omega,
                               s.load,
                               s.preload,
                               s.damping,
                               s.contact.normal_stiffness,
                               s.contact.tangential_stiffness[0],
                               s.contact.tangential_stiffness[1],
                               s.contact.friction[0],
                               s.contact.friction[1],
                               s.contact.gap};
  };
  const std::map<std::string, std::set<int>> sets = {{"frequency", {0}},
                                                     {"force", {1}},
                                                     {"preload", {2}},
                                                     {"damping", {3}},
                                                     {"normal_stiffness", {4}},
                                                     {"tangential_stiffness", {5, 6}},
                                                     {"tangential_stiffness_1", {5}},
                                                     {"tangential_stiffness_2", {6}},
                                                     {"friction", {7, 8}},
                                                     {"friction_1", {7}},
                                                     {"friction_2", {8}},
                                                     {"gap", {9}}};
  const std::vector<double> usual = numbers({});
  EXPECT_EQ(usual, (std::vector<double>{0, 1, 1, 1, 1, 1, 1, 1, 1, 0}));
  ASSERT_EQ(all_parameters.size(), sets.size());
  for (const auto &[name, which] : sets) {
    const PathParameter *parameter = parameter_named(name);
    ASSERT_TRUE(parameter) << name;
    EXPECT_EQ(parameter->name, name);
    Setting setting;
    parameter->set(setting, 7);
    for (int i = 0; i < 10; ++i) EXPECT_EQ(numbers(setting)[i], which.count(i) ? 7 : usual[i]) << name;
    const bool of_points = *which.begin() >= 4;
    EXPECT_EQ(parameter->changes_joint, of_points || name == "preload") << name;
    EXPECT_EQ(has_points(*parameter), of_points) << name;
    EXPECT_EQ(parameter->changes_damping, name == "damping") << name;
    EXPECT_EQ(parameter->positive(), name != "gap") << name;
    EXPECT_STREQ(parameter->unit, name == "gap" ? "m" : name == "frequency" ? "rad/s" : "-");
    EXPECT_EQ(parameter->scale == PathParameter::Scale::frequency, name == "frequency");
  }
  EXPECT_EQ(&frequency_parameter(), parameter_named("frequency"));
  EXPECT_EQ(parameter_named("mass"), nullptr);
}

TEST(Parameters, change_a_point_and_move_it) {
  Setting::Contact by{2, {3, 5}, {7, 11}, -0.5};
  const ContactPoint point = changed({Law::cone, 5, {3, 4}, {0.25, 0.5}, 0.125}, by);
  EXPECT_EQ(point.law, Law::cone);
  EXPECT_EQ(point.kn, 10);
  EXPECT_EQ(point.gap, -0.375);
  EXPECT_EQ(point.kt, (std::array<double, 2>{9, 20}));
  EXPECT_EQ(point.mu, (std::array<double, 2>{1.75, 5.5}));
  const EquivalentMotion motion({2, {4, 5}, {8, 10}, 1}, {6, {8, 20}, {4, 30}, 3}), none;
  EXPECT_EQ(motion.all, (std::array<double, 3>{2, 4, 3}));
  EXPECT_EQ(motion.friction, (std::array<double, 2>{0.5, 3}));
  EXPECT_EQ(motion.closing, -3);
  EXPECT_EQ(none.closing, 0);
}

TEST(Dissipation, is_the_integral_of_force_times_velocity) {
  constexpr int harmonics = 2, n = 5;
  for (int d = 0; d < 3; ++d) {
    double X[3 * n] = {}, G[3 * n] = {};
    X[d * n] = 9, G[d * n] = 9;                          // means do no work
    X[d * n + cosine(1)] = 2, G[d * n + sine(1)] = 3;    // 3 sin d(2 cos): -6 pi
    X[d * n + sine(2)] = 5, G[d * n + cosine(2)] = 7;    // 7 cos 2 d(5 sin 2): 70 pi
    G[d * n + cosine(1)] = 11, X[d * n + cosine(2)] = 4; // in phase, or without partner
    EXPECT_NEAR(dissipation(harmonics, X, G), M_PI * 64, 1e-12) << d;
  }
}

TEST(WaveTransform, is_the_sum_of_waves_and_of_their_slopes) {
  for (const auto &[harmonics, samples] : {std::pair{0, 1}, {1, 3}, {3, 16}, {7, 15}}) {
    WaveTransform transform(harmonics, samples);
    for (const double shift : {0.0, 1.0}) { // twice: FFTW writes over what it was given
      std::vector<double> c, value(samples), slope(samples);
      for (int i = 0; i < coefficient_count(harmonics); ++i) c.push_back(std::sin(1 + shift + 2.3 * i));
      transform.sample(c.data(), value.data(), slope.data());
      for (int j = 0; j < samples; ++j) {
        double sum = c[0] / 2, of_slopes = 0;
        for (int k = 1; k <= harmonics; ++k) {
          const double a = 2 * M_PI * j * k / samples;
          sum += c[cosine(k)] * std::cos(a) + c[sine(k)] * std::sin(a);
          of_slopes += k * (c[sine(k)] * std::cos(a) - c[cosine(k)] * std::sin(a));
        }
        EXPECT_NEAR(value[j], sum, 1e-13);
        EXPECT_NEAR(slope[j], of_slopes, 1e-12);
      }
    }
  }
}
