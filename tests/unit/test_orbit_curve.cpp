// Periodic motions followed over frequency in time: against time integration at single frequencies, against what
// multipliers do at turning points, and that a restart goes the same way to the last bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "linear_motion.hpp"
#include "small_steps.hpp"
#include "transient/steady_state.hpp"
#include "turning_point.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

// One mass on springs, on one contact point: pressed on by `press`, force along t1 and n.
DenseModel one_mass(double press, double along, double across, double damping) {
  DenseModel model;
  model.points = 1;
  model.K = {40, 0, 0, 0, 40, 0, 0, 0, 40}, model.M = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  model.loads = {{{along, 0, across}, {0, 0, 1}}}, model.damping = damping;
  model.contact = {{Law::coulomb, 120, {30, 30}, {0.3, 0.3}, 0}};
  model.standstill = {{{0, 0, press / 120}, {0, 0, press}, {0, 0}}};
  return model;
}

// The curve, standing at a first motion; the test fails by what is thrown where there is none.
std::unique_ptr<OrbitCurve> begun(const DenseModel &model, double omega, double unit, double longest_step = 0.1) {
  const SteadyState steady = steady_state(model, omega, {}, {.harmonics = 8, .periods = 2000});
  EXPECT_TRUE(steady.settled);
  auto curve = std::make_unique<OrbitCurve>(model, omega, unit, longest_step);
  if (!curve->begin(steady.end, 1)) throw std::runtime_error("no first motion at " + std::to_string(omega));
  return curve;
}

// Frequencies of turning points within steps, or at corners.
std::vector<double> turns(OrbitCurve &curve, double to) {
  std::vector<double> found;
  bool rises = true;
  for (int i = 0; i < 20000 && curve.omega(*curve.here()) < to; ++i) {
    if (!curve.step()) throw std::runtime_error("no step from " + std::to_string(curve.omega(*curve.here())));
    if (curve.here()->rises() == rises) continue;
    const OrbitCurve::PlacePtr place = curve.cornered() ? curve.corner() : turning_point(curve, 1e-7);
    rises = !rises;
    EXPECT_TRUE(place) << curve.omega(*curve.here());
    if (place) found.push_back(curve.omega(*place));
    double nearest = HUGE_VAL; // to 1, of the multipliers
    for (const auto &one : place ? curve.multipliers(*place) : std::vector<std::complex<double>>{})
      nearest = std::min(nearest, std::abs(one - 1.0));
    EXPECT_TRUE(curve.cornered() || nearest < 1e-3) << nearest;
  }
  return found;
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
    std::array<long, 2> seen{};
    for (int i = 0; i < 3000 && at->omega(*at->here()) < to; ++i) {
      ASSERT_TRUE(at->step());
      falling += !at->here()->rises();
      if (i % 20 != 0) continue;
      const MotionState state = at->motion_state(*at->here());
      std::vector<double> begin = state.q;
      begin.insert(begin.end(), state.v.begin(), state.v.end());
      const Memory slider = state.w[0];
      std::vector<double> end = begin;
      std::vector<Memory> w{slider};
      small_steps(model, at->omega(*at->here()), 1, 20000, end, w, seen);
      EXPECT_LT(distance(end, begin), 2e-4) << at->omega(*at->here());
      EXPECT_LT(std::hypot(w[0][0] - slider[0], w[0][1] - slider[1]), 2e-4 * largest(begin)) << at->omega(*at->here());
    }
    EXPECT_GT(seen[1], 0) << "nothing opens";
    if (model.loads[0].vector[0] == 0)
      EXPECT_GT(falling, 10); // unstable ones, too
    else
      EXPECT_GT(seen[0], 0) << "nothing slips";
  }
}

