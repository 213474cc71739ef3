// Periodic motions followed over frequency in time: against time integration at single frequencies, against what
// multipliers do at turning points, and that a restart goes the same way to the last bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "contact/law.hpp"
#include "transient/orbit_curve.hpp"
#include "transient/steady_state.hpp"

using namespace dovetail;

namespace {

// One mass on springs, on one contact point: pressed on by `press`, force along t1 and n.
DenseModel one_mass(double press, double along, double across, double damping) {
  DenseModel model;
  model.points = 1;
  model.K = {40, 0, 0, 0, 40, 0, 0, 0, 40}, model.M = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  model.force = {along, 0, across}, model.fourier = {0, 0, 1}, model.damping = damping;
  model.contact = {{Law::coulomb, 120, {30, 30}, {0.3, 0.3}, 0}};
  model.standstill = {{{0, 0, press / 120}, {0, 0, press}, {0, 0}}};
  return model;
}

std::unique_ptr<OrbitCurve> begun(const DenseModel &model, double omega, double unit) {
  const SteadyState steady = steady_state(model, omega, {}, {.harmonics = 8, .periods = 2000});
  EXPECT_TRUE(steady.settled);
  auto curve = std::make_unique<OrbitCurve>(model, omega, unit);
  EXPECT_TRUE(curve->begin(steady.q, steady.v, steady.w, 1));
  return curve;
}

double distance(const std::vector<double> &a, const std::vector<double> &b) {
  EXPECT_EQ(a.size(), b.size());
  double most = 0, size = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    most = std::max(most, std::abs(a[i] - b[i])), size = std::max(size, std::abs(b[i]));
  return most / size;
}

// q, v and the two sliders of one_mass after a period, by Runge and Kutta's steps; shares with the curve the law of one
// instant only.
std::vector<double> by_small_steps(const DenseModel &model, double omega, const std::vector<double> &begin, int steps) {
  const ContactPoint &point = model.contact[0];
  const Standstill &rest = model.standstill[0];
  std::vector<double> z(begin.begin(), begin.begin() + 6);
  Memory w{begin[6], begin[7]}, next = w;
  const double h = 2 * std::acos(-1) / omega / steps;
  const auto rate = [&](double t, const std::vector<double> &at) {
    const double N = pressed(point.kn, at[2] + rest.x[2] - point.gap), f = std::sin(omega * t);
    std::vector<double> out{at[3], at[4], at[5], 0, 0, 0};
    for (int d = 0; d < 3; ++d) {
      double g = N;
      if (d < 2) {
        const double x = at[d] + rest.x[d];
        g = rubbed(point.kt[d] * (x - w[d]), point.mu[d] * N);
        next[d] = x - g / point.kt[d];
      }
      out[3 + d] = model.force[d] * f - 40 * (at[d] + model.damping * at[3 + d]) - (g - rest.force[d]);
    }
    return out;
  };
  for (int i = 0; i < steps; ++i) {
    std::vector<double> k[4], at = z;
    for (int stage = 0; stage < 4; ++stage) {
      k[stage] = rate((i + (stage == 0 ? 0 : stage == 3 ? 1 : 0.5)) * h, at);
      for (int j = 0; j < 6; ++j) at[j] = z[j] + (stage == 2 ? 1 : 0.5) * h * k[stage][j];
    }
    for (int j = 0; j < 6; ++j) z[j] += h / 6 * (k[0][j] + 2 * k[1][j] + 2 * k[2][j] + k[3][j]);
    rate((i + 1) * h, z);
    w = next;
  }
  z.insert(z.end(), w.begin(), w.end());
  return z;
}

} // namespace

