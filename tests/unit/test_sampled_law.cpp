// Laws coulomb and unilateral from samples: closed forms, a plain transcription of the law, and the derivative in every
// contact state.
#include <gtest/gtest.h>

#include "contact/sampled_law.hpp"
#include "one_point.hpp"

using namespace dovetail;

namespace {

// The law, read literally: a slider w that follows in slip and jumps to the place of landing, twice round the period.
std::vector<double> plainly(const ContactPoint &point, const Standstill &preload, const std::vector<double> &X,
                            int samples) {
  const int n = static_cast<int>(X.size()) / 3;
  const Fourier fourier(n / 2, samples);
  std::vector<double> x(3 * samples), force(3 * samples), G(3 * n);
  for (int d = 0; d < 3; ++d) {
    fourier.synthesise(&X[d * n], &x[d * samples]);
    for (int j = 0; j < samples; ++j) x[d * samples + j] += preload.x[d];
  }
  const double *xn = &x[2 * samples];
  std::array<double, 2> w = preload.w;
  for (int step = 0; step < 2 * samples; ++step) {
    const int j = step % samples, before = (j + samples - 1) % samples;
    const double p = xn[j] - point.gap, p_before = xn[before] - point.gap;
    force[2 * samples + j] = std::max(0.0, point.kn * p);
    for (int d = 0; d < 2; ++d) {
      const double *xt = &x[d * samples];
      double &T = force[d * samples + j];
      T = 0;
      if (p <= 0 || !has_friction(point.law)) continue;
      if (step > 0 && p_before <= 0) w[d] = xt[before] + p_before / (p_before - p) * (xt[j] - xt[before]);
      const double bound = point.mu[d] * point.kn * p;
      T = point.kt[d] * (xt[j] - w[d]);
      if (std::abs(T) <= bound) continue;
      T = T < 0 ? -bound : bound;
      w[d] = xt[j] - T / point.kt[d];
    }
  }
  for (int d = 0; d < 3; ++d) {
    fourier.analyse(&force[d * samples], &G[d * n]);
    G[d * n] -= 2 * preload.force[d];
  }
  return G;
}

std::vector<double> random_numbers(std::mt19937 &random, int count) {
  std::normal_distribution<double> normal;
  std::vector<double> out(count);
  for (double &value : out) value = normal(random);
  return out;
}

// Three harmonics: gross slip of both directions under varying load, and one that lifts off.
std::vector<double> slipping() {
  std::vector<double> x(21, 0.0);
  x[1] = 2, x[4] = 0.3, x[8] = -1.5, x[9] = 0.2, x[15] = 0.1, x[16] = -0.07;
  return x;
}
std::vector<double> lifting_off() {
  std::vector<double> x(21, 0.0);
  x[1] = 0.2, x[4] = 0.03, x[8] = -0.5, x[9] = 0.2, x[15] = 0.9, x[16] = -0.37;
  return x;
}

} // namespace

TEST(Fourier, synthesis_and_analysis_are_inverse) {
  for (const int samples : {11, 12, 64}) {
    const Fourier fourier(5, samples);
    std::vector<double> q(11), back(11), values(samples);
    for (int i = 0; i < 11; ++i) q[i] = 1.0 / (i + 1);
    fourier.synthesise(q.data(), values.data());
    EXPECT_NEAR(values[0], q[0] / 2 + q[1] + q[3] + q[5] + q[7] + q[9], 1e-14); // a0/2 and the cosines at t = 0
    fourier.analyse(values.data(), back.data());
    for (int i = 0; i < 11; ++i) EXPECT_NEAR(back[i], q[i], 1e-14);
  }
}

TEST(Fourier, lanes_agree_with_one_series_at_a_time) { // every parity of N and of H, one row and three
  std::mt19937 random(3);
  for (const int harmonics : {1, 2, 3, 4, 5, 10})
    for (const int samples : {21, 22, 23, 24, 64})
      for (const int rows : {1, 3}) {
        const Fourier plain(harmonics, samples);
        WideFourier wide(harmonics, samples);
        const int n = plain.size();
        LaneArray<double> q(rows * n), values(rows * samples);
        for (Lanes &each : q) {
          const std::vector<double> some = random_numbers(random, lane_count);
          for (int lane = 0; lane < lane_count; ++lane) each[lane] = some[lane];
        }
        wide.synthesise(rows, q.data(), values.data());
        LaneArray<double> kinked = values, back(rows * n); // harmonics above H too
        for (Lanes &each : kinked) each = each > 0 ? each : Lanes{};
        wide.analyse(rows, kinked.data(), back.data());
        std::vector<double> one(n), expected(samples), analysed(n);
        for (int r = 0; r < rows; ++r)
          for (const int lane : {0, 5, 7}) {
            for (int i = 0; i < n; ++i) one[i] = q[r * n + i][lane];
            plain.synthesise(one.data(), expected.data());
            for (int j = 0; j < samples; ++j) EXPECT_NEAR(values[r * samples + j][lane], expected[j], 1e-13);
            for (double &value : expected) value = std::max(0.0, value);
            plain.analyse(expected.data(), analysed.data());
            for (int i = 0; i < n; ++i) EXPECT_NEAR(back[r * n + i][lane], analysed[i], 1e-13);
          }
      }
}

