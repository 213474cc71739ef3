#pragma once
// The Fourier convention, written here and nowhere else (theory.md, eq 10):
//   q(t) = a0/2 + sum_{k=1..H} a_k cos(k Om t) + b_k sin(k Om t),   coefficients stored [a0, a1, b1, a2, b2, ...].
#include <vector>

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

  /// Adds weight * sum_{a <= j < b} exp(i m theta_j), m = 0..2H, to `sums` (interleaved cos, sin; 2(2H+1) numbers).
  void add_sums(int a, int b, double weight, double *sums) const;

  /// Analysis of a mask's indicator, given its sums. (2H+1)
  void indicator(const double *sums, double *coefficients) const;

  /// block += weight * Analysis diag(mask) Synthesis, given the mask's sums: Toeplitz + Hankel in them.
  /// `block` is (2H+1) x (2H+1), row-major with leading dimension `stride`.
  void add_gram(const double *sums, double weight, double *block, int stride) const;

private:
  int harmonics_, samples_;
  std::vector<double> rows_; // (N, 2H+1)
  std::vector<double> turn_; // (N, 2): cos, sin of 2 pi r / N
};

} // namespace dovetail
