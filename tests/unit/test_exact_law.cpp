// The exact evaluation: closed forms, the sampled one as its samples grow denser, and whatever else it may be given.
#include <gtest/gtest.h>

#include "contact/falling.hpp"
#include "scenes.hpp"

using namespace dovetail;

TEST(ExactLaw, equals_the_sampled_one_on_every_kind_of_motion) {
  std::set<std::pair<int, int>> seen;
  int most_events = 0;
  double coarse = 0, fine = 0;
  int as_many_events = 0;
  for (int harmonics = 1; harmonics <= 7; ++harmonics) {
    std::vector<Scene> some;
    for (int number = harmonics - 1; number < scenes; number += 7) some.push_back(scene(number));
    const Answers exact = answers(some, exactly), sparse = answers(some, 1 << 10), dense = answers(some, 1 << 16),
                  densest = answers(every_third(some), 1 << 18);
    for (std::size_t i = 0; i < some.size(); ++i) {
      const std::string which = "scene " + std::to_string(harmonics - 1 + 7 * i);
      const Activity did = exact.activity[i], about = dense.activity[i];
      ASSERT_TRUE(did.events >= 0 && did.open >= 0 && did.slip > -1e-12 && did.stick() > -1e-12) << which;
      if (some[i].point.law == Law::coulomb) seen.merge(changes(some[i]));
      most_events = std::max(most_events, did.events);
      if (did.open == 0) { // else a lift-off ends a slip that no landing began
        EXPECT_EQ(did.events % 2, 0) << which;
      }
      as_many_events += did.events == about.events;
      const double at_1024 = deviation(sparse.G[i], exact.G[i]), at_65536 = deviation(dense.G[i], exact.G[i]);
      coarse += at_1024 * at_1024, fine += at_65536 * at_65536;
      EXPECT_LT(at_65536, 1e-6) << which;
      if (i % 3 == 0) { // a contact of a hundredth of the period has a hundredth of the samples
        EXPECT_LT(deviation(densest.G[i / 3], exact.G[i]), did.open < 0.97 ? 3e-8 : 1e-7) << which;
      }
      EXPECT_NEAR(did.open, about.open, 1e-3) << which;
      EXPECT_NEAR(did.slip, about.slip, 1e-3) << which;
      EXPECT_NEAR(did.dissipation, about.dissipation, 1e-6 * size(some[i].X) * size(exact.G[i])) << which;
    }
  }
  EXPECT_GT(std::log2(coarse / fine) / 12, 1.8); // order of the root mean square, over six halvings
  EXPECT_GE(most_events, 30);
  EXPECT_GT(as_many_events, 0.97 * scenes); // the rest has windows smaller than samples
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
  const Activity did = law.activity(begun_at(-0.7, x)); // the same, begun amid its stick
  EXPECT_NEAR(did.dissipation, work, 1e-12 * work);
  EXPECT_NEAR(did.slip, 1 - angle / M_PI, 1e-13);
  EXPECT_EQ(did.events, 4);
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

TEST(ExactLaw, bounce_on_one_spot) { // friction, but nothing rubs: the bound meets the force only where both are zero
  OnePoint law(typical, standstill(typical, {0.1, 0, 0.6}), 2, exactly);
  for (const double phase : {0.0, 0.7, 3.0}) {
    std::vector<double> x(15, 0.0);
    x[11] = 0.8 * std::cos(phase), x[12] = 0.8 * std::sin(phase);
    const std::vector<double> G = law.force(x);
    EXPECT_EQ(law.activity().events, 2) << phase;
    EXPECT_NEAR(law.activity().slip, 0, 1e-14) << phase;
    for (int i = 1; i < 10; ++i) EXPECT_NEAR(G[i], 0, 1e-13) << phase;
    EXPECT_NEAR(G[0], -2 * 40 * 0.1, 1e-13)
        << phase; // what t1 carries at the standstill is gone with the first lift-off
  }
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
    good += law.derivative_error(s.X, {1e-4, 1e-5, 1e-6}, largest(s.X)) < 1e-9;
    std::mt19937 random(number);
    EXPECT_LT(law.product_error(s.X, random_motion(random, s.harmonics, 1)), 1e-12) << number;
  }
  EXPECT_GE(good, tried - 4);
}

