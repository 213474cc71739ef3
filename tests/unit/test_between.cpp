// What a curve does between its points, estimated from those points, against the curve itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "continuation/between.hpp"

using namespace dovetail;

namespace {

using Curve = std::function<Amplitude(double)>;

// Steps between 0.5 and 1 of `step`, in an order without a pattern.
std::vector<double> places(double step) {
  std::vector<double> s = {0.013};
  for (int i = 0; s.back() < 2; ++i) s.push_back(s.back() + step * (0.75 + 0.25 * std::sin(1.7 * i * i)));
  return s;
}

// The largest distance from the cubic between two places, relative to the larger amplitude.
double true_error(const Curve &curve, double from, double to) {
  const Amplitude a = curve(from), b = curve(to);
  const double h = to - from;
  double most = 0;
  for (double x = 0.02; x < 1; x += 0.02) {
    const double y = 1 - x, cubic = y * y * (a.value * (1 + 2 * x) + h * a.slope * x) +
                                    x * x * (b.value * (3 - 2 * x) - h * b.slope * y);
    most = std::max(most, std::abs(curve(from + x * h).value - cubic));
  }
  return most / std::max(a.value, b.value);
}

struct Found {
  double largest = 0, largest_true = 0; // error
  std::vector<double> ratios;           // true / estimated
};

Found along(const Curve &curve, double step) {
  const std::vector<double> s = places(step);
  BetweenPoints between;
  between.begin(curve(s[0]));
  EXPECT_TRUE(std::isnan(between.add(s[1] - s[0], curve(s[1]))));
  Found found;
  for (std::size_t i = 2; i < s.size(); ++i) {
    const double estimate = between.add(s[i] - s[i - 1], curve(s[i])), error = true_error(curve, s[i - 1], s[i]);
    found.largest = std::max(found.largest, estimate), found.largest_true = std::max(found.largest_true, error);
    found.ratios.push_back(error / estimate);
  }
  std::sort(found.ratios.begin(), found.ratios.end());
  return found;
}

Amplitude resonance(double s) {
  const double square = (1 - s) * (1 - s) + 0.1;
  return {1 / std::sqrt(square), (1 - s) * std::pow(square, -1.5)};
}

// The same with kinks, as where contact points begin to slip.
Amplitude kinked(double s) {
  Amplitude a = resonance(s);
  for (const double at : {0.403, 0.817, 1.301}) a.value += 0.1 * std::abs(s - at), a.slope += s > at ? 0.1 : -0.1;
  return a;
}

} // namespace

TEST(BetweenPoints, knows_the_error_of_a_smooth_curve) {
  for (const double step : {0.02, 0.005}) {
    const Found found = along(resonance, step);
    EXPECT_GT(found.ratios[found.ratios.size() / 20], 0.2);
    EXPECT_LT(found.ratios[found.ratios.size() * 19 / 20], 5);
    EXPECT_NEAR(found.largest / found.largest_true, 1, 0.5);
  }
}

TEST(BetweenPoints, sees_kinks) {
  for (const double step : {0.02, 0.01, 0.005, 0.002}) {
    const Found found = along(kinked, step), smooth = along(resonance, step);
    EXPECT_GT(found.largest_true, 10 * smooth.largest_true); // it is the kinks that count
    EXPECT_GT(found.largest / found.largest_true, 0.5);
    EXPECT_LT(found.largest / found.largest_true, 2);
  }
}

TEST(BetweenPoints, goes_on_from_what_was_saved) {
  for (const Curve &curve : {Curve(resonance), Curve(kinked)})
    for (int saved_at = 1; saved_at < 5; ++saved_at) {
      const auto add = [&](BetweenPoints &to, int i) { return to.add(0.01, curve(0.38 + 0.01 * i)); };
      BetweenPoints one, other;
      one.begin(curve(0.38));
      for (int i = 1; i <= saved_at; ++i) add(one, i);
      Archive saved;
      one.archive(saved);
      Archive again(saved.fields());
      other.archive(again);
      for (int i = saved_at + 1; i < saved_at + 4; ++i) EXPECT_EQ(add(one, i), add(other, i)) << saved_at << " " << i;
    }
}

TEST(BetweenPoints, forgets) {
  BetweenPoints between;
  between.begin(kinked(0.3));
  for (const double s : {0.31, 0.32}) between.add(0.01, kinked(s));
  between.begin(kinked(0.5));
  EXPECT_TRUE(std::isnan(between.add(0.01, kinked(0.51))));
  EXPECT_FALSE(std::isnan(between.add(0.01, kinked(0.52))));
}

