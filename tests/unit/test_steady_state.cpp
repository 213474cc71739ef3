// Time integration: against small steps, closed forms and energy; shooting against a long march; and that it always
// ends.
#include <gtest/gtest.h>

#include <complex>
#include <limits>

#include "contact/fourier.hpp"
#include "linear_motion.hpp"
#include "norms.hpp"
#include "small_model.hpp"
#include "small_steps.hpp"
#include "transient/shooting.hpp"
#include "transient/steady_state.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

// The three points of small_model.hpp under some laws, shaken hard enough to slip and to open.
DenseModel scene(const std::vector<Law> &laws, double stiffer = 1, const Damping &damping = 0.05) {
  ReducedModel reduced = small_reduced(PETSC_COMM_WORLD);
  std::vector<ContactPoint> contact = small_contact(reduced);
  for (std::size_t p = 0; p < contact.size(); ++p) {
    contact[p].law = laws[reduced.own_points.begin + p];
    contact[p].mu = {0.3, contact[p].law == Law::cone ? 0.3 : 0.4};
    contact[p].kn *= stiffer;
    for (double &kt : contact[p].kt) kt *= stiffer;
  }
  std::string note;
  const Numbers zero(reduced.own_contact_dofs(), 0.0);
  PreloadedModel model = contact_preload(std::move(reduced), std::move(contact), zero, note);
  const HarmonicSystem system(scaled(std::move(model), damping, {}), 3, exactly,
                              course({0.2, 2.0, 0.6, 0.0, 0.4, 0.1, 0.0}));
  return dense_model(system);
}

const std::vector<Law> friction(3, Law::coulomb);

// Springs in place of the joint: closed and stuck for ever, or open.
DenseModel linear(bool closed, const Damping &damping = 0.05) {
  DenseModel model = scene(friction, 1, damping);
  for (int p = 0; p < model.points; ++p) {
    ContactPoint &point = model.contact[p];
    point.gap = closed ? -1e4 : 1e4, point.mu = {1e3, 1e3};
    model.standstill[p] = {{}, {0, 0, closed ? point.kn * 1e4 : 0}, {}};
  }
  return model;
}

// One mass on springs pressed onto a contact by 600: check 1 of the single-mass cases.
DenseModel single_mass(double damping = 0.01) {
  DenseModel model;
  model.points = 1;
  model.K = {40, 0, 0, 0, 40, 0, 0, 0, 40}, model.M = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  model.loads = {{{0, 0, 100}, {0, 0, 1}}}, model.damping = damping;
  model.contact = {{Law::coulomb, 120, {30, 30}, {0.3, 0.3}, 0}};
  model.standstill = {{{0, 0, 5}, {0, 0, 600}, {0, 0}}};
  return model;
}

// Coefficients (n, 2H+1) of the linear response with springs at the contact dofs.
Numbers response(const DenseModel &model, double omega, const Numbers &springs, int harmonics) {
  using Complex = std::complex<double>;
  const int n = model.dofs(), width = coefficient_count(harmonics);
  Numbers out(n * width);
  for (int k = 0; k <= highest_harmonic(model.loads); ++k) {
    std::vector<Complex> A(n * n), b(n);
    for (int i = 0; i < n * n; ++i)
      A[i] = Complex(model.K[i], k * omega * model.viscous(i)) - std::pow(k * omega, 2) * model.M[i];
    for (int c = 0; c < 3 * model.points; ++c) A[(model.modes + c) * (n + 1)] += springs[c];
    for (int i = 0; i < n; ++i)
      b[i] = Complex(force_coefficient(model.loads, i, cosine(k)),
                     k > 0 ? -force_coefficient(model.loads, i, sine(k)) : 0);
    b = solve(A, b);
    for (int i = 0; i < n; ++i) {
      out[i * width + cosine(k)] = b[i].real();
      if (k > 0) out[i * width + sine(k)] = -b[i].imag();
    }
  }
  return out;
}

Numbers place(const Flow &flow, const Flow::State &state) {
  auto [q, v, w] = flow.motion_state(state);
  q.insert(q.end(), v.begin(), v.end());
  return q;
}

} // namespace