TEST(MaskTable, means_of_a_mask_are_the_sums_over_its_samples) {
  for (const int samples : {9, 17, 64}) {
    const MaskTable masks(4, samples);
    const int n = coefficient_count(4);
    for (const auto &[begin, end] : {std::pair{0, samples}, {3, 8}, {0, 1}, {5, 5}}) {
      const double *from = masks.at(begin), *to = masks.at(end);
      for (int m = 0; m < n; ++m) {
        double c = 0, s = 0;
        for (int j = begin; j < end; ++j)
          c += std::cos(2 * M_PI * m * j / samples) / samples, s += std::sin(2 * M_PI * m * j / samples) / samples;
        EXPECT_NEAR(to[m] - from[m], c, 1e-14);
        EXPECT_NEAR(to[n + m] - from[n + m], s, 1e-14);
      }
    }
  }
}

TEST(SampledLaw, loop_area_of_one_slider) { // 4 mu N (X - mu N / kt), closed form
  const double X = 3.0, mu_N = 0.4 * 100 * 0.5;
  OnePoint law(typical, standstill(typical, {0, 0, 0.6}), 3, 1 << 14);
  std::vector<double> x(21, 0.0);
  x[1] = X;                                                   // t1 = X cos
  const double area = M_PI * X * std::abs(law.force(x)[2]);   // work of the force's sine part against X cos
  EXPECT_NEAR(area, 4 * mu_N * (X - mu_N / 40), 2e-5 * area); // sampling error 1/N^2 against the stick time
  EXPECT_NEAR(law.activity().dissipation, 4 * mu_N * (X - mu_N / 40), 2e-5 * area);
}

TEST(SampledLaw, activity_of_one_slider) { // sticks while it goes back by 2 mu N / kt from either end
  const double X = 3.0, mu_N = 0.4 * 100 * 0.5, stick = std::acos(1 - 2 * mu_N / 40 / X) / M_PI;
  const int samples = 4000;
  std::vector<double> x(9, 0.0);
  x[1] = X;
  const Activity activity = OnePoint(typical, standstill(typical, {0, 0, 0.6}), 1, samples).activity(x);
  EXPECT_EQ(activity.open, 0);
  EXPECT_NEAR(activity.stick(), stick, 2.0 / samples);
  EXPECT_EQ(activity.events, 4); // two onsets, two ends
  EXPECT_GT(activity.dissipation, 0);
}

TEST(SampledLaw, activity_of_a_point_that_lifts_off) { // x_n = 0.6 + cos theta against a gap of 0.1
  const int samples = 4000;
  OnePoint law(typical, standstill(typical, {0, 0, 0.6}), 1, samples);
  std::vector<double> x(9, 0.0);
  x[7] = 1;
  Activity activity = law.activity(x);
  EXPECT_NEAR(activity.open, 1.0 / 3, 2.0 / samples);
  EXPECT_EQ(activity.slip, 0);
  EXPECT_EQ(activity.events, 2); // one lift-off, one landing: counted once for both directions
  EXPECT_NEAR(activity.dissipation, 0, 1e-10);
  x[2] = 5, x[5] = -4; // both slip when they land and when they lift off: no events of their own
  activity = law.activity(x);
  EXPECT_NEAR(activity.open, 1.0 / 3, 2.0 / samples);
  EXPECT_NEAR(activity.open + activity.slip + activity.stick(), 1, 1e-15);
  EXPECT_GT(activity.slip, 0.3);
  EXPECT_EQ(activity.events, 2 + 2 * 4); // both directions turn back twice in contact: end, onset
  EXPECT_GT(activity.dissipation, 0);
}

TEST(SampledLaw, slip_of_either_direction_is_slip_of_the_point) {
  OnePoint law(typical, standstill(typical, {0, 0, 0.6}), 1, 256);
  std::vector<double> one(9, 0.0), other(9, 0.0), both(9, 0.0);
  one[1] = both[1] = 3, other[5] = both[5] = 3; // a quarter of a period apart
  const double first = law.activity(one).slip, second = law.activity(other).slip;
  const Activity activity = law.activity(both);
  EXPECT_GT(activity.slip, std::max(first, second));
  EXPECT_LT(activity.slip, first + second);
  EXPECT_EQ(activity.events, 8);
}

