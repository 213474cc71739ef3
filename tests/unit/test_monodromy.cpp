// The map over one period: closed forms, and plain integration of the same equations.
#include <gtest/gtest.h>

#include "linear_motion.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

using Complex = std::complex<double>;
using Matrix2 = std::array<double, 4>; // row-major

// (x, x') after t of x'' + c x' + k x = 0
Matrix2 oscillator(double k, double c, double t) {
  const double w = std::sqrt(k - c * c / 4), e = std::exp(-c * t / 2), C = std::cos(w * t), S = std::sin(w * t) / w;
  return {e * (C + c / 2 * S), e * S, -e * k * S, e * (C - c / 2 * S)};
}

Matrix2 product(const Matrix2 &a, const Matrix2 &b) {
  return {a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3], a[2] * b[0] + a[3] * b[2], a[2] * b[1] + a[3] * b[3]};
}

std::vector<Complex> eigenvalues_of(const Matrix2 &a) {
  const Complex half = (a[0] + a[3]) / 2, root = std::sqrt(half * half - (a[0] * a[3] - a[1] * a[2]));
  return {half + root, half - root};
}

ContactHistory history(int points, std::vector<double> ends) {
  ContactHistory out;
  out.points = points;
  out.ends = std::move(ends);
  out.answers.assign(static_cast<std::size_t>(out.intervals()) * 3 * points, Answer::free);
  return out;
}

} // namespace

TEST(Exponential, of_an_oscillator) {
  Exponential exponential;
  for (const double t : {0.0, 1e-3, 0.4, 3.0, 40.0}) {
    Dense A(2, 2);
    A(0, 1) = 1, A(1, 0) = -25, A(1, 1) = -0.2;
    const Dense &E = exponential.of(A, t);
    const Matrix2 expected = oscillator(25, 0.2, t);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(E(i / 2, i % 2), expected[i], 5e-11) << "t = " << t;
  }
}

// A mass that is in contact for part of the period: the bilinear oscillator, in closed form.
TEST(Monodromy, of_a_mass_and_a_stop) {
  const double k = 2, m = 0.5, xi = 0.03, a = 0.04, omega = 1.7;
  ContactPoint stop{Law::unilateral, 9};
  Monodromy monodromy(dense_scene({stop}, k, m, {xi, a}, 0));
  ContactHistory h = history(1, {0, 1.1, 4.0, 2 * M_PI});
  h.answers[3 + 2] = Answer::spring;
  const auto free = [&](double angle) { return oscillator(k / m, xi * k / m + a, angle / omega); };
  const auto closed = [&](double angle) { return oscillator((k + stop.kn) / m, xi * k / m + a, angle / omega); };
  std::vector<Complex> expected = eigenvalues_of(product(free(2 * M_PI - 4), product(closed(2.9), free(1.1))));
  for (const Complex tangential : eigenvalues_of(free(2 * M_PI))) expected.push_back(tangential);
  const std::vector<Complex> found = monodromy.multipliers(h, omega);
  EXPECT_LT(farthest(expected, found), 1e-10);
  EXPECT_LT(farthest(found, expected), 1e-10);
}