TEST(SteadyState, every_law_against_small_steps) {
  const std::vector<std::pair<std::vector<Law>, Damping>> cases = {
      {friction, 0.05},
      {friction, {0.02, 0.07}},
      {{Law::cone, Law::cone, Law::cone}, 0.05},
      {{Law::unilateral, Law::unilateral, Law::unilateral}, 0.05},
      {{Law::bilateral, Law::coulomb, Law::cone}, 0.05}};
  for (const auto &[laws, damping] : cases) {
    DenseModel model = scene(laws, 1, damping);
    if (damping.mass > 0) model.C = dashpots(model.dofs(), 0.1);
    const double omega = 0.8;
    Flow flow(model, omega);
    Flow::State state = flow.rest();
    Motion motion;
    for (int period = 0; period < 3; ++period) ASSERT_TRUE(flow.period(state, 0, motion));
    // the error of these steps is proportional to h^2, with the cone to h: their limit is what is compared
    const bool cone = laws.back() == Law::cone;
    std::array<long, 2> seen{};
    const Numbers fine = from_rest_in_small_steps(model, omega, 3, cone ? 1 : 2, seen);
    EXPECT_LT(distance(place(flow, state), fine), cone ? 1e-5 : 2e-6) << static_cast<int>(laws[0]);
    if (laws[0] != Law::unilateral) EXPECT_GT(seen[0], 0) << "nothing slips";
    EXPECT_GT(seen[1], 0) << "nothing opens";
  }
}

TEST(SteadyState, error_follows_the_tolerance_with_order_20) {
  const DenseModel smooth = linear(true), events = scene(friction), cone = scene({Law::cone, Law::cone, Law::cone});
  for (const DenseModel *model : {&smooth, &events, &cone}) {
    const auto after_two_periods = [&](double tolerance, long &steps) {
      Flow flow(*model, 0.8, tolerance);
      Flow::State state = flow.rest();
      Motion motion;
      for (int period = 0; period < 2; ++period) EXPECT_TRUE(flow.period(state, 0, motion));
      steps = flow.steps();
      return place(flow, state);
    };
    long few, many;
    const Numbers exact = after_two_periods(1e-14, many);
    for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10})
      EXPECT_LT(distance(after_two_periods(tolerance, few), exact), 10 * tolerance + 1e-9);
    if (model != &smooth) continue; // the instants of events follow no order
    const double coarse = distance(after_two_periods(1e-3, few), exact),
                 fine = distance(after_two_periods(1e-10, many), exact),
                 order = std::log(coarse / fine) / std::log(static_cast<double>(many) / few);
    EXPECT_NEAR(order, 20, 4) << few << " steps: " << coarse << ", " << many << ": " << fine;
  }
}

TEST(SteadyState, linear_closed_forms) {
  for (const auto &[closed, damping] : {std::pair{true, Damping(0.05)}, {false, 0.05}, {true, {0.02, 0.07}}}) {
    DenseModel model = linear(closed, damping);
    if (damping.mass > 0) model.C = dashpots(model.dofs(), 0.5);
    Numbers springs;
    for (const ContactPoint &point : model.contact)
      for (const double k : {point.kt[0], point.kt[1], point.kn}) springs.push_back(closed ? k : 0);
    for (const double omega : {0.5, 0.97, 2.3}) {
      const SteadyState steady = steady_state(model, omega, {}, {4, 400, 1e-7});
      EXPECT_TRUE(steady.settled);
      EXPECT_LT(distance(steady.coefficients, response(model, omega, springs, 4)), 1e-7) << closed << " " << omega;
    }
  }
}

TEST(SteadyState, bilateral_joint_and_a_body_held_by_it_alone) {
  DenseModel model; // two masses with a spring between them, each on its contact point: K is singular
  model.points = 2;
  model.K.resize(36), model.M.resize(36);
  for (int d = 0; d < 6; ++d) {
    model.M[7 * d] = d < 3 ? 1 : 2;
    model.K[7 * d] = 3, model.K[6 * d + (d + 3) % 6] = -3;
  }
  model.loads = {{{1, 0.5, -0.3, 0, 0.2, 0.4}, {0.3, 1, 0, 0.2, 0.1}}}, model.damping = 0.03;
  for (const Law law : {Law::bilateral, Law::coulomb, Law::cone}) {
    const double mu = 50;
    model.contact = {{law, 2, {1, 1.5}, {mu, mu}, -9}, {law, 5, {0.7, 2}, {mu, mu}, -9}};
    model.standstill = {{{}, {0, 0, 18}, {}}, {{}, {0, 0, 45}, {}}};
    Numbers springs;
    for (const ContactPoint &point : model.contact)
      for (const double k : {point.kt[0], point.kt[1]}) springs.push_back(law == Law::bilateral ? 0 : k);
    springs.insert(springs.begin() + 2, 2), springs.insert(springs.begin() + 5, 5);
    if (law == Law::bilateral) // nothing holds it tangentially
      for (const int d : {0, 1, 3, 4}) model.loads[0].vector[d] = 0;
    else
      model.loads[0].vector = {1, 0.5, -0.3, 0, 0.2, 0.4};
    Numbers expected = springs;
    for (double &k : expected) k = k == 0 ? 1 : k; // there is no motion there
    const SteadyState steady = steady_state(model, 1.3, {}, {3, 400, 1e-7});
    EXPECT_TRUE(steady.settled);
    EXPECT_LT(distance(steady.coefficients, response(model, 1.3, expected, 3)), 1e-7);
  }
}

