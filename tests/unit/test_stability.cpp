// What is said of the stability of a motion: closed forms, and the same from a distributed model on any number of
// ranks.
#include <gtest/gtest.h>

#include "linear_motion.hpp"
#include "stability/growth.hpp"
#include "stability/hill.hpp"
#include "stability/large_stability.hpp"
#include "stability/wave_system.hpp"
#include "support/error.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

using Kind = Stability::Kind;
using Verdict = Stability::Verdict;

constexpr ContactPoint point{Law::coulomb, 5, {3, 4}, {0.4, 0.3}, 0};

// Coefficients (n, 2H+1), n = 3 points, with random first harmonics.
std::vector<double> motion(const DenseModel &model, int harmonics, double amplitude, int seed = 1) {
  const int w = coefficient_count(harmonics);
  std::vector<double> q(static_cast<std::size_t>(model.dofs()) * w);
  for (int r = 0; r < model.dofs(); ++r)
    for (int i = 1; i < std::min(w, 5); ++i) q[r * w + i] = amplitude * wave(seed + i, r) / (i > 2 ? 4 : 1);
  return q;
}

// Largest real part of x'' + c x' + k x = 0.
double rate_of(double k, double c) { return c * c > 4 * k ? (std::sqrt(c * c - 4 * k) - c) / 2 : -c / 2; }

} // namespace

TEST(Stability, of_linear_motions_in_closed_form) {
  const double omega = 1.3, k = 2, xi = 0.04;
  DenseModel model = dense_scene({point}, k, 1, xi, 0);
  const Stability stuck = StabilityTest(model).judge(motion(model, 3, 1e-3), omega);
  EXPECT_EQ(stuck.verdict, Verdict::stable);
  EXPECT_EQ(stuck.kind, Kind::none);
  EXPECT_NEAR(stuck.growth, rate_of(k + point.kt[0], xi * k) / omega, 1e-10);
  EXPECT_NEAR(stuck.multiplier, std::exp(2 * M_PI * stuck.growth), 1e-12);

  model.contact[0].gap = 100; // open
  const Stability open = StabilityTest(model).judge(motion(model, 3, 0.5), omega);
  EXPECT_EQ(open.verdict, Verdict::stable);
  EXPECT_NEAR(open.growth, rate_of(k, xi * k) / omega, 1e-10);

  for (const int d : {0, 4, 8}) model.K[d] = -0.7; // what a negative stiffness drives away
  model.damping = 0;
  const Stability driven = StabilityTest(model).judge(motion(model, 3, 0.5), omega);
  EXPECT_EQ(driven.verdict, Verdict::unstable);
  EXPECT_EQ(driven.kind, Kind::jump);
  EXPECT_NEAR(driven.growth, std::sqrt(0.7) / omega, 1e-10);

  for (const int d : {0, 4, 8}) model.K[d] = k;
  model.damping = -0.03; // and a negative damping
  const Stability shaken = StabilityTest(model).judge(motion(model, 3, 0.5), omega);
  EXPECT_EQ(shaken.verdict, Verdict::unstable);
  EXPECT_EQ(shaken.kind, Kind::second_frequency);
  EXPECT_NEAR(shaken.growth, 0.03 * k / 2 / omega, 1e-10);

  model.damping = 0; // neither grows nor falls
  EXPECT_EQ(StabilityTest(model).judge(motion(model, 3, 0.5), omega).verdict, Verdict::uncertain);
}

// The same law, not coupled, without friction in use: whatever goes by samples is not needed there.
TEST(Stability, of_a_cone_that_sticks_and_one_that_slips) {
  DenseModel model = dense_scene({point, point}, 2, 1, 0.1, 0.05), cone = model;
  for (ContactPoint &c : cone.contact) c.law = Law::cone, c.mu[1] = c.mu[0];
  const Stability expected = StabilityTest(model).judge(motion(model, 4, 1e-3), 0.9);
  const Stability stuck = StabilityTest(cone).judge(motion(cone, 4, 1e-3), 0.9);
  EXPECT_EQ(stuck.verdict, Verdict::stable);
  EXPECT_NEAR(stuck.growth, expected.growth, 1e-10);
  StabilityTest slipping(cone);
  const Stability s = slipping.judge(motion(cone, 4, 0.6), 0.9);
  EXPECT_TRUE(std::isnan(slipping.opinions().by_monodromy));
  EXPECT_NEAR(s.growth, slipping.opinions().by_hill, 1e-14);
  EXPECT_EQ(s.verdict, Verdict::stable);
  for (double &k : cone.K) k *= 1e-3; // all but undamped: too close to 1 for a sampled derivative
  EXPECT_EQ(StabilityTest(cone).judge(motion(cone, 4, 0.4), 0.9).verdict, Verdict::uncertain);
}

