// The contact law: closed forms, and its derivative in every contact state.
#include <gtest/gtest.h>

#include <random>

#include "contact/sampled_law.hpp"

using namespace dovetail;

namespace {

constexpr ContactPoint typical{100, {40, 55}, {0.4, 0.25}, 0.1};

Standstill standstill(const ContactPoint &point, std::array<double, 3> x) {
  const StaticForce at_rest = static_force(point, x.data());
  return {x, at_rest.force, at_rest.w};
}

// Largest relative deviation of dG from extrapolated central differences (steps h and h/2, error h^4).
double derivative_error(SampledLaw &law, const ContactPoint &point, const Standstill &preload, std::vector<double> X) {
  const int width = 3 * law.fourier().size();
  std::vector<double> G(width), dG(width * width), plus(width), minus(width), slope(width);
  law.evaluate(point, preload, X.data(), G.data(), dG.data());
  double worst = 0, scale = 0;
  for (int col = 0; col < width; ++col) {
    const double x = X[col];
    std::fill(slope.begin(), slope.end(), 0.0);
    for (const auto &[h, weight] : {std::pair{1e-5, -1.0 / 3}, {5e-6, 4.0 / 3}}) {
      X[col] = x + h, law.evaluate(point, preload, X.data(), plus.data(), nullptr);
      X[col] = x - h, law.evaluate(point, preload, X.data(), minus.data(), nullptr);
      for (int row = 0; row < width; ++row) slope[row] += weight * (plus[row] - minus[row]) / (2 * h);
    }
    X[col] = x;
    for (int row = 0; row < width; ++row) {
      worst = std::max(worst, std::abs(slope[row] - dG[row * width + col]));
      scale = std::max(scale, std::abs(slope[row]));
    }
  }
  return worst / scale;
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

TEST(Fourier, gram_of_a_mask_is_analysis_times_masked_synthesis) {
  const Fourier fourier(4, 17);
  const int n = fourier.size();
  std::vector<double> sums(2 * n), gram(n * n), values(17), column(n);
  fourier.add_sums(3, 11, 2.0, sums.data());
  fourier.add_gram(sums.data(), 0.5, gram.data(), n);
  for (int l = 0; l < n; ++l) {
    for (int j = 0; j < 17; ++j) values[j] = j >= 3 && j < 11 ? fourier.row(j)[l] : 0.0;
    fourier.analyse(values.data(), column.data());
    for (int i = 0; i < n; ++i) EXPECT_NEAR(gram[i * n + l], column[i], 1e-13);
  }
}

TEST(SampledLaw, loop_area_of_one_slider) { // 4 mu N (X - mu N / kt), closed form
  const double X = 3.0, mu_N = 0.4 * 100 * 0.5;
  SampledLaw law(3, 1 << 14);
  const Standstill preload = standstill(typical, {0, 0, 0.6});
  std::vector<double> x(21, 0.0), G(21);
  x[1] = X; // t1 = X cos
  EXPECT_EQ(law.evaluate(typical, preload, x.data(), G.data(), nullptr), State::slip);
  const double area = M_PI * X * std::abs(G[2]); // work over a cycle of the force's sine part against X cos
  EXPECT_NEAR(area, 4 * mu_N * (X - mu_N / 40), 2e-5 * area); // sampling error 1/N^2 against the stick time
}

TEST(SampledLaw, stays_linear_while_stuck_and_closed) {
  SampledLaw law(2, 32);
  const Standstill preload = standstill(typical, {0.01, -0.02, 0.6});
  std::vector<double> x(15), G(15), dG(225);
  for (int i = 0; i < 15; ++i) x[i] = 0.01 * (i % 4 - 1);
  EXPECT_EQ(law.evaluate(typical, preload, x.data(), G.data(), dG.data()), State::stick);
  for (int row = 0; row < 15; ++row) {
    const double k = row < 5 ? 40 : row < 10 ? 55 : 100;
    EXPECT_NEAR(G[row], k * x[row], 1e-13);
    for (int col = 0; col < 15; ++col) EXPECT_NEAR(dG[15 * row + col], row == col ? k : 0, 1e-12);
  }
}

TEST(SampledLaw, never_touching_gives_no_force) {
  SampledLaw law(2, 32);
  const Standstill preload = standstill(typical, {0, 0, -5});
  std::vector<double> x(15, 0.3), G(15, 1.0), dG(225, 1.0);
  EXPECT_EQ(law.evaluate(typical, preload, x.data(), G.data(), dG.data()), State::open);
  for (const double value : G) EXPECT_EQ(value, 0);
  for (const double value : dG) EXPECT_EQ(value, 0);
}

TEST(SampledLaw, derivative_in_gross_slip) {
  SampledLaw law(3, 64);
  std::vector<double> x(21, 0.0);
  x[1] = 2, x[4] = 0.3, x[8] = -1.5, x[9] = 0.2, x[15] = 0.1, x[16] = -0.07; // both directions, varying normal load
  EXPECT_LT(derivative_error(law, typical, standstill(typical, {0.05, 0, 0.6}), x), 1e-9);
}

TEST(SampledLaw, derivative_with_lift_off_and_landing) {
  SampledLaw law(3, 64);
  std::vector<double> x(21, 0.0);
  x[1] = 0.2, x[4] = 0.03, x[8] = -0.5, x[9] = 0.2, x[15] = 0.9, x[16] = -0.37;
  EXPECT_LT(derivative_error(law, typical, standstill(typical, {0.05, 0, 0.6}), x), 1e-9);
}

TEST(SampledLaw, derivative_after_shakedown) { // slips in the first round, sticks all through the second
  SampledLaw law(3, 64);
  std::vector<double> x(21, 0.0);
  x[0] = 1.9, x[1] = 0.3, x[9] = -0.15, x[16] = 0.02; // offset pulls the slider along once
  const Standstill preload = standstill(typical, {0, 0, 0.6});
  std::vector<double> G(21), dG(441);
  EXPECT_EQ(law.evaluate(typical, preload, x.data(), G.data(), dG.data()), State::stick);
  EXPECT_GT(std::abs(dG[0] - 40), 1.0); // the mean motion no longer acts through kt: it hangs on the slip of round one
  EXPECT_LT(derivative_error(law, typical, preload, x), 1e-9);
}

TEST(SampledLaw, derivative_of_random_motions) { // every order of states; steps across a kink excluded by their rarity
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  SampledLaw law(4, 48);
  int good = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> x(27);
    for (double &value : x) value = 0.6 * normal(random);
    good += derivative_error(law, typical, standstill(typical, {0.1, -0.1, 0.4}), x) < 1e-7;
  }
  EXPECT_GE(good, 196);
}

TEST(SampledLaw, sampling_error_falls_with_the_square) {
  std::vector<double> x(21, 0.0), reference(21), G(21);
  x[1] = 0.5, x[4] = 0.2, x[8] = -0.8, x[15] = 0.9, x[16] = -0.37; // slip and lift-off
  const Standstill preload = standstill(typical, {0.05, 0, 0.6});
  SampledLaw(3, 1 << 16).evaluate(typical, preload, x.data(), reference.data(), nullptr);
  const auto error = [&](int samples) {
    SampledLaw(3, samples).evaluate(typical, preload, x.data(), G.data(), nullptr);
    double sum = 0;
    for (int i = 0; i < 21; ++i) sum += std::pow(G[i] - reference[i], 2);
    return std::sqrt(sum);
  };
  double coarse = 0, fine = 0; // scatter with the place of the events: averaged over neighbours
  for (int shift = 0; shift < 8; ++shift) coarse += error(200 + shift), fine += error(3200 + shift);
  EXPECT_GT(std::log2(coarse / fine) / 4, 1.7);
}
