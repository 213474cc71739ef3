// The exact evaluation: closed forms, the sampled one as its samples grow denser, and where states begin and end.
#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "one_point.hpp"

using namespace dovetail;

namespace {

// Contact points and motions of every kind, by number: 1200 of them.
struct Scene {
  ContactPoint point;
  Standstill rest;
  int harmonics;
  std::vector<double> X;
};

constexpr int scenes = 1200;

Scene scene(int number) {
  std::mt19937 random(number);
  std::uniform_real_distribution<double> uniform;
  ContactPoint point = typical;
  for (double *k : {&point.kn, &point.kt[0], &point.kt[1]}) *k *= std::exp(uniform(random) - 0.5);
  for (double &mu : point.mu) mu *= 2 * uniform(random);
  if (number % 50 == 0) point.law = Law::unilateral;
  const Standstill rest = standstill(point, {0.3 * uniform(random), -0.2, 0.6 * uniform(random) - 0.1});
  const int harmonics = 1 + number % 7;
  const double amplitude = std::pow(10, -1.5 + 0.25 * (number / 7 % 9)), decay = 0.6 * (number / 63 % 4);
  return {point, rest, harmonics, random_motion(random, harmonics, amplitude, decay)};
}

// Changes from one state to another that a plain march over dense samples meets, over both directions.
std::set<std::pair<int, int>> changes(const Scene &s) {
  constexpr int samples = 2048, open = 2;
  const int n = coefficient_count(s.harmonics);
  const Fourier fourier(s.harmonics, samples);
  std::vector<double> x(samples), p(samples);
  std::set<std::pair<int, int>> seen;
  fourier.synthesise(&s.X[2 * n], p.data());
  for (double &value : p) value += s.rest.x[2] - s.point.gap;
  for (int d = 0; d < 2; ++d) {
    fourier.synthesise(&s.X[d * n], x.data());
    double w = s.rest.w[d] - s.rest.x[d];
    int state = open;
    for (int step = 0; step < 2 * samples; ++step) {
      const int j = step % samples, before = state;
      const double bound = s.point.mu[d] * s.point.kn * p[j], trial = s.point.kt[d] * (x[j] - w);
      if (p[j] <= 0) {
        state = open, w = x[j];
      } else if (std::abs(trial) <= bound) {
        state = 0;
      } else {
        state = trial > 0 ? 1 : -1;
        w = x[j] - state * bound / s.point.kt[d];
      }
      if (step > samples && state != before) seen.insert({before, state});
    }
  }
  return seen;
}

// All scenes of as many harmonics at once.
struct Answers {
  std::vector<std::vector<double>> G;
  std::vector<Activity> activity;
};

Answers answers(const std::vector<Scene> &some, int samples) {
  std::vector<ContactPoint> points;
  std::vector<Standstill> rests;
  std::vector<double> X;
  for (const Scene &s : some) {
    points.push_back(s.point), rests.push_back(s.rest);
    X.insert(X.end(), s.X.begin(), s.X.end());
  }
  ContactForces forces(points, rests, some[0].harmonics, samples);
  std::vector<double> G(X.size());
  forces.evaluate(X.data(), G.data(), false);
  Answers out{{}, forces.activity()};
  const std::size_t width = some[0].X.size();
  for (std::size_t i = 0; i < some.size(); ++i) out.G.emplace_back(G.begin() + i * width, G.begin() + (i + 1) * width);
  return out;
}

double size(const std::vector<double> &of) {
  return std::sqrt(std::inner_product(of.begin(), of.end(), of.begin(), 0.0));
}

} // namespace

