// What a curve does between its points, estimated from those points, against the curve itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
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
  BetweenPoints one, other;
  one.begin(kinked(0.3));
  for (const double s : {0.31, 0.33, 0.34}) one.add(0.01, kinked(s));
  Archive saved;
  one.archive(saved);
  Archive again(saved.fields());
  other.archive(again);
  for (const double s : {0.39, 0.41, 0.43}) EXPECT_EQ(one.add(0.02, kinked(s)), other.add(0.02, kinked(s)));
}

TEST(BetweenPoints, forgets) {
  BetweenPoints between;
  between.begin(kinked(0.3));
  for (const double s : {0.31, 0.32}) between.add(0.01, kinked(s));
  between.begin(kinked(0.5));
  EXPECT_TRUE(std::isnan(between.add(0.01, kinked(0.51))));
  EXPECT_FALSE(std::isnan(between.add(0.01, kinked(0.52))));
}