TEST(SampledLaw, stays_linear_while_stuck_and_closed) {
  OnePoint law(typical, standstill(typical, {0.01, -0.02, 0.6}), 2, 32);
  std::vector<double> x(15);
  for (int i = 0; i < 15; ++i) x[i] = 0.01 * (i % 4 - 1);
  const std::vector<double> G = law.force(x), dG = law.derivative();
  EXPECT_EQ(law.activity().stick(), 1);
  EXPECT_EQ(law.activity().events, 0);
  for (int row = 0; row < 15; ++row) {
    const double k = row < 5 ? 40 : row < 10 ? 55 : 100;
    EXPECT_NEAR(G[row], k * x[row], 1e-13);
    for (int col = 0; col < 15; ++col) EXPECT_EQ(dG[15 * row + col], row == col ? k : 0); // the springs, nothing summed
  }
}

TEST(SampledLaw, never_touching_gives_no_force) {
  OnePoint law(typical, standstill(typical, {0, 0, -5}), 2, 32);
  for (const double value : law.force(std::vector<double>(15, 0.3))) EXPECT_EQ(value, 0);
  EXPECT_EQ(law.activity().open, 1);
  EXPECT_EQ(law.activity().slip, 0);
  EXPECT_EQ(law.activity().events, 0);
  for (const double value : law.derivative()) EXPECT_EQ(value, 0);
}

TEST(SampledLaw, equals_a_plain_transcription_in_any_lane) { // every order of states, every kind of N and of group
  std::mt19937 random(11);
  const int harmonics = 4, n = 9, width = 27;
  for (const int samples : {37, 48, 64, 130})
    for (const int count : {1, 7, 8, 9}) {
      SampledLaw law(harmonics, samples);
      std::vector<ContactPoint> points;
      std::vector<Standstill> preloads;
      std::vector<double> X, G(count * width, 7.0);
      std::vector<int> which(count);
      for (int p = 0; p < count; ++p) {
        points.push_back(typical);
        points.back().law = p % 3 == 2 ? Law::unilateral : Law::coulomb;
        points.back().mu[0] = 0.1 * (p % 5); // one without friction
        preloads.push_back(standstill(points.back(), {0.1, -0.1, 0.3 * (p % 4)}));
        const std::vector<double> x = random_motion(random, harmonics, p % 2 ? 0.5 : 0.05);
        X.insert(X.end(), x.begin(), x.end());
        which[p] = count - 1 - p;
      }
      std::vector<Activity> activity(count);
      std::vector<Linearisation> linear(count);
      law.evaluate(which.data(), count, points.data(), preloads.data(), X.data(), G.data(), activity.data(),
                   linear.data());
      for (int p = 0; p < count; ++p) {
        const std::vector<double> x(&X[p * width], &X[p * width] + width), g(&G[p * width], &G[p * width] + width);
        const std::vector<double> expected = plainly(points[p], preloads[p], x, samples);
        for (int i = 0; i < width; ++i) EXPECT_NEAR(g[i], expected[i], 1e-12);
        OnePoint alone(points[p], preloads[p], harmonics, samples);
        EXPECT_EQ(g, alone.force(x)); // to the bit: neither the lane nor the neighbours matter
        EXPECT_EQ(activity[p].events, alone.activity().events);
        EXPECT_EQ(spread(points[p].law, n, [&](double *blocks) { linear[p].write(points[p], blocks); }),
                  alone.derivative());
      }
    }
}

TEST(SampledLaw, unilateral_point_has_a_normal_force_only) {
  ContactPoint point = typical;
  point.law = Law::unilateral;
  point.kt = {-1, std::nan("")}; // without meaning
  const Standstill preload{{0.05, 0, 0.6}, {0, 0, 50}, {}};
  OnePoint law(point, preload, 3, 64), rough(typical, preload, 3, 64);
  std::vector<double> x(21, 0.3);
  x[15] = 0.9, x[16] = -0.37;
  const std::vector<double> G = law.force(x), with_friction = rough.force(x);
  for (int i = 0; i < 14; ++i) EXPECT_EQ(G[i], 0);
  for (int i = 14; i < 21; ++i) EXPECT_EQ(G[i], with_friction[i]);
  EXPECT_GT(law.activity().open, 0);
  EXPECT_EQ(law.activity().open, rough.activity().open);
  EXPECT_EQ(law.activity().slip, 0);
  EXPECT_LT(law.derivative_error(x), 1e-9);
}