TEST(OrbitCurve, between_turning_points_a_multiplier_is_beyond_one) {
  const DenseModel model = one_mass(600, 0, 100, 0.01); // lifts off: the peak leans to lower frequencies
  const auto at = begun(model, 8, 8);
  OrbitCurve &curve = *at;
  std::vector<double> turns;
  double nearest = HUGE_VAL; // to 1, of the multipliers next to a turning point
  bool rises = true, opens = false;
  for (int i = 0; i < 2000 && curve.omega(*curve.here()) < 16; ++i) {
    ASSERT_TRUE(curve.step()) << curve.omega(*curve.here());
    std::complex<double> multiplier = 0;
    for (const auto &one : curve.multipliers(*curve.here()))
      if (std::abs(one) > std::abs(multiplier)) multiplier = one;
    if (curve.here()->rises() != rises) {
      rises = !rises;
      turns.push_back(curve.omega(*curve.here()));
      nearest = std::min(nearest, std::abs(multiplier - 1.0));
    } else if (rises) {
      EXPECT_LT(std::abs(multiplier), 1 + 1e-3) << curve.omega(*curve.here());
    } else {
      EXPECT_GT(multiplier.real(), 1 - 1e-3) << curve.omega(*curve.here());
      EXPECT_EQ(multiplier.imag(), 0) << curve.omega(*curve.here());
    }
    const Motion motion = curve.motion(*curve.here(), 64);
    for (int j = 0; j < motion.instants; ++j) opens = opens || motion.at(j)[2] < -5;
  }
  EXPECT_GE(curve.omega(*curve.here()), 16);
  EXPECT_TRUE(opens);
  ASSERT_EQ(turns.size(), 2u);
  EXPECT_LT(turns[1], turns[0]);
  EXPECT_LT(nearest, 0.1);
}

TEST(OrbitCurve, the_motions_are_those_of_time_integration) {
  for (const DenseModel &model : {one_mass(600, 0, 100, 0.01), one_mass(20, 30, 6, 0.02), one_mass(20, 40, 30, 0.05)}) {
    const auto at = begun(model, 4, 10);
    OrbitCurve &curve = *at;
    double before = curve.omega(*curve.here());
    int met = 0;
    for (int i = 0; i < 3000 && curve.omega(*curve.here()) < 14; ++i, before = curve.omega(*curve.here())) {
      ASSERT_TRUE(curve.step()) << curve.omega(*curve.here());
      for (const double omega : {5.5, 7.5, 8.5, 13.0}) { // with one motion each
        if (!(before < omega && omega <= curve.omega(*curve.here()))) continue;
        ++met;
        const OrbitCurve::PlacePtr place = curve.at(omega, curve.here()->z, true);
        ASSERT_TRUE(place);
        const Motion motion = curve.motion(*place, 256);
        const SteadyState steady = steady_state(model, omega, {}, {.harmonics = 8, .periods = 4000, .tolerance = 1e-8});
        EXPECT_TRUE(steady.settled);
        EXPECT_LT(distance(coefficients_of(motion, 8), steady.coefficients), 1e-6) << omega;
      }
    }
    EXPECT_EQ(met, 4);
  }
}

TEST(OrbitCurve, turning_points_do_not_depend_on_steps) {
  const DenseModel model = one_mass(600, 0, 100, 0.01);
  const std::vector<double> usual = turns(*begun(model, 8, 8), 16), fine = turns(*begun(model, 8, 8, 2e-3), 16);
  ASSERT_EQ(usual.size(), 2u);
  ASSERT_EQ(fine.size(), 2u);
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(usual[i], fine[i], 1e-8 * fine[i]);
}

// A stop that is just touched is a corner of the curve: there the mass on its springs alone moves by the gap.
TEST(OrbitCurve, turning_point_at_a_corner) {
  constexpr double k = 40, xi = 0.003, force = 20, gap = 3;
  DenseModel model = one_mass(0, 0, force, xi);
  model.contact[0].kn = 40000, model.contact[0].gap = gap, model.standstill[0] = {};
  const double middle =
                   k - std::pow(xi * k, 2) / 2, // of both squares w^2 with (k - w^2)^2 + (xi k w)^2 = (force / gap)^2
      touches = std::sqrt(middle + std::sqrt(middle * middle - k * k + std::pow(force / gap, 2)));
  for (const double longest_step : {0.1, 2e-3}) {
    const std::vector<double> found = turns(*begun(model, 3, 8, longest_step), 12);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_GT(found[0], 11);
    EXPECT_NEAR(found[1], touches, 2e-6 * touches);
  }
}

