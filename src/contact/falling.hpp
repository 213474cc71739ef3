#pragma once
// The first zero at which a function falls, in a cell of the grid.
#include "contact/trigonometric.hpp"

namespace dovetail {

/// g = sign * f + shift or sign * f' + shift in one cell, as a polynomial in t in [-1, 1] (CellPolynomial), and where
/// it falls through zero. Two zeros are found however close they are, unless g is below zero by no more than round-off
/// between them: then it touches and does not fall.
class Falling {
public:
  /// size: of the terms that f is a sum of, for its round-off.
  Falling(const CellPolynomial &f, double sign, double shift, double size);
  /// The same for the slope, up to a factor.
  static Falling slope(const CellPolynomial &f, double sign, double size);

  /// First t in [from, to] where g falls through zero, g being positive at `from` or rising from zero there; `from`
  /// itself if it is neither; none if g stays positive.
  double first(double from, double to) const;
  /// The same over the whole cell, where g is known not to be negative at its beginning.
  double first_in_cell() const;

  static constexpr double none = 1e300;

private:
  struct Value {
    double g, g1, g2; // with first and second derivative
  };
  static constexpr int most_looks = 200; // at one cell; two zeros take a dozen, and only round-off more
  Value at(double t) const;
  double search(double from, double to, double at_to, int &looks) const;
  double improvement(double t) const;
  double polish(double low, double high, double t) const;

  CellPolynomial c_;
  double third_;  // bound of |g'''|
  double at_one_; // g there, where many stretches end
  double tiny_;   // round-off of g
};

} // namespace dovetail