TEST(SteadyState, hard_impacts_keep_the_energy) {
  DenseModel model; // nothing is lost: no damping, no friction
  model.points = 1;
  model.K = model.M = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const double kn = 1e6, gap = 0.5;
  model.contact = {{Law::unilateral, kn, {}, {}, gap}};
  model.standstill = {{}};
  Flow flow(model, 0.37);
  Flow::State state = flow.state({{0, 0, 0}, {0, 0, 1}, {{}}});
  Motion motion;
  double highest = 0;
  for (int period = 0; period < 200; ++period) {
    ASSERT_TRUE(flow.period(state, 256, motion));
    for (int j = 0; j < motion.instants; ++j) {
      const double q = motion.at(j)[2], v = motion.rate_at(j)[2], pressed_in = std::max(0.0, q - gap);
      ASSERT_NEAR(v * v / 2 + q * q / 2 + kn * pressed_in * pressed_in / 2, 0.5, 2e-7) << period;
      highest = std::max(highest, q);
    }
  }
  EXPECT_GT(highest, gap);
}

// Weakly damped.
struct Weak {
  DenseModel model;
  double omega;
};
std::vector<Weak> weakly_damped() {
  std::vector<Weak> out{{scene(friction, 1, 2e-3), 0.8},
                        {scene({Law::cone, Law::coulomb, Law::unilateral}, 1, 2e-3), 1.1}};
  for (double &f : out[0].model.loads[0].fourier) f *= 0.3;
  return out;
}

TEST(SteadyState, shooting_finds_what_a_long_march_does) {
  for (const Weak &weak : weakly_damped()) {
    const SteadyState steady = steady_state(weak.model, weak.omega, {}, {5, 1000, 1e-7});
    EXPECT_TRUE(steady.settled);
    EXPECT_GT(steady.multiplier, 0.98);
    EXPECT_LT(steady.multiplier, 1);
    EXPECT_LT(steady.periods, 300);
    Flow flow(weak.model, weak.omega);
    Flow::State state = flow.rest();
    Motion motion;
    for (int period = 0; period < 3000; ++period) ASSERT_TRUE(flow.period(state, 0, motion));
    ASSERT_TRUE(flow.period(state, 1024, motion));
    EXPECT_LT(distance(steady.coefficients, coefficients_of(motion, 5)), 1e-8);
  }
}

TEST(SteadyState, multiplier_of_a_damped_oscillation) { // closed: exp(-xi K T / 2); the stuck sliders' 1 is left out
  for (const double damping : {0.01, 1e-4}) {
    const double omega = 9, period = 2 * std::acos(-1) / omega;
    const SteadyState steady = steady_state(single_mass(damping), omega, {}, {3, 300, 1e-6});
    EXPECT_TRUE(steady.settled);
    EXPECT_NEAR(steady.multiplier, std::exp(-damping * 40 * period / 2), 1e-6);
  }
}

TEST(SteadyState, unstable_motion_is_found_and_named) {
  const DenseModel model = single_mass();
  const double omega = 10.2;
  const int width = 7;
  std::vector<SteadyState> found; // at one frequency, by motions of different size to begin with
  for (const double amplitude : {2.0, 12.0, 24.0}) {
    Numbers start(3 * width);
    start[2 * width] = -amplitude / 2, start[2 * width + sine(1)] = -amplitude;
    if (amplitude == 24) start[2 * width + cosine(1)] = -amplitude, start[2 * width + sine(1)] = 0;
    found.push_back(steady_state(model, omega, start, {5, 400, 1e-7}));
    EXPECT_TRUE(found.back().settled);
  }
  // always closed; and on the branch that bends over, the upper and the lower part
  EXPECT_LT(found[0].amplitude[2], 2);
  EXPECT_GT(found[1].amplitude[2], 10);
  EXPECT_GT(found[2].amplitude[2], found[1].amplitude[2] + 2);
  EXPECT_LT(found[0].multiplier, 1);
  EXPECT_GT(found[1].multiplier, 1.1);
  EXPECT_LT(found[2].multiplier, 1);
  // The march leaves it, by that factor in every period.
  Flow flow(model, omega);
  Flow::State state = flow.state(found[1].end);
  state.rate[2] += 1e-6;
  Motion motion;
  Numbers away;
  for (int period = 0; period < 30; ++period) {
    ASSERT_TRUE(flow.period(state, 1, motion));
    away.push_back(distance(place(flow, state), place(flow, flow.state(found[1].end))));
  }
  EXPECT_NEAR(away[29] / away[28], found[1].multiplier, 1e-3);
  // From rest, the answer is a motion that a march reaches.
  EXPECT_LT(steady_state(model, omega, {}, {5, 400, 1e-7}).multiplier, 1);
}