TEST(ExactLaw, rests_where_the_preload_left_it_slipping) { // on its bound to round-off, and not beyond
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform;
  for (int number = 0; number < 200; ++number) {
    ContactPoint point = typical;
    for (double *k : {&point.kn, &point.kt[0], &point.kt[1]}) *k *= std::exp(20 * uniform(random) - 10);
    for (double &mu : point.mu) mu = uniform(random);
    const double xn = point.gap + uniform(random), N = point.kn * (xn - point.gap);
    std::array<double, 3> at{0, 0, xn};
    for (int d = 0; d < 2; ++d)
      at[d] = (number >> d & 1 ? -1 : 1) * (1 + 2 * uniform(random)) * point.mu[d] * N / point.kt[d];
    const Standstill rest = standstill(point, at);
    OnePoint law(point, rest, 3, exactly);
    const std::vector<double> G = law.force(std::vector<double>(21)), dG = law.derivative();
    EXPECT_EQ(law.activity().stick(), 1) << number;
    EXPECT_EQ(law.activity().events, 0) << number;
    for (int i = 0; i < 21; ++i) {
      const double k = i < 7 ? point.kt[0] : i < 14 ? point.kt[1] : point.kn;
      EXPECT_NEAR(G[i], 0, 1e-14 * N) << number;
      for (int j = 0; j < 21; ++j) EXPECT_EQ(dG[21 * i + j], i == j ? k : 0) << number;
    }
  }
}

TEST(ExactLaw, without_friction_it_slips_for_ever) { // in one direction or both, also where nothing moves
  for (const int smooth : {1, 2, 3})
    for (const double amplitude : {0.0, 0.3, 2.0})
      for (const double bounce : {0.0, 0.2, 0.8}) {
        ContactPoint point = typical;
        for (int d = 0; d < 2; ++d)
          if (smooth >> d & 1) point.mu[d] = 0;
        std::vector<double> x(15);
        x[1] = amplitude, x[9] = 0.7 * amplitude, x[11] = bounce;
        const Standstill rest = standstill(point, {0.1, 0, 0.6});
        OnePoint law(point, rest, 2, exactly), sampled(point, rest, 2, 1 << 14);
        const std::vector<double> G = law.force(x), dG = law.derivative(), expected = sampled.force(x);
        for (int i = 0; i < 10; ++i) {
          if (!(smooth >> i / 5 & 1)) continue;
          EXPECT_EQ(G[i], 0);
          for (int j = 0; j < 15; ++j) EXPECT_EQ(dG[15 * i + j], 0);
        }
        const std::string which =
            std::to_string(smooth) + " " + std::to_string(amplitude) + " " + std::to_string(bounce);
        const Activity &did = law.activity(), &about = sampled.activity();
        EXPECT_NEAR(did.slip, 1 - did.open, 1e-15) << which;
        EXPECT_NEAR(did.open, about.open, 1e-3) << which;
        EXPECT_NEAR(did.slip, about.slip, 1e-3) << which;
        EXPECT_EQ(did.events, about.events) << which;
        EXPECT_NEAR(did.dissipation, about.dissipation, 1e-6 * (1 + did.dissipation)) << which;
        EXPECT_LT(deviation(G, expected, 1), 1e-6) << which;
        EXPECT_LT(deviation(dG, sampled.derivative()), 1e-2) << which;
      }
}