TEST(OrbitCurve, motions_come_back_by_small_steps) {
  struct {
    DenseModel model;
    double from, to;
  } cases[] = {{one_mass(600, 0, 100, 0.01), 8, 16}, {one_mass(20, 40, 30, 0.05), 4, 14}};
  for (const auto &[model, from, to] : cases) {
    const auto at = begun(model, from, 8);
    int falling = 0;
    for (int i = 0; i < 3000 && at->omega() < to; ++i) {
      ASSERT_TRUE(at->step());
      falling += at->rising() < 0;
      if (i % 20 != 0) continue;
      const Motion motion = at->motion(1);
      std::vector<double> begin(motion.q.begin(), motion.q.end());
      begin.insert(begin.end(), motion.v.begin(), motion.v.end());
      const std::vector<double> saved = at->save(); // sliders: numbers 6 and 7 of the map, from 5 on
      for (int d = 0; d < 2; ++d) begin.push_back(saved[11 + d] * saved[2] / std::sqrt(30.0));
      EXPECT_LT(distance(by_small_steps(model, at->omega(), begin, 20000), begin), 2e-4) << at->omega();
    }
    if (model.force[0] == 0) EXPECT_GT(falling, 10); // unstable ones, too
  }
}

TEST(OrbitCurve, between_turning_points_a_multiplier_is_beyond_one) {
  const DenseModel model = one_mass(600, 0, 100, 0.01); // lifts off: the peak leans to lower frequencies
  const auto at = begun(model, 8, 8);
  OrbitCurve &curve = *at;
  std::vector<double> turns;
  double nearest = HUGE_VAL; // to 1, of the multipliers next to a turning point
  bool rises = true, opens = false;
  for (int i = 0; i < 2000 && curve.omega() < 16; ++i) {
    ASSERT_TRUE(curve.step()) << curve.omega();
    const std::complex<double> multiplier = curve.multiplier();
    if ((curve.rising() > 0) != rises) {
      rises = !rises;
      turns.push_back(curve.omega());
      nearest = std::min(nearest, std::abs(multiplier - 1.0));
    } else if (rises) {
      EXPECT_LT(std::abs(multiplier), 1 + 1e-3) << curve.omega();
    } else {
      EXPECT_GT(multiplier.real(), 1 - 1e-3) << curve.omega();
      EXPECT_EQ(multiplier.imag(), 0) << curve.omega();
    }
    const Motion motion = curve.motion(64);
    for (int j = 0; j < motion.instants; ++j) opens = opens || motion.at(j)[2] < -5;
  }
  EXPECT_GE(curve.omega(), 16);
  EXPECT_TRUE(opens);
  ASSERT_EQ(turns.size(), 2u);
  EXPECT_LT(turns[1], turns[0]);
  EXPECT_LT(nearest, 0.1);
}

TEST(OrbitCurve, the_motions_are_those_of_time_integration) {
  for (const DenseModel &model : {one_mass(600, 0, 100, 0.01), one_mass(20, 30, 6, 0.02), one_mass(20, 40, 30, 0.05)}) {
    const auto at = begun(model, 4, 10);
    OrbitCurve &curve = *at;
    double before = curve.omega();
    int met = 0;
    for (int i = 0; i < 3000 && curve.omega() < 14; ++i, before = curve.omega()) {
      ASSERT_TRUE(curve.step()) << curve.omega();
      for (const double omega : {5.5, 7.5, 8.5, 13.0}) { // with one motion each
        if (!(before < omega && omega <= curve.omega())) continue;
        ++met;
        Motion motion;
        ASSERT_TRUE(curve.motion_at(omega, 256, motion));
        const SteadyState steady = steady_state(model, omega, {}, {.harmonics = 8, .periods = 4000, .tolerance = 1e-8});
        EXPECT_TRUE(steady.settled);
        EXPECT_LT(distance(coefficients_of(motion, 8), steady.coefficients), 1e-6) << omega;
      }
    }
    EXPECT_EQ(met, 4);
  }
}

TEST(OrbitCurve, goes_on_from_what_was_saved_to_the_last_bit) {
  const DenseModel model = one_mass(20, 40, 30, 0.05);
  const auto at = begun(model, 4, 10);
  OrbitCurve &curve = *at;
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(curve.step());
  const std::vector<double> saved = curve.save();
  OrbitCurve other(model, saved[0], 20); // the end of the sweep has moved
  EXPECT_FALSE(other.restore({saved.begin(), saved.end() - 1}));
  ASSERT_TRUE(other.restore(saved));
  for (int i = 0; i < 30; ++i) {
    ASSERT_TRUE(curve.step());
    ASSERT_TRUE(other.step());
    ASSERT_EQ(curve.omega(), other.omega()) << i;
    ASSERT_EQ(curve.motion(16).q, other.motion(16).q) << i;
  }
}
