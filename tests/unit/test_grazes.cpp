// Where a slider all but slips, in closed form: with constant normal load, stuck all round or slipping to and fro.
#include <gtest/gtest.h>

#include <map>

#include "one_point.hpp"

using namespace dovetail;

namespace {

constexpr int harmonics = 3, n = 2 * harmonics + 1;

// By direction and side, of which there is one each.
std::map<std::pair<int, int>, Graze> grazes(const ContactPoint &point, const Standstill &rest,
                                            const std::vector<double> &X, int samples) {
  ContactForces forces({point}, {rest}, harmonics, samples);
  std::vector<double> G(3 * n);
  forces.evaluate(X.data(), G.data());
  std::map<std::pair<int, int>, Graze> found;
  for (Graze &graze : forces.grazes(0, X.data())) {
    const std::pair key(graze.direction, graze.side);
    EXPECT_TRUE(found.emplace(key, std::move(graze)).second);
  }
  return found;
}

std::vector<double> row(double theta, double factor) { // of the synthesis
  std::vector<double> out(n);
  out[0] = factor / 2;
  for (int k = 1; k <= harmonics; ++k)
    out[cosine(k)] = factor * std::cos(k * theta), out[sine(k)] = factor * std::sin(k * theta);
  return out;
}

void expect_row(const std::vector<double> &found, const std::vector<double> &wanted) {
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) EXPECT_NEAR(found[i], wanted[i], 1e-9) << i;
}

// Each direction to and fro, cos(theta - phase) times an amplitude.
std::vector<double> to_and_fro(const std::array<double, 2> &amplitude, const std::array<double, 2> &phase) {
  std::vector<double> X(3 * n);
  for (int d = 0; d < 2; ++d)
    X[d * n + cosine(1)] = amplitude[d] * std::cos(phase[d]), X[d * n + sine(1)] = amplitude[d] * std::sin(phase[d]);
  return X;
}

double on_circle(double theta) { return std::remainder(theta, 2 * M_PI); }

} // namespace

TEST(Grazes, of_a_point_that_sticks_are_at_both_ends_of_its_way) {
  const Standstill rest = standstill(typical, {0.1, -0.05, 0.6});
  const std::array<double, 2> amplitude{0.2, 0.1}, phase{0.3, 2};
  const double normal = typical.kn * (0.6 - typical.gap);
  const auto found = grazes(typical, rest, to_and_fro(amplitude, phase), exactly);
  ASSERT_EQ(found.size(), 4u);
  for (const auto &[key, graze] : found) {
    const auto [d, side] = key;
    const double kt = typical.kt[d], bound = typical.mu[d] * normal;
    EXPECT_NEAR(on_circle(graze.theta - phase[d] - (side > 0 ? 0 : M_PI)), 0, 1e-9);
    EXPECT_NEAR(graze.height, kt * (amplitude[d] + side * (rest.x[d] - rest.w[d])) - bound, 1e-12);
    EXPECT_NEAR(graze.size, kt * amplitude[d] + bound, 1e-12);
    expect_row(graze.by_t, row(graze.theta, side * kt));
    expect_row(graze.by_n, row(graze.theta, -typical.mu[d] * typical.kn));
  }
}

// The first direction slips: before each slip its slider is where the one before, at the other end, has left it.
TEST(Grazes, of_a_point_that_slips_are_where_it_turns) {
  const Standstill rest = standstill(typical, {0, 0, 0.6});
  const std::array<double, 2> amplitude{3, 0.01}, phase{0.7, 0};
  const double bound = typical.mu[0] * typical.kn * (0.6 - typical.gap), kt = typical.kt[0];
  const auto found = grazes(typical, rest, to_and_fro(amplitude, phase), exactly);
  ASSERT_EQ(found.size(), 4u);
  for (const int side : {1, -1}) {
    const Graze &graze = found.at({0, side});
    EXPECT_NEAR(on_circle(graze.theta - phase[0] - (side > 0 ? 0 : M_PI)), 0, 1e-9);
    EXPECT_NEAR(graze.height, 2 * (kt * amplitude[0] - bound), 1e-9);
    const std::vector<double> here = row(graze.theta, side * kt), there = row(graze.theta + M_PI, -side * kt);
    const std::vector<double> press = row(graze.theta, -typical.mu[0] * typical.kn),
                              press_there = row(graze.theta + M_PI, -typical.mu[0] * typical.kn);
    std::vector<double> by_t(n), by_n(n);
    for (int i = 0; i < n; ++i) by_t[i] = here[i] + there[i], by_n[i] = press[i] + press_there[i];
    expect_row(graze.by_t, by_t), expect_row(graze.by_n, by_n);
  }
}