TEST(SampledLaw, without_friction_it_slips_for_ever) { // also where nothing moves
  ContactPoint smooth = typical;
  smooth.mu = {0, 0};
  OnePoint law(smooth, standstill(smooth, {0, 0, 0.6}), 1, 32);
  std::vector<double> x(9, 0.0);
  for (const double amplitude : {0.0, 0.5}) {
    x[1] = amplitude, x[7] = 0.1;
    const std::vector<double> G = law.force(x), dG = law.derivative();
    for (int i = 0; i < 6; ++i) EXPECT_EQ(G[i], 0);
    for (int i = 0; i < 6 * 9; ++i) EXPECT_EQ(dG[i], 0);
    EXPECT_EQ(law.activity().slip, 1);
  }
}

TEST(SampledLaw, derivative_in_gross_slip) {
  OnePoint law(typical, standstill(typical, {0.05, 0, 0.6}), 3, 64);
  EXPECT_LT(law.derivative_error(slipping()), 1e-9);
}

TEST(SampledLaw, derivative_with_lift_off_and_landing) {
  OnePoint law(typical, standstill(typical, {0.05, 0, 0.6}), 3, 64);
  EXPECT_LT(law.derivative_error(lifting_off()), 1e-9);
}

TEST(SampledLaw, derivative_with_contact_through_the_start_of_the_period) { // landing long before sample 0, or at it
  OnePoint law(typical, standstill(typical, {0.05, 0, 0.6}), 3, 64);
  std::vector<double> x(21, 0.0);
  x[1] = 0.1, x[2] = 0.05, x[8] = 0.02, x[9] = 0.2;
  for (int shift = 0; shift < 64; ++shift) { // the same motion, started everywhere
    const double angle = 2 * M_PI * shift / 64 + 0.01;
    x[15] = 0.9 * std::cos(angle), x[16] = 0.9 * std::sin(angle);
    EXPECT_LT(law.derivative_error(x), 1e-9) << shift;
  }
}

TEST(SampledLaw, derivative_after_shakedown) { // slips in the first round, sticks all through the second
  OnePoint law(typical, standstill(typical, {0, 0, 0.6}), 3, 64);
  std::vector<double> x(21, 0.0);
  x[0] = 1.9, x[1] = 0.3, x[9] = -0.15, x[16] = 0.02; // offset pulls the slider along once
  EXPECT_EQ(law.activity(x).stick(), 1);
  // the mean motion no longer acts through kt: it hangs on the slip of round one
  EXPECT_GT(std::abs(law.derivative(x)[0] - 40), 1.0);
  EXPECT_LT(law.derivative_error(x), 1e-9);
}

TEST(SampledLaw, derivative_of_random_motions) { // every order of states; steps across a kink excluded by their rarity
  std::mt19937 random(7);
  OnePoint law(typical, standstill(typical, {0.1, -0.1, 0.4}), 4, 48);
  int good = 0;
  for (int trial = 0; trial < 200; ++trial)
    good += law.derivative_error(random_motion(random, 4, 0.6), {1e-4, 1e-5, 1e-6}, 1) < 1e-9;
  EXPECT_GE(good, 198);
}

TEST(SampledLaw, products_with_the_derivative_agree_with_its_blocks) {
  std::mt19937 random(5);
  OnePoint law(typical, standstill(typical, {0.1, -0.1, 0.4}), 4, 48);
  for (int trial = 0; trial < 20; ++trial) {
    const std::vector<double> x = random_motion(random, 4, trial % 2 ? 0.6 : 0.1);
    EXPECT_LT(law.product_error(x, random_motion(random, 4, 1)), 1e-12);
  }
}

TEST(SampledLaw, sampling_error_falls_with_the_square) {
  std::vector<double> x(21, 0.0);
  x[1] = 0.5, x[4] = 0.2, x[8] = -0.8, x[15] = 0.9, x[16] = -0.37; // slip and lift-off
  const auto force = [&](int samples) {
    return OnePoint(typical, standstill(typical, {0.05, 0, 0.6}), 3, samples).force(x, false);
  };
  const std::vector<double> reference = force(1 << 16);
  const auto error = [&](int samples) {
    const std::vector<double> G = force(samples);
    double sum = 0;
    for (int i = 0; i < 21; ++i) sum += std::pow(G[i] - reference[i], 2);
    return std::sqrt(sum);
  };
  double coarse = 0, fine = 0; // scatter with the place of the events: averaged over neighbours
  for (int shift = 0; shift < 8; ++shift) coarse += error(200 + shift), fine += error(3200 + shift);
  EXPECT_GT(std::log2(coarse / fine) / 4, 1.7);
}