// A body that nothing but friction holds, sliding to and fro: it may stand anywhere, which is no instability.
TEST(Stability, of_a_body_held_by_its_joint_alone) {
  DenseModel model = dense_scene({point}, 0, 1, 0.3, 0);
  model.K[8] = 1;
  std::vector<double> q = motion(model, 4, 0.0);
  q[1] = 2, q[10] = 1.5, q[19] = 0.1; // both ways round its sliders
  StabilityTest test(model);
  const Stability s = test.judge(q, 0.7);
  EXPECT_EQ(s.verdict, Verdict::stable);
  EXPECT_LT(s.multiplier, 0.99);
  EXPECT_LT(test.opinions().by_hill, -1e-3);
}

// Hill's method with sliders that remember nothing would be off by 2e-4 and 6e-4.
TEST(Stability, of_sliders_that_remember_by_both_methods) {
  const DenseModel model = dense_scene({point, point, point}, 2, 1, 0.01, 0.05);
  StabilityTest test(model);
  for (const auto &[amplitude, accuracy] : {std::pair(0.3, 2e-5), {1.2, 2e-4}}) {
    EXPECT_EQ(test.judge(motion(model, 6, amplitude), 0.9).verdict, Verdict::stable);
    EXPECT_NEAR(test.opinions().by_hill, test.opinions().by_monodromy, accuracy);
  }
}

TEST(Stability, is_uncertain_where_methods_disagree) {
  const Growth falls{-0.02, Kind::jump}, grows{0.01, Kind::period_doubling}, unknown;
  EXPECT_EQ(conclude(falls, falls, true).verdict, Verdict::stable);
  EXPECT_EQ(conclude(grows, grows, false).verdict, Verdict::unstable);
  EXPECT_EQ(conclude(falls, unknown, true).verdict, Verdict::stable);
  EXPECT_EQ(conclude(falls, unknown, false).verdict, Verdict::uncertain);
  EXPECT_EQ(conclude(unknown, grows, false).verdict, Verdict::uncertain);
  EXPECT_EQ(conclude(unknown, unknown, true).verdict, Verdict::uncertain);
  const Stability one = conclude(falls, grows, true), other = conclude(falls, grows, false);
  EXPECT_EQ(one.verdict, Verdict::uncertain);
  EXPECT_EQ(one.growth, falls.value);
  EXPECT_EQ(one.kind, Kind::period_doubling); // what it may be
  EXPECT_EQ(other.verdict, Verdict::uncertain);
  EXPECT_EQ(other.growth, grows.value);
}

namespace {

constexpr int harmonics = 4;

HarmonicSystem small_system(Law law, const Damping &damping = 0.05, int order = harmonics) {
  PreloadedModel model = small_preloaded(PETSC_COMM_WORLD);
  add_damping_matrices(damping, model.reduced);
  for (ContactPoint &c : model.contact) {
    c.law = law;
    if (law == Law::cone) c.mu[1] = c.mu[0];
  }
  return HarmonicSystem(scaled(std::move(model), damping, {}), order, exactly, course({0, 1, 0}));
}

UniqueVec point_of(const HarmonicSystem &system, const std::vector<double> &q, double omega) {
  UniqueVec y = system.unknowns();
  set_coefficients(system.layout(), q, y);
  double *own;
  check(VecGetArray(y, &own), "");
  if (system.layout().owns_omega()) own[system.layout().own_coefficients()] = omega;
  check(VecRestoreArray(y, &own), "");
  return y;
}

} // namespace

