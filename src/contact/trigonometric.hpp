#pragma once
// Trigonometric polynomials f(theta) = a0/2 + sum_{k=1..H} a_k cos k theta + b_k sin k theta: sampled on a grid, and
// expanded in the cells of that grid, where an ordinary polynomial equals them to round-off.
#include <array>
#include <memory>
#include <vector>

#include "contact/wave_transform.hpp"
#include "contact/wide.hpp"

namespace dovetail {

/// cos m theta and sin m theta, m = 0 .. 2H, at one instant. Room is rounded up to whole vectors.
struct Instant {
  double theta = 0;
  std::vector<double> cosine, sine;
  void set_zero(int count);
};

/// A polynomial in t = (theta - middle of a cell) / (half its width), |t| <= 1: even(t^2) + t odd(t^2).
struct alignas(64) CellPolynomial {
  double even[8], odd[8];
};

class Trigonometric;

/// The period cut into equal cells, at most an eighth of the shortest wave wide.
class Grid {
public:
  explicit Grid(int harmonics);

  const int cells;
  const int ends;     ///< cells + 1, rounded up: the room for values at the ends of the cells
  const double width; ///< of a cell
  double middle(int cell) const { return (cell + 0.5) * width; }

  /// f and f' at the ends of the cells from the first to the last, or of all, in (ends) each, from coefficients [a0,
  /// a1, b1, ...].
  void sample(const double *coefficients, int first, int last, double *value, double *slope) const;
  bool samples_all() const { return transform_ != nullptr; } ///< whatever is asked for
  /// f in a cell; truncated where its terms are below round-off.
  void expand(const Trigonometric &f, int cell, CellPolynomial &out) const;
  /// The instant at t in a cell (of the periods that follow, too).
  void find(long cell, double t, Instant &instant) const;

private:
  int harmonics_, stride_, powers_;
  std::unique_ptr<WaveTransform> transform_; // of many harmonics, in place of:
  LaneArray<double> ends_;                   // (H, 2, ends) cosines and sines at the ends of the cells
  LaneArray<double> middles_;                // (cells, 2, powers) and in the middles, to twice the harmonics
  LaneArray<double> taylor_;                 // (stride, 2, 8) even and odd terms of exp(i k half t)
};

class Trigonometric {
public:
  explicit Trigonometric(int harmonics);

  /// f = p * x + q * y, from their coefficients [a0, a1, b1, ...].
  void combine(double p, const double *x, double q, const double *y);

  double mean() const { return cosine_.values()[0]; }
  double at(const Instant &instant) const;
  double slope_at(const Instant &instant) const;
  /// Upper bound of |d^order f / d theta^order|, order 0 to 3, the mean left out.
  double bound(int order) const { return bound_[order]; }

private:
  friend class Grid;
  int harmonics_;
  LaneArray<double> cosine_, sine_; // a_k, b_k; the mean first; zero beyond H
  std::array<double, 4> bound_{};
};

} // namespace dovetail