// Two points whose directions slip, stick on sliders set after slip and at a landing, and open, in an order without
// pattern, one slider held over the end of the period; against Runge and Kutta's method for the original equations.
TEST(Monodromy, of_points_that_stick_slip_and_open) {
  const double omega = 0.8;
  DenseModel model = dense_scene({{Law::coulomb, 5, {3, 4}, {0.4, 0.3}, 0}, {Law::coulomb, 4, {2, 2}, {0.5, 0.4}, 0}},
                                 3, 1, 0.04, 0.1);
  const int n = 6;
  model.C = dashpots(n, 0.3);
  ContactHistory h = history(2, {0, 0.7, 1.5, 2.2, 3.0, 4.1, 5.0, 2 * M_PI});
  using A = Answer;
  const A table[7][6] = {{A::held, A::forth, A::spring, A::free, A::free, A::free},
                         {A::forth, A::forth, A::spring, A::free, A::free, A::free},
                         {A::forth, A::held, A::spring, A::held, A::back, A::spring},
                         {A::held, A::held, A::spring, A::held, A::back, A::spring},
                         {A::held, A::held, A::spring, A::spring, A::held, A::spring},
                         {A::back, A::held, A::spring, A::spring, A::held, A::spring},
                         {A::held, A::forth, A::spring, A::free, A::free, A::free}};
  for (int i = 0; i < 7; ++i) std::copy_n(table[i], 6, &h.answers[6 * i]);
  h.holds = {{1, 2, 1.5, 5.0, 4, -1.1},
             {2, 2, 1.5, 3.0, 2, 0.6},
             {0, 3, 2.2, 4.1, 3, -2.0},
             {3, 4, 3.0, 5.0, 2, 1.6},
             {0, 6, 5.0, 2 * M_PI + 0.7, 3, 2.0}};
  Dense inverse(n, n); // of M
  Factors factors;
  Dense mass(n, n);
  mass.values = model.M;
  ASSERT_TRUE(factors.factor(mass));
  using State = std::array<double, 16>; // q, q', v
  const auto rate = [&](const State &s, int interval) {
    State out{};
    std::vector<double> force(n);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) force[i] -= model.K[i * n + j] * s[j] + model.viscous(i * n + j) * s[n + j];
    for (int d = 0; d < n; ++d) {
      const ContactPoint &point = model.contact[d / 3];
      const double x = s[d], normal = s[d / 3 * 3 + 2];
      const A answer = table[interval][d];
      if (d % 3 == 2) {
        if (answer == A::spring) force[d] -= point.kn * x;
        continue;
      }
      const double kt = point.kt[d % 3], limit = point.mu[d % 3] * point.kn * normal;
      if (answer == A::spring) force[d] -= kt * x;
      if (answer == A::held) force[d] -= kt * x - s[12 + 2 * (d / 3) + d % 3];
      if (answer == A::forth) force[d] -= limit;
      if (answer == A::back) force[d] += limit;
    }
    factors.solve(force.data());
    for (int i = 0; i < n; ++i) out[i] = s[n + i] / omega, out[n + i] = force[i] / omega;
    return out;
  };
  const auto along = [](const State &s, const State &r, double step) {
    State out = s;
    for (int i = 0; i < 16; ++i) out[i] += step * r[i];
    return out;
  };
  constexpr int steps = 1500;         // per interval
  constexpr int begin = 0, size = 13; // slider 0 of the first point is held over
  Dense map(size, size);
  for (int c = 0; c < size; ++c) {
    State s{};
    s[c] = 1;
    for (int k = 0; k < 7; ++k) {
      const int i = (begin + k) % 7;
      for (const ContactHistory::Hold &hold : h.holds)
        if (hold.interval == i)
          s[12 + hold.slider] =
              hold.by_t * s[hold.slider / 2 * 3 + hold.slider % 2] + hold.by_n * s[hold.slider / 2 * 3 + 2];
      const double step = (h.ends[i + 1] - h.ends[i]) / steps;
      for (int j = 0; j < steps; ++j) {
        const State a = rate(s, i), b = rate(along(s, a, step / 2), i), e = rate(along(s, b, step / 2), i),
                    f = rate(along(s, e, step), i);
        for (int l = 0; l < 16; ++l) s[l] += step / 6 * (a[l] + 2 * b[l] + 2 * e[l] + f[l]);
      }
    }
    std::copy_n(s.begin(), size, map.column(c));
  }
  std::vector<Complex> expected = eigenvalues(map);
  // The slider held over the end of the period owes its place to the others: the map from there has one 0 more.
  expected.erase(std::remove_if(expected.begin(), expected.end(), [](Complex m) { return std::abs(m) < 1e-7; }),
                 expected.end());
  ASSERT_EQ(expected.size(), 12u);
  const std::vector<Complex> found = Monodromy(model).multipliers(h, omega);
  EXPECT_GT(largest_modulus(expected), 0.3);
  EXPECT_LT(farthest(expected, found), 1e-9);
  EXPECT_LT(farthest(found, expected), 1e-9);
}

// A body that only its friction holds in t1, and nothing in t2: there it drifts, and both are no instability. Where a
// little stiffness holds it instead, multipliers close to 1 are found for these motions and the others are the same.
TEST(Monodromy, leaves_out_motions_that_nothing_resists) {
  ContactHistory h = history(1, {0, 0.9, 2.0, 3.5, 5.2, 2 * M_PI});
  const Answer t1[] = {Answer::held, Answer::forth, Answer::held, Answer::back, Answer::held};
  for (int i = 0; i < 5; ++i) h.answers[3 * i] = t1[i], h.answers[3 * i + 2] = Answer::spring;
  h.holds = {{0, 2, 2.0, 3.5, 3, -1}, {0, 4, 5.2, 2 * M_PI + 0.9, 3, 1}};
  DenseModel model = dense_scene({{Law::coulomb, 5, {3, 4}, {0.4, 0}, 0}}, 0, 1, 0.3, 0);
  model.K[8] = 2; // normal
  Monodromy free(model);
  model.K[0] = model.K[4] = 1e-7;
  Monodromy weakly_held(model);
  for (const double omega : {0.5, 1.0, 2.0}) {
    const auto found = free.multipliers(h, omega), with_ones = weakly_held.multipliers(h, omega);
    EXPECT_EQ(free.indifferent(), 3); // a place and a drift in t2, a place in t1
    EXPECT_EQ(weakly_held.indifferent(), 0);
    EXPECT_LT(largest_modulus(found), 0.9);
    EXPECT_NEAR(largest_modulus(with_ones), 1, 1e-4);
    std::vector<Complex> others;
    int ones = 0;
    for (const Complex m : with_ones) std::abs(m - 1.0) < 1e-2 ? void(++ones) : others.push_back(m);
    EXPECT_EQ(ones, 3);
    EXPECT_LT(farthest(others, found), 1e-4);
  }
}
