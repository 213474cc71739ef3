// The exact evaluation where states begin and end: windows that just open, other beginnings of the period, many
// harmonics.
#include <gtest/gtest.h>

#include "scenes.hpp"

using namespace dovetail;

// Along a path of motions X0 + a X1, the least a in [0, 1] at which `reached` holds.
template <class Reached> double threshold(Reached &&reached) {
  double low = 0, high = 1;
  while (high - low > 1e-15) (reached((low + high) / 2) ? high : low) = (low + high) / 2;
  return high;
}

TEST(ExactWindows, force_is_continuous_where_a_window_opens) { // of separation, of slip, of stick within slip
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

// Beginnings of the period that are nothing special, borders of cells, and instants at which the contact lifts off or
// lands, or a slider slips for the last time before it turns.
std::vector<double> beginnings(const Scene &s) {
  const int n = coefficient_count(s.harmonics), cells = std::max(64, 8 * s.harmonics);
  std::vector<double> angles{1.0, 4.4, 2 * M_PI / cells, 2 * M_PI / cells * (cells / 3)}, p(&s.X[2 * n], &s.X[3 * n]);
  p[0] += 2 * (s.rest.x[2] - s.point.gap);
  std::vector<double> push(n); // slope of the edge that pushes t1 forth
  for (int k = 1; k <= s.harmonics; ++k) {
    const auto edge = [&](int i) { return s.point.kt[0] * s.X[i] - s.point.mu[0] * s.point.kn * p[i]; };
    push[cosine(k)] = k * edge(sine(k)), push[sine(k)] = -k * edge(cosine(k));
  }
  for (const std::vector<double> &f : {p, push})
    for (int j = 0, found = 0; j < 400 && found < 2; ++j) {
      double low = 2 * M_PI * j / 400, high = 2 * M_PI * (j + 1) / 400;
      const bool above = at(low, f.data(), n) > 0;
      if (above == (at(high, f.data(), n) > 0)) continue;
      while (high - low > 1e-15)
        (at((low + high) / 2, f.data(), n) > 0) == above ? low += (high - low) / 2 : high -= (high - low) / 2;
      angles.push_back(low), ++found;
    }
  return angles;
}

TEST(ExactWindows, period_may_begin_anywhere) { // one round from w_p is enough to forget where that was
  int tried = 0, good = 0, as_many_events = 0;
  std::mt19937 random(3);
  for (int number = 0; number < scenes; number += 4) {
    const Scene s = number % 40 ? scene(number) : scene(number, 12 + number % 7);
    OnePoint law(s.point, s.rest, s.harmonics, exactly);
    const std::vector<double> V = random_motion(random, s.harmonics, 1), G = law.force(s.X),
                              JV = law.derivative_times(V);
    const Activity did = law.activity();
    for (const double angle : beginnings(s)) {
      const double off = deviation(law.force(begun_at(angle, s.X)), begun_at(angle, G)),
                   J_off = deviation(law.derivative_times(begun_at(angle, V)), begun_at(angle, JV));
      EXPECT_LT(off, 1e-9) << number << " " << angle;
      ++tried, good += off < 1e-11 && J_off < 1e-11, as_many_events += law.activity().events == did.events;
      EXPECT_NEAR(law.activity().open, did.open, 1e-9) << number << " " << angle;
      EXPECT_NEAR(law.activity().slip, did.slip, 1e-9) << number << " " << angle;
      EXPECT_NEAR(law.activity().dissipation, did.dissipation, 1e-10 * size(s.X) * size(G)) << number << " " << angle;
    }
  }
  EXPECT_GE(good, tried) << tried;
  EXPECT_EQ(as_many_events, tried);
}

// Integral of f (a function of the angle) from a to b, by Gauss's five points on so many pieces.
template <class F> double integral(F &&f, double a, double b, int pieces = 1) {
  constexpr double at[] = {0, 0.5384693101056831, 0.9061798459386640},
                   weight[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const double half = (b - a) / pieces / 2;
  double sum = 0;
  for (int piece = 0; piece < pieces; ++piece) {
    const double middle = a + (2 * piece + 1) * half;
    sum += weight[0] * f(middle);
    for (int i = 1; i < 3; ++i) sum += weight[i] * (f(middle - half * at[i]) + f(middle + half * at[i]));
  }
  return sum * half;
}

// Row i of the analysis of f where it is not zero.
template <class F> double analysed(int i, F &&f, double a, double b, int pieces = 1) {
  const auto wave = [&](double angle) {
    const int k = (i + 1) / 2;
    return i % 2 ? std::cos(k * angle) : i ? std::sin(k * angle) : 1;
  };
  return integral([&](double angle) { return wave(angle) * f(angle); }, a, b, pieces) / M_PI;
}

TEST(ExactWindows, windows_of_separation_down_to_nothing) { // n = m + cos H theta opens H times, for a part of a cell
  ContactPoint point = typical;
  point.law = Law::unilateral, point.gap = 0;
  std::mt19937 random(5);
  for (const int H : {10, 40})
    for (const double phase : {0.0, M_PI, 0.4, 2.0})
      for (const double part : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
        const int n = coefficient_count(H);
        const double wide = part * 2 * M_PI / (8 * H), m = std::cos(H * wide / 2);
        OnePoint law(point, standstill(point, {0, 0, m}), H, exactly);
        std::vector<double> x(3 * n);
        x[2 * n + cosine(H)] = std::cos(phase), x[2 * n + sine(H)] = std::sin(phase);
        const Activity did = law.activity(x);
        const std::string which = "H " + std::to_string(H) + " phase " + std::to_string(phase) + " part " +
                                  std::to_string(part * 1e6) + "e-6";
        const double blur = 2e-15 * (2 + H) / M_PI / std::sin(H * wide / 2); // round-off of n by its slope
        EXPECT_EQ(did.events, 2 * H) << which;
        EXPECT_NEAR(did.open, part / 8, blur) << which;
        const std::vector<double> V = random_motion(random, H, 1);
        law.force(x);
        const std::vector<double> JV = law.derivative_times(V);
        const auto v = [&](double angle) { return at(angle, &V[2 * n], n); };
        for (int i = 0; i < n; ++i) {
          double expected = V[2 * n + i];
          for (int wave = 0; wave < H; ++wave) {
            const double middle = (M_PI + phase + 2 * M_PI * wave) / H;
            expected -= analysed(i, v, middle - wide / 2, middle + wide / 2);
          }
          EXPECT_NEAR(JV[2 * n + i], 100 * expected, 100 * (1e-12 + 10 * blur)) << which;
        }
        if (part < 1e-2) continue; // differences over so small a step: 1e-7 is their round-off
        EXPECT_LT(law.derivative_error(x, 0.01 * (1 - m), {2 * n, 2 * n + 1, 2 * n + cosine(H), 2 * n + sine(H)}), 5e-7)
            << which;
      }
}

TEST(ExactWindows, windows_of_slip_down_to_nothing) { // t1 = X cos H theta slips at either end, for a part of a cell
  const double mu_N = 0.4 * 100 * 0.5, kt = 40, mu_kn = 0.4 * 100;
  std::mt19937 random(6);
  for (const int H : {10, 40})
    for (const double phase : {0.0, 0.4, 2.0})
      for (const double part : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
        const int n = coefficient_count(H);
        const double wide = part * 2 * M_PI / (8 * H), X = 2 * mu_N / kt / (1 + std::cos(H * wide));
        OnePoint law(typical, standstill(typical, {0, 0, 0.6}), H, exactly);
        std::vector<double> x(3 * n);
        x[cosine(H)] = X * std::cos(phase), x[sine(H)] = X * std::sin(phase);
        const Activity did = law.activity(x);
        const std::string which = "H " + std::to_string(H) + " phase " + std::to_string(phase) + " part " +
                                  std::to_string(part * 1e6) + "e-6";
        const double blur = 2e-15 * (2 + H) / M_PI / std::sin(H * wide);
        EXPECT_EQ(did.events, 4 * H) << which;
        EXPECT_NEAR(did.slip, part / 4, blur) << which;
        const std::vector<double> V = random_motion(random, H, 1);
        law.force(x);
        const std::vector<double> JV = law.derivative_times(V);
        const auto t = [&](double angle) { return at(angle, &V[0], n); };
        const auto p = [&](double angle) { return at(angle, &V[2 * n], n); };
        for (const int i : {0, 1, 2, 7, cosine(H), sine(H)}) {
          double expected = 0;
          for (int end = 0; end < 2 * H; ++end) { // turns at `top`, the other way next
            const double top = (phase + M_PI * end) / H, next = top + M_PI / H, side = end % 2 ? -1 : 1;
            const double set = -kt * t(top) + side * mu_kn * p(top);
            expected += analysed(
                i, [&](double angle) { return kt * t(angle) + set; }, top, next - wide, 16);
            expected += analysed(
                i, [&](double angle) { return side * mu_kn * p(angle); }, top - wide, top);
          }
          EXPECT_NEAR(JV[i], expected, 100 * (1e-11 + 10 * blur)) << which << " row " << i;
        }
        if (part < 1e-2) continue; // differences over so small a step: 1e-7 is their round-off
        EXPECT_LT(law.derivative_error(x, 0.01 * (X - mu_N / kt), {0, 1, cosine(H), sine(H), 2 * n, 2 * n + 3}), 5e-7)
            << which;
      }
}

TEST(ExactWindows, force_is_continuous_where_many_windows_open) { // all at once, under friction
  for (const int H : {10, 40}) {
    const int n = coefficient_count(H);
    std::vector<double> x(3 * n);
    x[cosine(1)] = 0.6, x[sine(2)] = 0.2, x[n + cosine(3)] = 0.3, x[2 * n + cosine(H)] = 0.8, x[2 * n + sine(H)] = 0.6;
    const auto force = [&](double depth) {
      OnePoint law(typical, standstill(typical, {0.05, 0, 1.1 - depth}), H, exactly);
      std::vector<double> G = law.force(x, false);
      if (depth < 0) { // never open
        EXPECT_EQ(law.activity().events % 2, 0) << H << " " << depth;
      }
      EXPECT_EQ(law.activity().open > 0, depth > 1e-13) << H << " " << depth;
      for (int d = 0; d < 3; ++d) G[d * n] += 2 * standstill(typical, {0.05, 0, 1.1 - depth}).force[d];
      return G;
    };
    for (const double depth : {1e-11, 1e-12, 3e-13})
      EXPECT_LT(deviation(force(depth), force(-depth)), 100 * depth) << H << " " << depth;
  }
}

TEST(ExactWindows, many_harmonics) {
  for (const int H : {8, 9, 16, 40, 100}) {
    std::vector<Scene> some;
    for (int number = 0; number < (H < 40 ? 16 : 6); ++number) some.push_back(scene(7 * number + 1, H));
    const Answers exact = answers(some, exactly), dense = answers(some, H < 100 ? 1 << 16 : 1 << 14);
    std::mt19937 random(H);
    int good = 0;
    for (std::size_t i = 0; i < some.size(); ++i) {
      const Scene &s = some[i];
      EXPECT_LT(deviation(dense.G[i], exact.G[i]), H < 100 ? 1e-6 : 16e-6) << H << " " << i;
      if (exact.activity[i].open == 0) {
        EXPECT_EQ(exact.activity[i].events % 2, 0) << H << " " << i;
      }
      OnePoint law(s.point, s.rest, H, exactly);
      std::vector<int> columns(3 * coefficient_count(H));
      std::iota(columns.begin(), columns.end(), 0);
      std::shuffle(columns.begin(), columns.end(), random);
      if (H >= 16) columns.resize(12);
      good += law.derivative_error(s.X, {1e-4, 1e-5, 1e-6}, 1, columns) < 1e-8;
      EXPECT_LT(law.product_error(s.X, random_motion(random, H, 1)), 1e-12) << H << " " << i;
    }
    EXPECT_GE(good, static_cast<int>(some.size()) - 1) << H;
  }
}