// At 8 to 11 of the frequencies, by the processor's rounding, which chaos makes large; a march alone finds none.
TEST(SteadyState, motions_that_chaos_passes_are_found) {
  if (!alone()) return; // nothing is shared out
  DenseModel model = scene({Law::coulomb, Law::unilateral, Law::coulomb}, 1, 1e-3);
  for (double &f : model.loads[0].fourier) f *= 4;
  for (ContactPoint &point : model.contact) point.kn = 1e4;
  int found = 0;
  for (int i = 0; i < 14; ++i) {
    const double omega = 0.5 + 0.07 * i;
    const SteadyState steady = steady_state(model, omega, {}, {5, 3000, 1e-6});
    if (!steady.settled) continue;
    ++found;
    Flow flow(model, omega);
    const Flow::State start = flow.state(steady.end);
    Flow::State state = start;
    Motion motion;
    ASSERT_TRUE(flow.period(state, 0, motion));
    // a period changes it by 1e-6 at most, the next one by that times the multiplier
    EXPECT_LT(distance(place(flow, state), place(flow, start)), 1e-6 * std::max(1.0, steady.multiplier)) << omega;
  }
  EXPECT_GE(found, 4);
}

TEST(SteadyState, goes_on_from_the_motion_given) {
  // The second only: in the first some sliders stick in the end, where they came to on the way from rest.
  const Weak weak = weakly_damped()[1];
  const SteadyState first = steady_state(weak.model, weak.omega, {}, {80, 1000, 1e-7});
  const SteadyState again = steady_state(weak.model, weak.omega, first.coefficients, {80, 1000, 1e-7});
  EXPECT_TRUE(first.settled && again.settled);
  EXPECT_LT(again.periods, first.periods);
  EXPECT_LT(distance(again.coefficients, first.coefficients), 1e-8);
}

TEST(SteadyState, stuck_sliders_stay) {
  DenseModel model = linear(true);
  const SteadyState plain = steady_state(model, 0.9, {}, {3, 400, 1e-7});
  model.standstill[1].w = {0.25, -0.125}; // and the force that goes with it, so that it is at rest there
  for (int d = 0; d < 2; ++d) model.standstill[1].force[d] = -model.contact[1].kt[d] * model.standstill[1].w[d];
  const SteadyState moved = steady_state(model, 0.9, {}, {3, 400, 1e-7});
  EXPECT_TRUE(plain.settled && moved.settled);
  for (int p = 0; p < model.points; ++p) EXPECT_EQ(moved.end.w[p], model.standstill[p].w); // to the last bit
  EXPECT_LT(distance(moved.coefficients, plain.coefficients), 1e-7);
}

TEST(SteadyState, amplitude_is_that_of_the_course_in_time) {
  const DenseModel model = scene(friction, 100);
  const SteadyState steady = steady_state(model, 0.9, {}, {60, 400, 1e-7});
  ASSERT_TRUE(steady.settled);
  Flow flow(model, 0.9);
  Flow::State state = flow.state(steady.end);
  Motion motion;
  constexpr int instants = 1 << 17;
  ASSERT_TRUE(flow.period(state, instants, motion));
  for (int i = 0; i < model.dofs(); ++i) {
    double mean = 0, most = 0;
    for (int j = 0; j < instants; ++j) mean += motion.at(j)[i] / instants;
    for (int j = 0; j < instants; ++j) most = std::max(most, std::abs(motion.at(j)[i] - mean));
    EXPECT_NEAR(steady.amplitude[i], most, 1e-6 * most) << i;
  }
}