TEST(ExactLaw, equals_the_sampled_one_on_every_kind_of_motion) {
  std::set<std::pair<int, int>> seen;
  int most_events = 0;
  double coarse = 0, fine = 0;
  for (int harmonics = 1; harmonics <= 7; ++harmonics) {
    std::vector<Scene> some;
    for (int number = harmonics - 1; number < scenes; number += 7) some.push_back(scene(number));
    const Answers exact = answers(some, exactly), sparse = answers(some, 1 << 10), dense = answers(some, 1 << 16),
                  densest = answers(some, 1 << 18);
    for (std::size_t i = 0; i < some.size(); ++i) {
      const std::string which = "scene " + std::to_string(harmonics - 1 + 7 * i);
      const Activity did = exact.activity[i], about = dense.activity[i];
      ASSERT_TRUE(did.events >= 0 && did.open >= 0 && did.slip > -1e-12 && did.stick() > -1e-12) << which;
      if (some[i].point.law == Law::coulomb) seen.merge(changes(some[i]));
      most_events = std::max(most_events, did.events);
      const double at_1024 = deviation(sparse.G[i], exact.G[i]), at_65536 = deviation(dense.G[i], exact.G[i]);
      coarse += at_1024 * at_1024, fine += at_65536 * at_65536;
      EXPECT_LT(at_65536, 1e-6) << which;
      // a contact of a hundredth of the period has a hundredth of the samples
      EXPECT_LT(deviation(densest.G[i], exact.G[i]), did.open < 0.97 ? 1e-8 : 1e-7) << which;
      EXPECT_NEAR(did.open, about.open, 1e-3) << which;
      EXPECT_NEAR(did.slip, about.slip, 1e-3) << which;
      EXPECT_NEAR(did.dissipation, about.dissipation, 1e-6 * size(some[i].X) * size(exact.G[i])) << which;
    }
  }
  EXPECT_GT(std::log2(coarse / fine) / 12, 1.8); // order of the root mean square, over six halvings
  EXPECT_GE(most_events, 30);
  const std::set<std::pair<int, int>> every{{0, 1}, {0, -1}, {1, 0}, {-1, 0}, {1, 2}, {-1, 2}, {2, 0}, {2, 1}, {2, -1}};
  for (const auto &change : every) EXPECT_TRUE(seen.count(change)) << change.first << " to " << change.second;
}

TEST(ExactLaw, loop_of_one_slider) { // closed forms of force and loop, work 4 mu N (X - mu N / kt)
  const double X = 3.0, mu_N = 0.4 * 100 * 0.5;
  OnePoint law(typical, standstill(typical, {0, 0, 0.6}), 3, exactly);
  std::vector<double> x(21, 0.0);
  x[1] = X; // t1 = X cos
  const std::vector<double> G = law.force(x);
  const double work = 4 * mu_N * (X - mu_N / 40), angle = std::acos(1 - 2 * mu_N / (40 * X)); // sticks for 0..angle
  EXPECT_NEAR(law.activity().dissipation, work, 1e-12 * work);
  EXPECT_NEAR(M_PI * X * -G[2], work, 1e-12 * work); // T = ... + G[2] sin, work = integral of T dx
  EXPECT_NEAR(law.activity().slip, 1 - 2 * angle / (2 * M_PI), 1e-13);
  EXPECT_EQ(law.activity().events, 4);
  EXPECT_EQ(law.activity().open, 0);
}

TEST(ExactLaw, bounce_without_friction) { // half-wave: kn X (sin a - a cos a) / pi and so on, open share in closed form
  ContactPoint point = typical;
  point.law = Law::unilateral, point.gap = 0;
  OnePoint law(point, standstill(point, {0, 0, 0.5}), 2, exactly);
  std::vector<double> x(15, 0.0);
  x[11] = 2; // n = 0.5 + 2 cos
  const std::vector<double> G = law.force(x);
  const double a = std::acos(-0.25); // closed for |theta| < a
  EXPECT_NEAR(law.activity().open, 1 - a / M_PI, 1e-14);
  EXPECT_EQ(law.activity().events, 2);
  EXPECT_NEAR(law.activity().dissipation, 0, 1e-11);
  EXPECT_NEAR(G[10], 2 * 100 / M_PI * (0.5 * a + 2 * std::sin(a)) - 2 * 50, 1e-11);
  EXPECT_NEAR(G[11], 2 * 100 / M_PI * (0.5 * std::sin(a) + a + std::sin(a) * std::cos(a)), 1e-11);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(G[i], 0);
}

