#pragma once
// The Fourier convention, written here and nowhere else (docs/theory/equations.md, eq 10):
//   q(t) = a0/2 + sum_{k=1..H} a_k cos(k Om t) + b_k sin(k Om t),   coefficients stored [a0, a1, b1, a2, b2, ...].
#include <cstddef>
#include <vector>

#include "contact/wide.hpp"

namespace dovetail {

/// Places of a harmonic's coefficients in a row of 2H+1.
constexpr int coefficient_count(int harmonics) { return 2 * harmonics + 1; }
constexpr int cosine(int k) { return k == 0 ? 0 : 2 * k - 1; }
constexpr int sine(int k) { return 2 * k; } // k >= 1

/// N equidistant instants theta_j = 2 pi j / N of the period, N >= 2H+1.
class Fourier {
public:
  Fourier(int harmonics, int samples);

  int harmonics() const { return harmonics_; }
  int samples() const { return samples_; }
  int size() const { return coefficient_count(harmonics_); } ///< 2H+1

  /// Row j of the synthesis: q(theta_j) = row(j) . coefficients. (2H+1)
  const double *row(int j) const { return &rows_[static_cast<std::size_t>(j) * size()]; }

  void synthesise(const double *coefficients, double *values) const; ///< (2H+1) -> (N)
  void analyse(const double *values, double *coefficients) const; ///< (N) -> (2H+1), a_k = 2/N sum q_j cos(k theta_j)

private:
  int harmonics_, samples_;
  std::vector<double> rows_; // (N, 2H+1)
};

/// Means over the period of masks of samples: the mask that is 1 at the samples before j (j = 0..N), times cos(m
/// theta), m = 0..2H, and then times sin(m theta). The mask of samples a <= j < b has at(b) - at(a). (2 (2H+1))
class MaskTable {
public:
  MaskTable(int harmonics, int samples);
  const double *at(int j) const { return &means_[static_cast<std::size_t>(j) * 2 * size_]; }

private:
  int size_;                  // 2H+1
  std::vector<double> means_; // (N+1, 2, 2H+1)
};

/// Synthesis and analysis of series side by side in lanes, at a quarter (N odd: half) of the plain cost: sine and
/// cosine are odd and even about the half period, and harmonics of either parity about the quarter. Holds scratch
/// memory.
class WideFourier {
public:
  WideFourier(int harmonics, int samples);

  /// coefficients (rows, 2H+1), values (rows, N); one row or three.
  void synthesise(int rows, const Lanes *coefficients, Lanes *values);
  void analyse(int rows, const Lanes *values, Lanes *coefficients);

private:
  int harmonics_, samples_;
  int folded_, width_;        // samples that the symmetries leave; harmonics, padded to whole steps of four, times two
  std::vector<double> turns_; // (folded, width): cos, sin of k theta_j
  LaneArray<double> packed_;  // (width / 2, rows, 2): coefficients a, b of each harmonic and row
  LaneArray<double> sums_;    // (2, some of folded, rows, 2): of mirrored samples, for either parity of k
};

} // namespace dovetail
