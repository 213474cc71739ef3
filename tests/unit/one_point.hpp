#pragma once
// One contact point under some motion: its forces, and their derivative against differences.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include "contact/contact_forces.hpp"
#include "contact/fourier.hpp"

namespace dovetail {

constexpr ContactPoint typical{Law::coulomb, 100, {40, 55}, {0.4, 0.25}, 0.1};

inline Standstill standstill(const ContactPoint &point, std::array<double, 3> x) {
  const StaticForce at_rest = static_force(point, x.data());
  return {x, at_rest.force, at_rest.w};
}

/// d G / d X (3n, 3n) from the blocks that Linearisation::write gives.
template <class Write> std::vector<double> spread(Law law, int n, const Write &write) {
  const std::vector<BlockPlace> &places = block_places(law);
  std::vector<double> blocks(places.size() * n * n), full(9 * n * n);
  write(blocks.data());
  const double *next = blocks.data();
  for (const BlockPlace place : places)
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) full[(place.row * n + i) * 3 * n + place.column * n + j] = *next++;
  return full;
}

/// max |a - b| / max |b| of the worst of three directions, each against its own size; arrays (3, anything). Directions
/// smaller than `least` count as that large.
inline double deviation(const std::vector<double> &a, const std::vector<double> &b, double least = 0) {
  const std::size_t third = a.size() / 3;
  double most = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    double worst = 0, scale = least;
    for (std::size_t i = d * third; i < (d + 1) * third; ++i) {
      worst = std::max(worst, std::abs(a[i] - b[i]));
      scale = std::max(scale, std::abs(b[i]));
      if (std::isnan(a[i] - b[i])) return a[i] - b[i];
    }
    most = std::max(most, scale > 0 ? worst / scale : worst);
  }
  return most;
}

/// One contact point, held at some standstill, and what it answers to motions X (3, 2H+1).
class OnePoint {
public:
  OnePoint(const ContactPoint &point, const Standstill &rest, int harmonics, int samples)
      : point_(point), n_(coefficient_count(harmonics)), forces_({point}, {rest}, harmonics, samples) {}

  std::vector<double> force(const std::vector<double> &X, bool derivative = true) {
    std::vector<double> G(3 * n_, 7.0); // whatever was there before
    forces_.evaluate(X.data(), G.data(), derivative);
    return G;
  }
  const Activity &activity() const { return forces_.activity()[0]; } ///< at the last motion
  const Activity &activity(const std::vector<double> &X) {
    force(X, false);
    return activity();
  }

  /// d G / d X at the last motion, (3n, 3n), from the blocks.
  std::vector<double> derivative() const {
    return spread(point_.law, n_, [&](double *blocks) { forces_.write(0, blocks); });
  }
  std::vector<double> derivative(const std::vector<double> &X) {
    force(X);
    return derivative();
  }

  std::vector<double> derivative_times(const std::vector<double> &V) const {
    std::vector<double> out(V.size());
    forces_.multiply(V.data(), out.data());
    return out;
  }

  /// Deviation of products with the derivative at X from products with its blocks.
  double product_error(const std::vector<double> &X, const std::vector<double> &V) {
    const std::vector<double> dG = derivative(X);
    std::vector<double> product(V.size());
    for (std::size_t i = 0; i < V.size(); ++i)
      for (std::size_t j = 0; j < V.size(); ++j) product[i] += dG[i * V.size() + j] * V[j];
    return deviation(derivative_times(V), product);
  }

  /// Deviation of the derivative at X from extrapolated central differences (steps h and h/2, h^4): of the columns
  /// numbered, else of all.
  double derivative_error(std::vector<double> X, double h = 1e-5, std::vector<int> columns = {}) {
    const int width = 3 * n_;
    const std::vector<double> dG = derivative(X);
    if (columns.empty()) {
      columns.resize(width);
      std::iota(columns.begin(), columns.end(), 0);
    }
    const std::size_t count = columns.size();
    std::vector<double> slopes(width * count), found(width * count);
    for (std::size_t c = 0; c < count; ++c) {
      double &x = X[columns[c]];
      const double at = x;
      for (const auto &[step, weight] : {std::pair{h, -1.0 / 3}, {h / 2, 4.0 / 3}}) {
        x = at + step;
        const std::vector<double> plus = force(X, false);
        x = at - step;
        const std::vector<double> minus = force(X, false);
        for (int row = 0; row < width; ++row) slopes[row * count + c] += weight * (plus[row] - minus[row]) / (2 * step);
      }
      x = at;
      for (int row = 0; row < width; ++row) found[row * count + c] = dG[row * width + columns[c]];
    }
    double most = 0;
    for (const double slope : slopes) most = std::max(most, std::abs(slope));
    return deviation(found, slopes, 0.01 * most); // less is at the mercy of the differences' round-off
  }

  /// The same, the smallest of several steps' (times `size`): one that crosses to another order of states tells
  /// nothing, and small ones drown in round-off.
  double derivative_error(const std::vector<double> &X, std::initializer_list<double> steps, double size,
                          const std::vector<int> &columns = {}) {
    double least = std::numeric_limits<double>::infinity();
    for (const double step : steps) least = std::min(derivative_error(X, step * size, columns), least);
    return least;
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

} // namespace dovetail