// Where a slider all but slips, against differences of the heights there by the motion.
TEST(ExactLaw, grazes_move_with_the_motion_as_they_say) {
  int compared = 0, set_by_an_event = 0;
  for (int number = 0; number < scenes && compared < 60; number += 7) {
    Scene s = scene(number, 3);
    const int n = coefficient_count(s.harmonics);
    ContactForces forces({s.point}, {s.rest}, s.harmonics, exactly);
    std::vector<double> G(s.X.size());
    const auto all = [&] {
      forces.evaluate(s.X.data(), G.data());
      return forces.grazes(0, s.X.data());
    };
    for (const Graze &graze : all()) {
      if (std::abs(graze.height) > 0.3 * graze.size) continue;
      ++compared, set_by_an_event += forces.activity()[0].events > 0;
      const double kt = graze.side * s.point.kt[graze.direction], bound = s.point.mu[graze.direction] * s.point.kn;
      const double *x = &s.X[graze.direction * n], *xn = &s.X[2 * n];
      double slope = 0; // of the edge, which is highest there
      for (int k = 1; k <= s.harmonics; ++k)
        slope += k * ((kt * x[sine(k)] - bound * xn[sine(k)]) * std::cos(k * graze.theta) -
                      (kt * x[cosine(k)] - bound * xn[cosine(k)]) * std::sin(k * graze.theta));
      EXPECT_NEAR(slope, 0, 1e-9 * graze.size) << number;
      for (const int row : {graze.direction, 2})
        for (int i = 0; i < n; ++i) {
          const double told = (row == 2 ? graze.by_n : graze.by_t)[i];
          double least = 1; // of steps: one that crosses to another order of states tells nothing
          for (const double h : {1e-4, 1e-5, 1e-6}) {
            double difference = 0, &moved = s.X[row * n + i], before = moved;
            for (const int side : {-1, 1}) {
              moved = before + side * h;
              for (const Graze &there : all())
                if (there.direction == graze.direction && there.side == graze.side &&
                    std::abs(std::remainder(there.theta - graze.theta, 2 * M_PI)) < 0.05)
                  difference += side * there.height / (2 * h);
            }
            moved = before;
            least = std::min(least, std::abs(difference - told) / std::max(graze.size, std::abs(told)));
          }
          EXPECT_LT(least, 1e-5) << number << " " << row << " " << i;
        }
    }
  }
  EXPECT_GE(compared, 60);
  EXPECT_GT(set_by_an_event, 20);
}

TEST(Falling, finds_the_zero_of_every_power) { // 0.9 - t^q: flat, but for the third derivative, up to there
  for (int q = 2; q < lane_count * 2; ++q) {
    const int half = q / 2;
    CellPolynomial f{};
    f.even[0] = 0.9;
    if (q % 2 == 1)
      f.odd[half] -= 1;
    else
      f.even[half] -= 1;
    EXPECT_NEAR(Falling(f, 1, 0, 1).first(0, 1), std::pow(0.9, 1.0 / q), 1e-13) << q;
    EXPECT_NEAR(Falling(f, 2, -0.6, 1).first(0, 1), std::pow(0.6, 1.0 / q), 1e-13) << q;
    f.even[0] = 1.1;
    EXPECT_EQ(Falling(f, 1, 0, 1).first(0, 1), Falling::none) << q;
  }
}

// Whether forces agree in each direction, or to a part of the forces at work there, to whose round-off they are known.
bool alike(const Scene &s, const std::vector<double> &G, const std::vector<double> &expected, double round_off) {
  const int n = coefficient_count(s.harmonics);
  const auto reach = [&](int d) {
    return std::accumulate(&s.X[d * n], &s.X[d * n] + n, 0.0, [](double sum, double x) { return sum + std::abs(x); });
  };
  const double normal = s.point.kn * (std::abs(s.rest.x[2]) + std::abs(s.point.gap) + reach(2));
  for (int d = 0; d < 3; ++d) {
    const double bound = d < 2 ? s.point.mu[d] * normal : normal, trial = d < 2 ? s.point.kt[d] * reach(d) : bound;
    if (trial < 1e-8 * bound) continue; // slips by less per sample than samples notice
    double worst = 0, size = 0;
    for (int i = d * n; i < (d + 1) * n; ++i)
      worst = std::max(worst, std::abs(G[i] - expected[i])), size = std::max(size, std::abs(expected[i]));
    if (!(worst <= 5e-3 * size + round_off * (bound + trial) + 1e-290)) return false; // squares of the last underflow
  }
  return true;
}