// It touches where n = 0.3 + cos(theta - 0.2) > 0, and sticks from landing to lift-off: all edges end below it.
TEST(Grazes, after_a_landing_are_measured_from_there) {
  ContactPoint point = typical;
  point.gap = 0, point.mu = {0.1, 0};
  const Standstill rest = standstill(point, {0, 0, 0.3});
  constexpr double shift = 0.2, amplitude = 0.085;
  std::vector<double> X(3 * n);
  X[cosine(3)] = amplitude * std::cos(3 * shift), X[sine(3)] = amplitude * std::sin(3 * shift);
  X[2 * n + cosine(1)] = std::cos(shift), X[2 * n + sine(1)] = std::sin(shift);
  const double kt = point.kt[0], mu_kn = point.mu[0] * point.kn, landing = shift - std::acos(-0.3);
  const auto t = [](double theta) { return amplitude * std::cos(3 * (theta - shift)); };
  ContactForces forces({point}, {rest}, harmonics, exactly);
  std::vector<double> G(3 * n);
  forces.evaluate(X.data(), G.data());
  EXPECT_NEAR(forces.activity()[0].dissipation, 0, 1e-12);
  std::array<int, 2> count{};
  for (const Graze &graze : forces.grazes(0, X.data())) {
    ++count[graze.side < 0];
    EXPECT_EQ(graze.direction, 0); // no friction in the other
    const double theta = graze.theta, edge = graze.side * kt * t(theta) - mu_kn * (0.3 + std::cos(theta - shift));
    EXPECT_NEAR(graze.height, edge - graze.side * kt * t(landing), 1e-9);
    EXPECT_LT(graze.height, 0);
    const double by_landing = kt * 3 * amplitude * std::sin(3 * (landing - shift)) / std::sin(landing - shift);
    std::vector<double> by_t = row(theta, graze.side * kt), by_n = row(theta, -mu_kn);
    const std::vector<double> landed_t = row(landing, -graze.side * kt),
                              landed_n = row(landing, graze.side * by_landing); // dt / dn there
    for (int i = 0; i < n; ++i) by_t[i] += landed_t[i], by_n[i] += landed_n[i];
    expect_row(graze.by_t, by_t), expect_row(graze.by_n, by_n);
  }
  EXPECT_EQ(count, (std::array<int, 2>{1, 2}));
}

// Pulled along in the first round by the highest place, it sticks in all others: what set it there is no graze itself.
TEST(Grazes, of_a_point_that_has_shaken_down_are_measured_from_what_it_slipped_to) {
  constexpr double shift = 0.7;
  const Standstill rest = standstill(typical, {0, 0, 0.6});
  std::vector<double> X(3 * n);
  X[0] = 1.9; // 0.95 + 0.3 cos a + 0.2 cos 2a, a = theta - shift
  for (const int k : {1, 2}) {
    const double size = k == 1 ? 0.3 : 0.2;
    X[cosine(k)] = size * std::cos(k * shift), X[sine(k)] = size * std::sin(k * shift);
  }
  const double kt = typical.kt[0], mu_kn = typical.mu[0] * typical.kn, bound = mu_kn * (0.6 - typical.gap);
  const auto t = [](double a) { return 0.95 + 0.3 * std::cos(a) + 0.2 * std::cos(2 * a); };
  ContactForces forces({typical}, {rest}, harmonics, exactly);
  std::vector<double> G(3 * n);
  forces.evaluate(X.data(), G.data());
  EXPECT_EQ(forces.activity()[0].slip, 0);
  std::array<int, 2> count{};
  for (const Graze &graze : forces.grazes(0, X.data())) {
    ++count[graze.side < 0];
    EXPECT_EQ(graze.direction, 0); // nothing moves in the other
    const double side = graze.side, theta = graze.theta;
    EXPECT_NEAR(std::cos(theta - shift), side > 0 ? -1 : -0.375, 1e-9);
    EXPECT_NEAR(graze.height, side * kt * (t(theta - shift) - t(0)) - bound + side * bound, 1e-9);
    std::vector<double> by_t = row(theta, side * kt), by_n = row(theta, -mu_kn);
    const std::vector<double> set_t = row(shift, -side * kt), set_n = row(shift, side * mu_kn);
    for (int i = 0; i < n; ++i) by_t[i] += set_t[i], by_n[i] += set_n[i];
    expect_row(graze.by_t, by_t), expect_row(graze.by_n, by_n);
  }
  EXPECT_EQ(count, (std::array<int, 2>{1, 2}));
}

TEST(Grazes, are_none_without_contact_or_friction_or_of_sampled_points) {
  const std::vector<double> X = to_and_fro({0.2, 0.1}, {0, 0});
  const Standstill closed = standstill(typical, {0, 0, 0.6});
  EXPECT_EQ(grazes(typical, closed, X, exactly).size(), 4u);
  EXPECT_TRUE(grazes(typical, closed, X, 64).empty());
  EXPECT_TRUE(grazes(typical, standstill(typical, {0, 0, -5}), X, exactly).empty());
  ContactPoint smooth = typical;
  smooth.mu[1] = 0;
  EXPECT_EQ(grazes(smooth, closed, X, exactly).size(), 2u);
  for (const Law law : {Law::unilateral, Law::bilateral, Law::cone}) {
    ContactPoint other = typical;
    other.law = law, other.mu = {0.4, 0.4};
    EXPECT_TRUE(grazes(other, standstill(other, {0, 0, 0.6}), X, exactly).empty());
  }
}
