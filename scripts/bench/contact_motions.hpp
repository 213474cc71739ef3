#pragma once
// Random motions of contact points, sorted by what the points do.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "contact/exact_law.hpp"
#include "contact/fourier.hpp"

namespace dovetail {

// What the motions of a kind have in common, as the exact evaluation finds it.
struct Kind {
  const char *name;
  bool opens;
  bool clear;      // stuck, and amplitudes alone are enough to show it
  int least, most; // events per period
};
constexpr Kind kinds[] = {{"stuck", false, true, 0, 0},
                          {"nearly slips", false, false, 0, 0}, // stuck too, but instants have to be looked for
                          {"simple slip", false, false, 4, 8},
                          {"slip", false, false, 8, 20},
                          {"separation", true, false, 4, 30}};

// Whether every tangential force stays within its bound whatever the phases of the harmonics are.
inline bool clearly_stuck(const ContactPoint &point, const Standstill &standstill, const double *X, int harmonics) {
  const int n = coefficient_count(harmonics);
  const double *normal = X + 2 * n;
  for (int d = 0; d < 2; ++d)
    for (const int side : {1, -1}) {
      const double *tangential = X + d * n, kt = side * point.kt[d], mu_kn = point.mu[d] * point.kn;
      double most = kt * (tangential[0] / 2 + standstill.x[d] - standstill.w[d]) -
                    mu_kn * (normal[0] / 2 + standstill.x[2] - point.gap);
      for (int k = 1; k <= harmonics; ++k)
        most += std::hypot(kt * tangential[cosine(k)] - mu_kn * normal[cosine(k)],
                           kt * tangential[sine(k)] - mu_kn * normal[sine(k)]);
      if (most > 0) return false;
    }
  return true;
}

// Of four motions that slip each has its number of events in another quarter of the range, else most would have few.
inline bool belongs(const Kind &kind, int number, bool clear, const Activity &did, const Linearisation &linear) {
  const double wide = kind.opens ? kind.most - kind.least : (kind.most - kind.least) / 4.0;
  const double least = kind.least + (kind.opens ? 0 : number % 4 * wide);
  const bool moved = did.slip > 0 || linear.begin() != linear.end(); // if only before the period that counts
  return (did.open > 0) == kind.opens && clear == kind.clear && moved == (kind.most > 0) && did.events >= least &&
         did.events <= least + wide;
}

struct Motions {
  std::vector<ContactPoint> points;
  std::vector<Standstill> standstill;
  std::vector<double> X;       // (points, 3, 2H+1)
  double events = 0, runs = 0; // means: of events, and of stick intervals that one of them began
  double open = 0, slip = 0;   // mean shares of the period

  int size() const { return static_cast<int>(points.size()); }
};

// Random points pressed by about five, and motions with harmonics that decay as k^-1.5: tried until they do what the
// kind asks for.
inline Motions random_motions(const Kind &kind, int harmonics, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const int n = coefficient_count(harmonics);
  ExactLaw law(harmonics);
  Linearisation linear;
  Motions out;
  std::vector<double> X(3 * n), G(3 * n);
  for (long tries = 0; out.size() < count; ++tries) {
    if (tries > 20000L * count) {
      std::fprintf(stderr, "no motion of kind %s with %d harmonics was found\n", kind.name, harmonics);
      std::exit(1);
    }
    const ContactPoint point{
        Law::coulomb, between(80, 160), {between(20, 60), between(20, 60)}, {between(0.2, 0.5), between(0.2, 0.5)}, 0};
    const double at_rest[] = {between(-1, 1), between(-1, 1), between(4, 6)};
    const StaticForce rest = static_force(point, at_rest);
    const Standstill standstill{{at_rest[0], at_rest[1], at_rest[2]}, rest.force, rest.w};
    for (int d = 0; d < 3; ++d) {
      const double slack = d == 2 ? at_rest[2] : point.mu[d] * rest.force[2] / point.kt[d];
      const double amplitude = slack * (d == 2 && kind.opens ? between(0.5, 3) : std::exp(between(-3.5, 1)));
      for (int i = 0; i < n; ++i) X[d * n + i] = amplitude * normal(random) * std::pow(std::max(1, (i + 1) / 2), -1.5);
      X[d * n] *= 0.2;
    }
    Activity did;
    law.evaluate(point, standstill, X.data(), G.data(), did, linear);
    const bool clear = clearly_stuck(point, standstill, X.data(), harmonics);
    if (!belongs(kind, out.size(), clear, did, linear)) continue;
    out.points.push_back(point);
    out.standstill.push_back(standstill);
    out.X.insert(out.X.end(), X.begin(), X.end());
    const double share = 1.0 / count;
    out.events += share * did.events, out.open += share * did.open, out.slip += share * did.slip;
    out.runs += share * (linear.end() - linear.begin());
  }
  return out;
}

// The motion that begins a part of the period later.
inline std::vector<double> later(const std::vector<double> &X, int harmonics, double angle) {
  std::vector<double> out = X;
  const int n = coefficient_count(harmonics);
  for (std::size_t row = 0; row < X.size(); row += n)
    for (int k = 1; k <= harmonics; ++k) {
      const double c = std::cos(k * angle), s = std::sin(k * angle), a = X[row + cosine(k)], b = X[row + sine(k)];
      out[row + cosine(k)] = a * c + b * s;
      out[row + sine(k)] = b * c - a * s;
    }
  return out;
}

} // namespace dovetail
