#pragma once
// One contact point under some motion: its forces, and their derivative against differences.
#include <random>

#include "contact/contact_forces.hpp"
#include "contact/fourier.hpp"

namespace dovetail {

constexpr ContactPoint typical{Law::coulomb, 100, {40, 55}, {0.4, 0.25}, 0.1};

inline Standstill standstill(const ContactPoint &point, std::array<double, 3> x) {
  const StaticForce at_rest = static_force(point, x.data());
  return {x, at_rest.force, at_rest.w};
}

/// One contact point, held at some standstill, and what it answers to motions X (3, 2H+1).
class OnePoint {
public:
  OnePoint(const ContactPoint &point, const Standstill &rest, int harmonics, int samples)
      : point_(point), n_(coefficient_count(harmonics)), forces_({point}, {rest}, harmonics, samples) {}

  std::vector<double> force(const std::vector<double> &X) {
    std::vector<double> G(3 * n_, 7.0); // whatever was there before
    forces_.evaluate(X.data(), G.data());
    return G;
  }
  const Activity &activity() const { return forces_.activity()[0]; } ///< at the last motion

  /// d G / d X at the last motion, (3n, 3n), from the blocks.
  std::vector<double> derivative() const {
    const std::vector<BlockPlace> &places = block_places(point_.law);
    std::vector<double> blocks(places.size() * n_ * n_), full(9 * n_ * n_);
    forces_.write(0, blocks.data());
    const double *next = blocks.data();
    for (const BlockPlace place : places)
      for (int i = 0; i < n_; ++i)
        for (int j = 0; j < n_; ++j) full[(place.row * n_ + i) * 3 * n_ + place.column * n_ + j] = *next++;
    return full;
  }

  std::vector<double> derivative_times(const std::vector<double> &V) const {
    std::vector<double> out(V.size());
    forces_.multiply(V.data(), out.data());
    return out;
  }

  /// Largest relative deviation of the derivative at X from extrapolated central differences (steps h and h/2, h^4).
  double derivative_error(std::vector<double> X, double h = 1e-5) {
    const int width = 3 * n_;
    force(X);
    const std::vector<double> dG = derivative();
    std::vector<double> slope(width);
    double worst = 0, scale = 0;
    for (int col = 0; col < width; ++col) {
      const double x = X[col];
      std::fill(slope.begin(), slope.end(), 0.0);
      for (const auto &[step, weight] : {std::pair{h, -1.0 / 3}, {h / 2, 4.0 / 3}}) {
        X[col] = x + step;
        const std::vector<double> plus = force(X);
        X[col] = x - step;
        const std::vector<double> minus = force(X);
        for (int row = 0; row < width; ++row) slope[row] += weight * (plus[row] - minus[row]) / (2 * step);
      }
      X[col] = x;
      for (int row = 0; row < width; ++row) {
        worst = std::max(worst, std::abs(slope[row] - dG[row * width + col]));
        scale = std::max(scale, std::abs(slope[row]));
      }
    }
    return scale > 0 ? worst / scale : worst;
  }

private:
  ContactPoint point_;
  int n_;
  ContactForces forces_;
};

/// Harmonics of all three directions with amplitudes that fall as k^-decay.
inline std::vector<double> random_motion(std::mt19937 &random, int harmonics, double amplitude, double decay = 0) {
  std::normal_distribution<double> normal;
  const int n = coefficient_count(harmonics);
  std::vector<double> X(3 * n);
  for (int i = 0; i < 3 * n; ++i) X[i] = amplitude * normal(random) * std::pow((i % n + 1) / 2 + 1, -decay);
  return X;
}

/// max |a - b| / max |b|
inline double deviation(const std::vector<double> &a, const std::vector<double> &b) {
  double worst = 0, scale = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    worst = std::max(worst, std::abs(a[i] - b[i]));
    scale = std::max(scale, std::abs(b[i]));
  }
  return scale > 0 ? worst / scale : worst;
}

} // namespace dovetail