TEST(ExactLaw, ends_on_whatever_it_is_given) { // zeros, ties, huge ratios: finite, and what dense samples say
  std::mt19937 random(11);
  const double few[] = {0, 0, 0, 1, -1, 0.5, 2, 1e-9, -1e9, 1e-300, 3e5};
  const auto pick = [&](int most) { return few[std::uniform_int_distribution<int>(0, most - 1)(random)]; };
  int compared = 0;
  for (int harmonics = 1; harmonics <= 4; ++harmonics) {
    std::vector<Scene> some;
    for (int number = 0; number < 1500; ++number) {
      const int kinds = number % 4 == 0 ? 11 : 7; // mostly ties
      ContactPoint point{number % 7 ? Law::coulomb : Law::unilateral, 1, {1, 1}, {1, 1}, 0};
      if (number % 3 == 0) point.kn = std::pow(10, number % 21 - 10), point.kt = {1e6, 1e-6}, point.mu = {0, 1e-3};
      if (number % 6 == 0) point.mu[0] = 1;
      point.gap = pick(kinds);
      const Standstill rest = standstill(point, {pick(kinds), pick(kinds), pick(kinds)});
      std::vector<double> X(3 * coefficient_count(harmonics));
      for (double &x : X) x = pick(kinds);
      some.push_back({point, rest, harmonics, X});
    }
    const Answers exact = answers(some, exactly), dense = answers(some, 1 << 12);
    std::vector<Scene> sharp; // too sharp for so few samples
    std::vector<std::size_t> which;
    const auto round_off = [](std::size_t i) { return i % 4 == 0 ? 1e-12 : 1e-13; };
    for (std::size_t i = 0; i < some.size(); ++i) {
      OnePoint law(some[i].point, some[i].rest, harmonics, exactly);
      for (const double value : law.derivative(some[i].X)) ASSERT_TRUE(std::isfinite(value)) << harmonics << " " << i;
      for (const double value : exact.G[i]) ASSERT_TRUE(std::isfinite(value)) << harmonics << " " << i;
      const double open = exact.activity[i].open, some_samples = 2e-3;
      if ((open > 0 && open < some_samples) || (open < 1 && open > 1 - some_samples)) continue;
      ++compared;
      if (!alike(some[i], exact.G[i], dense.G[i], round_off(i))) sharp.push_back(some[i]), which.push_back(i);
    }
    const Answers densest = answers(sharp, 1 << 16);
    for (std::size_t i = 0; i < sharp.size(); ++i)
      EXPECT_TRUE(alike(sharp[i], exact.G[which[i]], densest.G[i], round_off(which[i])))
          << harmonics << " " << which[i];
  }
  EXPECT_GT(compared, 5500);
}

TEST(ContactForces, nothing_but_numbers_goes_through) { // any law, either evaluation; neighbours are not touched
  for (const int samples : {exactly, 32})
    for (const double bad : {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::quiet_NaN()})
      for (int place = 0; place < 15; ++place) {
        std::vector<ContactPoint> points;
        for (const Law law : {Law::coulomb, Law::cone, Law::unilateral, Law::bilateral})
          for (int twice = 0; twice < 2; ++twice) points.push_back({law, 100, {40, 40}, {0.4, 0.4}, 0.1});
        ContactForces forces(points, std::vector<Standstill>(8, standstill(points[0], {0, 0, 0.6})), 2, samples);
        std::vector<double> X(8 * 15, 0.1), G(8 * 15), expected(8 * 15);
        forces.evaluate(X.data(), expected.data());
        for (int p = 0; p < 8; p += 2) X[15 * p + place] = bad;
        for (const bool derivative : {true, false}) {
          forces.evaluate(X.data(), G.data(), derivative);
          for (int i = 0; i < 8 * 15; ++i) {
            if (i / 15 % 2)
              EXPECT_EQ(G[i], expected[i]) << i << " " << place;
            else
              EXPECT_TRUE(std::isnan(G[i])) << i << " " << place;
          }
        }
      }
}