// Beyond a corner it goes on, not back along the leg that led there: without that check curves of both scenes run back
// over themselves, and with one by the tangent in the corner alone those of the second. Motions are chaotic: which ones
// are found is a matter of last bits. So curves from many frequencies are followed, each as far as it goes.
TEST(OrbitCurve, does_not_turn_back_at_corners) {
  struct {
    double kn, force;
    int points;
    double from, to; // frequencies of first motions
  } cases[] = {{675, 11, 1, 1.98, 2.08}, {300, 6.5, 2, 0.63, 0.69}};
  constexpr int tried = 13, enough = 5, least = 3, steps = 400; // motions, and steps from each
  for (const auto &[kn, force, points, from, to] : cases) {
    std::vector<ContactPoint> contact{{Law::coulomb, kn, {kn / 3, kn / 2}, {0.4, 0.3}, 0},
                                      {Law::coulomb, kn / 2, {kn / 5, kn / 6}, {0.4, 0.3}, 0}};
    contact.resize(points);
    DenseModel model = with_modes(dense_scene(contact, 4, 1, 0.02, 0.01), {1.5, 12});
    shake(model, force);
    for (int p = 0; p < points; ++p) model.standstill[p] = standstill(contact[p], {0, 0, 1.5 / contact[p].kn});
    int begun = 0, corners = 0;
    for (int i = 0; i < tried && begun < enough; ++i) {
      const double omega = from + (to - from) * i / (tried - 1);
      const SteadyState steady = steady_state(model, omega, {}, {.harmonics = 8, .periods = 2000});
      OrbitCurve curve(model, omega, 4, 0.1);
      if (!steady.settled || !curve.begin(steady.end, 1)) continue;
      ++begun;
      Numbers way;
      for (int k = 0; k < steps; ++k) {
        Numbers next = curve.here()->z;
        for (double &number : next) number = -number;
        if (!curve.step()) break;
        add(next, 1, curve.here()->z);
        if (!way.empty())
          ASSERT_GT(dot(way, next), -0.99 * norm(way) * norm(next)) << kn << ", from " << omega << ", step " << k;
        corners += curve.cornered();
        way = next;
      }
    }
    EXPECT_GE(begun, least) << kn;
    EXPECT_GE(corners, 2 * least) << kn;
  }
}

TEST(OrbitCurve, goes_on_from_what_was_saved_to_the_last_bit) {
  const DenseModel model = one_mass(20, 40, 30, 0.05);
  const auto at = begun(model, 4, 10);
  OrbitCurve &curve = *at;
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(curve.step());
  Archive saved;
  curve.save(saved);
  Archive::Fields shorter = saved.fields();
  const auto z =
      std::find_if(shorter.names.begin(), shorter.names.end(), [](const auto &field) { return field.first == "z"; });
  ASSERT_NE(z, shorter.names.end());
  --z->second; // the numbers that follow belong to others then
  Archive all(saved.fields()), less(shorter);
  double begun = 0;
  all.field("begun_at", begun);
  OrbitCurve other(model, begun, 20); // the end of the sweep has moved
  EXPECT_FALSE(other.restore(less));
  ASSERT_TRUE(other.restore(all));
  for (int i = 0; i < 30; ++i) {
    ASSERT_TRUE(curve.step());
    ASSERT_TRUE(other.step());
    ASSERT_EQ(curve.omega(*curve.here()), other.omega(*other.here())) << i;
    ASSERT_EQ(curve.motion(*curve.here(), 16).q, other.motion(*other.here(), 16).q) << i;
  }
}