TEST(ExactLaw, stays_linear_while_stuck_and_closed) {
  OnePoint law(typical, standstill(typical, {0.01, -0.02, 0.6}), 2, exactly);
  std::vector<double> x(15);
  for (int i = 0; i < 15; ++i) x[i] = 0.01 * (i % 4 - 1);
  const std::vector<double> G = law.force(x), dG = law.derivative();
  EXPECT_EQ(law.activity().stick(), 1);
  for (int row = 0; row < 15; ++row) {
    const double k = row < 5 ? 40 : row < 10 ? 55 : 100;
    EXPECT_NEAR(G[row], k * x[row], 1e-13);
    for (int col = 0; col < 15; ++col) EXPECT_EQ(dG[15 * row + col], row == col ? k : 0);
  }
}

TEST(ExactLaw, never_touching_gives_no_force) {
  OnePoint law(typical, standstill(typical, {0, 0, -5}), 2, exactly);
  for (const double value : law.force(std::vector<double>(15, 0.3))) EXPECT_EQ(value, 0);
  EXPECT_EQ(law.activity().open, 1);
  for (const double value : law.derivative()) EXPECT_EQ(value, 0);
}

TEST(ExactLaw, derivative_in_every_state) {
  std::vector<double> slip(21), lift(21), shake(21);
  slip[1] = 2, slip[4] = 0.3, slip[8] = -1.5, slip[9] = 0.2, slip[15] = 0.1, slip[16] = -0.07;
  lift[1] = 0.2, lift[4] = 0.03, lift[8] = -0.5, lift[9] = 0.2, lift[15] = 0.9, lift[16] = -0.37;
  shake[0] = 1.9, shake[1] = 0.3, shake[9] = -0.15, shake[16] = 0.02; // an offset pulls the slider along once
  OnePoint pressed(typical, standstill(typical, {0.05, 0, 0.6}), 3, exactly);
  EXPECT_LT(pressed.derivative_error(slip), 1e-9);
  EXPECT_LT(pressed.derivative_error(lift), 1e-9);
  OnePoint centred(typical, standstill(typical, {0, 0, 0.6}), 3, exactly);
  EXPECT_LT(centred.derivative_error(shake), 1e-9);
  centred.force(shake);
  EXPECT_EQ(centred.activity().stick(), 1);               // in the round that counts
  EXPECT_GT(std::abs(centred.derivative()[0] - 40), 1.0); // the mean hangs on the slip of the round before
}

TEST(ExactLaw, derivative_of_every_kind_of_motion) { // differences that step over a kink excluded by their rarity
  int good = 0, tried = 0;
  for (int number = 0; number < scenes; number += 3, ++tried) {
    const Scene s = scene(number);
    OnePoint law(s.point, s.rest, s.harmonics, exactly);
    const double size = *std::max_element(s.X.begin(), s.X.end());
    const double error = std::min(law.derivative_error(s.X, 1e-5 * size), law.derivative_error(s.X, 1e-6 * size));
    good += error < 1e-9;
    law.force(s.X);
    std::mt19937 random(number);
    const std::vector<double> V = random_motion(random, s.harmonics, 1), dG = law.derivative();
    std::vector<double> product(V.size());
    for (std::size_t i = 0; i < V.size(); ++i)
      for (std::size_t j = 0; j < V.size(); ++j) product[i] += dG[i * V.size() + j] * V[j];
    EXPECT_LT(deviation(law.derivative_times(V), product), 1e-12) << number;
  }
  EXPECT_GE(good, tried - 4);
}

// Along a path of motions X0 + a X1, the least a in [0, 1] at which `reached` holds.
template <class Reached> double threshold(Reached &&reached) {
  double low = 0, high = 1;
  while (high - low > 1e-15) (reached((low + high) / 2) ? high : low) = (low + high) / 2;
  return high;
}

