#pragma once
// Small models and histories of contact made up for tests of stability.
#include <algorithm>
#include <cmath>
#include <complex>

#include "one_point.hpp"
#include "small_model.hpp"
#include "stability/monodromy.hpp"

namespace dovetail::testing {

/// A viscous matrix (n, n) of a few dashpots, proportional to nothing, of that size.
inline std::vector<double> dashpots(int n, double size) {
  std::vector<double> C(static_cast<std::size_t>(n) * n);
  for (int d = 0; d < 3; ++d)
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) C[i * n + j] += size / n * std::sin(1 + 2.1 * i + d) * std::sin(1 + 2.1 * j + d);
  return C;
}

/// All dofs are of contact points. K and M are multiples of 1, but for entries of relative size `coupled` everywhere.
inline DenseModel dense_scene(std::vector<ContactPoint> contact, double k, double m, const Damping &damping,
                              double coupled) {
  DenseModel model;
  model.points = static_cast<int>(contact.size());
  const int n = model.dofs();
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      model.K.push_back((i == j ? k : 0) + coupled * k * (wave(i, j) + wave(j, i)));
      model.M.push_back((i == j ? m : 0) + coupled * m * 0.3 * (wave(i, j + 9) + wave(j, i + 9)));
    }
  model.loads = {{std::vector<double>(n, 0.0), {0, 1, 0}}};
  model.damping = damping;
  model.contact = std::move(contact);
  for (const ContactPoint &point : model.contact)
    model.standstill.push_back(standstill(point, {0, 0, point.gap + 0.5}));
  return model;
}

/// The same with modes before the contact dofs that these are coupled with by their masses, as Craig & Bampton's are.
inline DenseModel with_modes(const DenseModel &model, const std::vector<double> &squares) {
  DenseModel out = model;
  out.modes = static_cast<int>(squares.size());
  const int n = out.dofs(), old = model.dofs();
  out.K.assign(n * n, 0), out.M.assign(n * n, 0), out.loads[0].vector.assign(n, 0);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int r = i - out.modes, c = j - out.modes;
      if (r >= 0 && c >= 0)
        out.K[i * n + j] = model.K[r * old + c], out.M[i * n + j] = model.M[r * old + c];
      else if (i == j)
        out.K[i * n + j] = squares[i], out.M[i * n + j] = 1;
      else if ((r < 0) != (c < 0))
        out.M[i * n + j] = 0.2 * wave(std::min(i, j), std::max(i, j));
    }
  return out;
}

/// A force on every dof, with two harmonics and a mean.
inline void shake(DenseModel &model, double force) {
  model.loads[0].fourier = {0.1, 1, 0.3, -0.2, 0.4};
  std::vector<double> &vector = model.loads[0].vector;
  for (std::size_t i = 0; i < vector.size(); ++i) vector[i] = force * wave(static_cast<int>(i), 5);
}

/// Largest distance from a value of `some` to the nearest of `all`.
inline double farthest(const std::vector<std::complex<double>> &some, const std::vector<std::complex<double>> &all) {
  double most = 0;
  for (const auto a : some) {
    double least = 1e300;
    for (const auto b : all) least = std::min(least, std::abs(a - b));
    most = std::max(most, least);
  }
  return most;
}

inline double largest_modulus(const std::vector<std::complex<double>> &values) {
  double most = 0;
  for (const auto value : values) most = std::max(most, std::abs(value));
  return most;
}

} // namespace dovetail::testing