TEST(SteadyState, always_ends) {
  DenseModel model = single_mass();
  std::fill(model.K.begin(), model.K.end(), 0.0); // a body that a constant force pulls off its joint
  model.loads[0].fourier = {-20, 0, 1};
  EXPECT_FALSE(steady_state(model, 9, {}, {3, 300, 1e-6}).settled);

  model = single_mass();
  model.damping = -0.5; // it feeds itself: numbers run away
  const SteadyState away = steady_state(model, 9, {}, {3, 5000, 1e-6});
  EXPECT_FALSE(away.settled);

  const double nan = std::numeric_limits<double>::quiet_NaN();
  const SteadyState none = steady_state(single_mass(), 9, Numbers(9, nan), {3, 300, 1e-6});
  EXPECT_FALSE(none.settled);
  EXPECT_TRUE(none.coefficients.empty());

  EXPECT_FALSE(steady_state(single_mass(), 9, {}, {3, 1, 1e-6}).settled);
  EXPECT_FALSE(steady_state(single_mass(), 9, {}, {3, 300, 1e-6, 1e5}).settled); // work used up

  model = single_mass(); // stiff beyond measure: bounded all the same
  model.contact[0].kn = 1e18, model.standstill[0] = {{0, 0, 1e-15}, {0, 0, 1000}, {}};
  EXPECT_FALSE(steady_state(model, 9, {}, {3, 300, 1e-6, 1e8}).settled);
}

TEST(SteadyState, the_same_on_every_rank) {
  const SteadyState steady = steady_state(scene({Law::cone, Law::coulomb, Law::unilateral}), 0.8, {}, {5, 400, 1e-6});
  ASSERT_TRUE(steady.settled);
  Numbers first = steady.coefficients;
  first.push_back(steady.periods);
  const Numbers own = first;
  MPI_Bcast(first.data(), static_cast<int>(first.size()), MPI_DOUBLE, 0, PETSC_COMM_WORLD);
  EXPECT_EQ(first, own);
}

TEST(Series, first_zero) {
  const auto times = [](const Series &a, double root) { // a (t - root)
    Series out{};
    for (int k = 0; k <= series_order; ++k) out[k] = (k > 0 ? a[k - 1] : 0) - root * a[k];
    return out;
  };
  const Series minus{-1}, plus{1};
  EXPECT_GT(first_below_zero(plus), 1);
  EXPECT_EQ(first_below_zero(minus), 0);
  EXPECT_NEAR(first_below_zero(times(minus, 0.3)), 0.3, 1e-15);
  EXPECT_GT(first_below_zero(times(minus, 1.3)), 1);
  EXPECT_EQ(first_below_zero(times(minus, 0.3), 0.300001), first_below_zero(times(minus, 0.3)));
  EXPECT_GT(first_below_zero(times(minus, 0.3), 0.299999), 1); // not before that
  EXPECT_NEAR(first_below_zero(times(times(times(minus, 0.9), 0.2), 0.1), 0.15), 0.1, 1e-14);
  EXPECT_GT(first_below_zero(times(times(times(minus, 0.9), 0.2), 0.1), 0.05), 1);
  EXPECT_NEAR(first_below_zero(times(times(plus, 0.4), 0.4001)), 0.4, 1e-11); // below zero for a short time
  EXPECT_NEAR(first_below_zero(times(times(times(minus, 0.9), 0.2), 0.1)), 0.1, 1e-14);
  Series above = times(times(plus, 0.4), 0.4);
  above[0] += 1e-9;
  EXPECT_GT(first_below_zero(above), 1);
  Series rising{}; // from zero, and back through it
  rising[1] = 0.5, rising[2] = -1;
  EXPECT_NEAR(first_below_zero(rising), 0.5, 1e-15);
  Series wave{}; // cos 9 t
  wave[0] = 1;
  for (int k = 2; k <= series_order; k += 2) wave[k] = -wave[k - 2] * 81 / (k * (k - 1));
  double t = std::acos(0.0) / 9;
  EXPECT_NEAR(first_below_zero(wave), t, 1e-9);
}

TEST(Series, is_not_below_zero_before_the_first_zero_and_zero_there) {
  int found = 0;
  for (int seed = 1; seed <= 500; ++seed) {
    Series c;
    double size = 0, term = 1 + seed % 7; // of a sum of waves of up to so many radians
    for (int k = 0; k <= series_order; term *= (1 + seed % 7) / (k + 1.0), ++k)
      c[k] = term * std::sin(seed * (k + 1.3)), size += std::abs(c[k]);
    c[0] = std::abs(c[0]);
    const double zero = first_below_zero(c), round_off = 1e-14 * size;
    found += zero <= 1;
    if (zero <= 1) {
      EXPECT_NEAR(value(c, zero), 0, round_off) << seed;
    }
    for (int i = 0; i < 1000 && i * 1e-3 < zero; ++i) EXPECT_GT(value(c, i * 1e-3), -round_off) << seed << " " << i;
  }
  EXPECT_GT(found, 100);
  EXPECT_LT(found, 400);
}
