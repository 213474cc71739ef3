#pragma once
// Contact points under motions of every kind, by number, and what the evaluations answer.
#include <numeric>
#include <set>

#include "one_point.hpp"

namespace dovetail {

// Contact points and motions of every kind, by number: 1200 of them.
struct Scene {
  ContactPoint point;
  Standstill rest;
  int harmonics;
  std::vector<double> X;
};

constexpr int scenes = 1200;

inline Scene scene(int number) {
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

// A scene with harmonics beyond those.
inline Scene scene(int number, int harmonics) {
  Scene s = scene(number);
  std::mt19937 random(number);
  s.harmonics = harmonics;
  s.X = random_motion(random, harmonics, 0.3 + 0.2 * (number % 4), 1.5);
  return s;
}

// Changes from one state to another that a plain march over dense samples meets, over both directions.
inline std::set<std::pair<int, int>> changes(const Scene &s) {
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

inline Answers answers(const std::vector<Scene> &some, int samples) {
  if (some.empty()) return {};
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

inline std::vector<Scene> every_third(const std::vector<Scene> &some) {
  std::vector<Scene> out;
  for (std::size_t i = 0; i < some.size(); i += 3) out.push_back(some[i]);
  return out;
}

inline double largest(const std::vector<double> &of) {
  double most = 0;
  for (const double value : of) most = std::max(most, std::abs(value));
  return most;
}

// Coefficients (3, 2H+1) of the same functions, the period begun at an angle.
inline std::vector<double> begun_at(double angle, const std::vector<double> &X) {
  const int n = static_cast<int>(X.size()) / 3;
  std::vector<double> out = X;
  for (int d = 0; d < 3; ++d)
    for (int k = 1; 2 * k < n; ++k) {
      const double c = std::cos(k * angle), s = std::sin(k * angle), a = X[d * n + cosine(k)], b = X[d * n + sine(k)];
      out[d * n + cosine(k)] = a * c + b * s, out[d * n + sine(k)] = b * c - a * s;
    }
  return out;
}

inline double at(double angle, const double *coefficients, int n) {
  double sum = coefficients[0] / 2;
  for (int k = 1; 2 * k < n; ++k)
    sum += coefficients[cosine(k)] * std::cos(k * angle) + coefficients[sine(k)] * std::sin(k * angle);
  return sum;
}

inline double size(const std::vector<double> &of) {
  return std::sqrt(std::inner_product(of.begin(), of.end(), of.begin(), 0.0));
}

} // namespace dovetail
