#include "modal/window.hpp"

#include <petscsys.h>
// needs the one above
#include <petscblaslapack.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "contact/fourier.hpp"

namespace dovetail {
namespace {

constexpr double enough = 1e-10; // of a wave's square

} // namespace

// By Cholesky's method with pivots: L L^T is the matrix of the waves' products in the window. Then L = weights^T L_p,
// L_p its rows of those waves.
Window window_of(const MaskMeans &closed, std::size_t most) {
  PetscBLASInt n = static_cast<PetscBLASInt>(closed.cosine.size()), one = 1, rank = 0;
  const auto product = [&](int i, int j) { // symmetric
    return closed.gram(i, j) * (i == j ? 1 : i == 0 ? M_SQRT1_2 : j == 0 ? M_SQRT2 : 1);
  };
  Window window;
  std::vector<double> L, left(n), row;
  for (int i = 0; i < n; ++i) left[i] = product(i, i);
  const double minus = -1, plus = 1;
  for (;; ++rank) {
    const auto largest = std::max_element(left.begin(), left.end());
    if (!(*largest > enough * closed.cosine[0])) break;
    if (static_cast<std::size_t>(rank) == most) return {};
    const int j = static_cast<int>(largest - left.begin());
    window.waves.push_back(j);
    L.resize(static_cast<std::size_t>(n) * (rank + 1));
    double *column = &L[static_cast<std::size_t>(n) * rank];
    for (int i = 0; i < n; ++i) column[i] = product(i, j);
    row.resize(rank);
    for (int q = 0; q < rank; ++q) row[q] = L[static_cast<std::size_t>(n) * q + j];
    if (rank > 0) BLASgemv_("N", &n, &rank, &minus, L.data(), &n, row.data(), &one, &plus, column, &one);
    const double scale = 1 / std::sqrt(*largest);
    for (int i = 0; i < n; ++i) column[i] *= scale, left[i] -= column[i] * column[i];
    left[j] = 0;
  }
  const std::size_t r = rank;
  std::vector<double> corner(r * r);
  for (std::size_t q = 0; q < r; ++q)
    for (std::size_t i = 0; i < r; ++i) corner[q * r + i] = L[n * q + window.waves[i]];
  window.weights = std::move(L);
  if (rank > 0) BLAStrsm_("R", "L", "N", "N", &n, &rank, &plus, corner.data(), &rank, window.weights.data(), &n);
  return window;
}

Window whole_window(int harmonics) {
  const std::size_t n = coefficient_count(harmonics);
  Window window;
  window.waves.resize(n), window.weights.assign(n * n, 0);
  std::iota(window.waves.begin(), window.waves.end(), 0);
  for (std::size_t i = 0; i < n; ++i) window.weights[i * n + i] = 1;
  return window;
}

} // namespace dovetail