namespace {

struct Place {
  double s;
  Amplitude at;
};

// The cubic through two places at a third, by divided differences.
Amplitude drawn(const Place &a, const Place &b, double s) {
  const double h = b.s - a.s, d = s - a.s, mean = (b.at.value - a.at.value) / h, second = (mean - a.at.slope) / h,
               third = ((b.at.slope - mean) / h - second) / h;
  return {a.at.value + d * (a.at.slope + d * (second + (d - h) * third)),
          a.at.slope + 2 * d * second + d * (3 * d - 2 * h) * third};
}

// What add() says of the last of some places, as its comment describes it; `smooth` becomes what it took them for.
double described(const std::vector<Place> &all, double largest, bool &smooth) {
  const std::size_t n = all.size();
  smooth = false;
  if (n < 3) return std::numeric_limits<double>::quiet_NaN();
  struct Missed {
    double value, slope, fourth;
  };
  const auto missed = [&](std::size_t i) { // the cubic round place i
    const Amplitude on = drawn(all[i - 1], all[i + 1], all[i].s);
    const double value = all[i].at.value - on.value;
    return Missed{value, all[i].at.slope - on.slope,
                  value / std::pow((all[i].s - all[i - 1].s) * (all[i + 1].s - all[i].s), 2)};
  };
  const auto bend = [&](std::size_t i) { return (all[i + 1].at.slope - all[i].at.slope) / (all[i + 1].s - all[i].s); };
  const Missed now = missed(n - 2);
  const double h1 = all[n - 2].s - all[n - 3].s, h2 = all[n - 1].s - all[n - 2].s;
  const double askew = h2 * std::abs(now.slope - 2 * now.value / h1 + 2 * now.value / h2);
  const double regular = std::abs(now.value) * h2 * h2 / h1 / h1 / 16;
  double jump = std::abs(bend(n - 2) - bend(n - 3));
  if (n > 3) {
    const double quotient = now.fourth / missed(n - 3).fourth;
    smooth = quotient >= 0.125 && quotient <= 8 && askew < std::abs(now.value);
    jump = std::min(jump, std::abs(bend(n - 2) - bend(n - 4)));
  }
  const double kink = std::min(jump * h2 * h2 / 8, std::max(std::abs(now.value), askew) / 2);
  return (smooth ? regular : std::max(regular, kink)) / largest;
}

} // namespace

// Fourth derivatives that change from step to step by up to 30, slopes askew, kinks.
TEST(BetweenPoints, estimates_are_what_their_comment_says) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> part(0, 1);
  int smooth_ones = 0, rough_ones = 0;
  for (int curve = 0; curve < 300; ++curve) {
    BetweenPoints between;
    double largest = 0, fourth = 1, kinks = 0, at_kink = 0, s = part(random);
    const double askew = std::pow(10, -4 * part(random));
    const auto here = [&] {
      const double d = std::max(0.0, s - at_kink), slope = 0.2 * part(random) * askew * fourth * s * s * s;
      return Amplitude{0.3 + fourth * std::pow(s, 4) + kinks * d,
                       4 * fourth * std::pow(s, 3) + (d > 0) * kinks + slope};
    };
    for (int piece = 0; piece < 2; ++piece) {
      std::vector<Place> all{{s, here()}};
      between.begin(all[0].at);
      largest = std::max(largest, all[0].at.value);
      for (int i = 0; i < 8; ++i) {
        const double step = 0.05 + 0.2 * part(random);
        fourth *= std::pow(30, curve % 3 == 0 ? 0 : 0.2 * part(random));
        if (curve % 4 == 1 && i == 4) kinks = part(random), at_kink = s + 0.5 * step;
        s += step;
        all.push_back({s, here()});
        largest = std::max(largest, all.back().at.value);
        bool smooth;
        const double wanted = described(all, largest, smooth), found = between.add(step, all.back().at);
        if (all.size() < 3) {
          EXPECT_TRUE(std::isnan(found));
          continue;
        }
        EXPECT_NEAR(found, wanted, 1e-7 * wanted + 1e-14) << curve << " " << piece << " " << i;
        if (all.size() > 3) ++(smooth ? smooth_ones : rough_ones);
      }
    }
  }
  EXPECT_GT(smooth_ones, 300);
  EXPECT_GT(rough_ones, 300);
}