TEST(ExactLaw, force_is_continuous_where_a_window_opens) { // of separation, of slip, of stick within slip
  const Standstill rest = standstill(typical, {0.05, 0, 0.6});
  std::vector<double> bounce(27), rub(27), ripple(27);
  bounce[1] = 0.7, bounce[19] = 0.5, bounce[24] = 0.12, bounce[26] = 0.05; // lifts off more than once
  rub[1] = 0.8, rub[4] = 0.3, rub[10] = 0.6, rub[19] = 0.15, rub[24] = 0.1;
  ripple[1] = 2, ripple[8] = 0.5; // slope of t1 turns within its slip
  const auto along = [](const std::vector<double> &X, double a) {
    std::vector<double> out = X;
    for (double &x : out) x *= a;
    return out;
  };
  const auto ripples = [&](double a) {
    std::vector<double> out = ripple;
    out[8] *= a;
    return out;
  };
  OnePoint law(typical, rest, 4, exactly);
  const auto check = [&](auto &&motion, auto &&quantity) {
    const auto at = [&](double a) {
      law.force(motion(a));
      return quantity(law.activity());
    };
    const double first = at(1e-3);
    const double a = threshold([&](double some) { return at(some) != first; });
    ASSERT_TRUE(a > 1e-3 && a < 1) << a;
    for (const double near : {1e-15, 1e-13, 1e-12}) {
      const std::vector<double> before = law.force(motion(a - near)), after = law.force(motion(a + near));
      EXPECT_LT(deviation(after, before), 1e-10) << a << " " << near;
    }
  };
  check([&](double a) { return along(bounce, a); }, [](const Activity &did) { return did.open > 0; });
  check([&](double a) { return along(bounce, a); }, [](const Activity &did) { return did.events > 4; });
  check([&](double a) { return along(rub, a); }, [](const Activity &did) { return did.slip > 0; });
  check([&](double a) { return along(rub, a); }, [](const Activity &did) { return did.events > 5; });
  check(ripples, [](const Activity &did) { return did.events > 4; });
}

TEST(ExactLaw, ends_on_whatever_it_is_given) { // zeros, ties, huge ratios: finite, and what dense samples say
  std::mt19937 random(11);
  const double few[] = {0, 0, 0, 1, -1, 0.5, 2, 1e-9, -1e9, 1e-300, 3e5};
  const auto pick = [&](int most) { return few[std::uniform_int_distribution<int>(0, most - 1)(random)]; };
  int compared = 0;
  for (int number = 0; number < 6000; ++number) {
    const int kinds = number % 4 == 0 ? 11 : 7; // mostly ties
    ContactPoint point{number % 7 ? Law::coulomb : Law::unilateral, 1, {1, 1}, {1, 1}, 0};
    if (number % 3 == 0) point.kn = std::pow(10, number % 21 - 10), point.kt = {1e6, 1e-6}, point.mu = {0, 1e-3};
    point.gap = pick(kinds);
    const Standstill rest = standstill(point, {pick(kinds), pick(kinds), pick(kinds)});
    const int harmonics = 1 + number % 4;
    std::vector<double> X(3 * coefficient_count(harmonics));
    for (double &x : X) x = pick(kinds);
    OnePoint law(point, rest, harmonics, exactly);
    const std::vector<double> G = law.force(X);
    for (const double value : G) ASSERT_TRUE(std::isfinite(value)) << number;
    for (const double value : law.derivative()) ASSERT_TRUE(std::isfinite(value)) << number;
    if (kinds == 11 || number % 3 == 0) continue;
    EXPECT_LT(deviation(G, OnePoint(point, rest, harmonics, 4096).force(X)), 1e-3) << number;
    ++compared;
  }
  EXPECT_GT(compared, 1500);
}

TEST(ExactLaw, refuses_what_is_not_a_number) {
  OnePoint law(typical, standstill(typical, {0, 0, 0.6}), 2, exactly);
  for (const double bad : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    std::vector<double> x(15, 0.1);
    x[7] = bad;
    for (const double value : law.force(x)) EXPECT_TRUE(std::isnan(value));
  }
}