TEST(ContactForces, blocks_of_some_coefficients_are_parts_of_all) { // in every state; bonded points, too
  int stuck = 0;
  for (int number = 0; number < scenes; number += 25)
    for (const bool bonded : {false, true}) {
      Scene s = scene(number);
      if (bonded) s.point.law = Law::bilateral;
      const int n = coefficient_count(s.harmonics);
      ContactForces forces({s.point}, {s.rest}, s.harmonics, exactly);
      std::vector<double> G(s.X.size());
      forces.evaluate(s.X.data(), G.data());
      const std::size_t places = block_places(s.point.law).size();
      std::vector<double> all(places * n * n), some(places * 4, 7.0);
      forces.write(0, all.data());
      const int which[] = {0, n - 1};
      forces.write(0, which, 2, some.data());
      for (std::size_t b = 0; b < places; ++b)
        for (int i = 0; i < 4; ++i) {
          const double wanted = all[(b * n + which[i / 2]) * n + which[i % 2]];
          EXPECT_NEAR(some[4 * b + i], wanted, 1e-12 * (1 + std::abs(wanted))) << number << " " << b << " " << i;
        }
      stuck += !bonded && forces.springs_only(0);
    }
  EXPECT_GT(stuck, 0);
}

// Forces at a standstill of their own count, too: their derivative by each parameter against differences, and weighed.
TEST(ContactForces, derivatives_by_parameters_are_those_of_the_forces) {
  int slipping = 0;
  for (const Law law : {Law::coulomb, Law::cone})
    for (const int number : {205, 333, 411, 547}) {
      Scene s = scene(number, 3);
      s.point.law = law;
      if (law == Law::cone) s.point.kt[1] = s.point.kt[0], s.point.mu[1] = s.point.mu[0];
      const Standstill rest{s.rest.x, {}, s.rest.w};
      ContactForces forces({s.point}, {rest}, s.harmonics, exactly);
      const std::size_t width = s.X.size();
      std::vector<double> weights(width), found(width);
      for (std::size_t i = 0; i < width; ++i) weights[i] = std::cos(1.0 + i);
      for (const PathParameter &parameter : all_parameters) {
        const std::string name = parameter.name;
        if (!has_points(parameter) || (law == Law::cone && (name.back() == '1' || name.back() == '2'))) continue;
        Setting slope{0, 0, 0, 0, {0, {0, 0}, {0, 0}, 0}};
        parameter.set(slope, 1);
        double least = 1; // of steps: one that crosses to another order of states tells nothing
        for (const double h : {1e-4, 1e-5, 1e-6}) {
          std::vector<double> difference(width);
          for (const int side : {-1, 1}) {
            Setting there;
            parameter.set(there, (name == "gap" ? 0 : 1) + side * h);
            forces.change({changed(s.point, there.contact)}, {rest});
            forces.evaluate(s.X.data(), found.data(), false);
            for (std::size_t i = 0; i < width; ++i) difference[i] += side * found[i] / (2 * h);
          }
          forces.change({s.point}, {rest});
          forces.evaluate(s.X.data(), found.data());
          forces.by_parameter(s.X.data(), {EquivalentMotion(Setting{}.contact, slope.contact)}, {Memory{}},
                              found.data());
          least = std::min(least, deviation(found, difference, 1e-3 * largest(difference)));
        }
        EXPECT_LT(least, 1e-5) << name << " " << number;
        const ByParameter weighed = forces.weighed(0, s.X.data(), weights.data());
        const double wanted = std::inner_product(found.begin(), found.end(), weights.begin(), 0.0);
        const auto &t = weighed.tangential_stiffness, &mu = weighed.friction;
        const double told = name == "gap"                      ? weighed.gap
                            : name == "normal_stiffness"       ? weighed.normal_stiffness
                            : name == "tangential_stiffness"   ? t[0] + t[1]
                            : name == "tangential_stiffness_1" ? t[0]
                            : name == "tangential_stiffness_2" ? t[1]
                            : name == "friction"               ? mu[0] + mu[1]
                            : name == "friction_1"             ? mu[0]
                                                               : mu[1];
        EXPECT_NEAR(told, wanted, 1e-10 * (1 + std::abs(wanted))) << name << " " << number;
        slipping += name == "friction" && wanted != 0;
      }
    }
  EXPECT_GT(slipping, 4); // of eight
}