TEST(LargeStability, agrees_with_the_dense_computation) {
  int unstable = 0;
  for (const Law law : {Law::coulomb, Law::unilateral})
    for (const double amplitude : {0.3, 1.2})
      for (int kind = 0; kind < 5; ++kind) {
        const double by_stiffness[] = {0.05, -0.04, 0.02, -0.04, 0};
        Damping damping(by_stiffness[kind], kind == 2 ? 0.05 : 0);
        damping.matrix = kind >= 3; // full, and all blocks of it
        if (kind == 4) damping.ratios = {{1, 0.03}, {5, 0.01}, {2, 0.002}};
        const double omega = 0.8;
        const HarmonicSystem system = small_system(law, damping);
        const DenseModel model = dense_model(system);
        std::vector<double> q = motion(model, harmonics, amplitude);
        const UniqueVec y = point_of(system, q, omega);
        const Stability found = LargeStabilityTest(system).judge(y);

        ContactReading reading(model, harmonics);
        reading.read(q);
        Hill hill(model);
        Growth expected[2];
        for (const Waves waves : {Waves::whole, Waves::half}) {
          hill.assemble(waves, harmonics, omega, reading.answers(waves, harmonics, exponent_shift),
                        reading.history().holds);
          expected[waves == Waves::half] = largest_of(hill.near_zero().values, waves);
        }
        const Stability dense = conclude_alone(larger(expected[0], expected[1]), 1e-7);
        EXPECT_EQ(found.verdict, dense.verdict);
        EXPECT_EQ(found.kind, dense.kind);
        EXPECT_NEAR(found.growth, dense.growth, 3e-6) << "amplitude " << amplitude << ", damping " << damping.stiffness;
        unstable += found.verdict == Verdict::unstable;
      }
  EXPECT_GT(unstable, 1);
}

// All multipliers, of either sign and off the real axis, go to those of the map with the harmonics of what is small.
TEST(LargeStability, knows_what_sliders_remember) {
  using Complex = std::complex<double>;
  const int many = 18;
  int unstable = 0, positive = 0, negative = 0;
  for (const double damping : {0.05, -0.04})
    for (const auto &[amplitude, omega] : {std::pair(0.3, 0.8), {1.2, 1.3}, {2.4, 0.5}}) {
      const HarmonicSystem system = small_system(Law::coulomb, damping, many);
      const DenseModel model = dense_model(system);
      ContactReading all(model, many);
      const std::vector<double> q = motion(model, many, amplitude);
      all.read(q);
      ASSERT_GT(all.history().holds.size(), 6u);
      const std::vector<Complex> expected = Monodromy(model).multipliers(all.history(), omega);

      const UniqueVec y = point_of(system, q, omega);
      const Stability found = LargeStabilityTest(system).judge(y);
      const Growth growth = largest_of(expected);
      EXPECT_NEAR(found.growth, growth.value, 6e-4);
      EXPECT_EQ(found.verdict, growth.positive() ? Verdict::unstable : Verdict::stable);
      if (growth.positive()) EXPECT_EQ(found.kind, growth.kind);
      unstable += growth.positive();

      DenseModel own;
      own.contact = system.contact(), own.standstill = system.standstill();
      own.points = static_cast<int>(own.contact.size());
      ContactReading reading(own, many);
      const auto from = q.begin() + (model.modes + 3 * system.layout().own_points.begin) * (2 * many + 1);
      reading.read({from, from + 3 * own.points * (2 * many + 1)});
      for (const bool remembering : {true, false}) {
        std::vector<Complex> multipliers;
        for (const Waves waves : {Waves::whole, Waves::half}) {
          WaveSystem waves_of(system, waves, omega, reading.answers(waves, many, remembering ? exponent_shift : 0),
                              remembering ? reading.history().holds : std::vector<ContactHistory::Hold>());
          const WaveSystem::Exponents exponents = waves_of.near_zero();
          EXPECT_TRUE(exponents.found);
          for (const Complex s : exponents.values)
            multipliers.push_back((waves == Waves::half ? -1.0 : 1.0) * std::exp(2 * M_PI * s));
        }
        if (!remembering) {
          EXPECT_GT(farthest(multipliers, expected), 0.05);
          continue;
        }
        EXPECT_EQ(multipliers.size(), 2u * model.dofs()); // those of sliders are all but 0
        EXPECT_LT(farthest(multipliers, expected), 3e-3 * std::max(1.0, largest_modulus(expected)));
        for (const Complex z : multipliers)
          if (z.imag() == 0) (z.real() > 0 ? positive : negative) += std::abs(z) > 1;
      }
    }
  EXPECT_EQ(unstable, 3);
  EXPECT_GT(positive, 4);
  EXPECT_GT(negative, 1);
}

TEST(LargeStability, of_a_cone) {
  const HarmonicSystem system = small_system(Law::cone);
  const DenseModel model = dense_model(system);
  for (const double amplitude : {0.01, 0.5}) {
    const std::vector<double> q = motion(model, harmonics, amplitude);
    const UniqueVec y = point_of(system, q, 0.7);
    const Stability found = LargeStabilityTest(system).judge(y), dense = StabilityTest(model).judge(q, 0.7);
    EXPECT_NEAR(found.growth, dense.growth, 3e-6);
    EXPECT_EQ(found.verdict, dense.verdict);
  }
}
