#include "contact/falling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/wide.hpp"

namespace dovetail {

namespace {

// q (q - 1) (q - 2) of the even and of the odd powers
constexpr double even_thrice[] = {0, 0, 24, 120, 336, 720, 1320, 2184};
constexpr double odd_thrice[] = {0, 6, 60, 210, 504, 990, 1716, 2730};

// c = sign * f + shift, its bound of the third derivative, and its value at t = 1.
template <int Width>
inline void take_parts(const CellPolynomial &f, double sign, double shift, CellPolynomial &c, double &third,
                       double &at_one) {
  using V = typename Vector<Width>::Real;
  V bound{}, sum{};
  for (int q = 0; q < lane_count; q += Width) {
    V even = sign * load<V>(f.even + q);
    const V odd = sign * load<V>(f.odd + q);
    if (q == 0) even[0] += shift;
    store(even, c.even + q), store(odd, c.odd + q);
    sum += even + odd;
    bound += (even < 0 ? -even : even) * load<V>(even_thrice + q) + (odd < 0 ? -odd : odd) * load<V>(odd_thrice + q);
  }
  third = sum_of(bound), at_one = sum_of(sum);
}

DOVETAIL_WIDE_PARTS(take,
                    (const CellPolynomial &f, double sign, double shift, CellPolynomial &c, double &third,
                     double &at_one),
                    (f, sign, shift, c, third, at_one))

} // namespace

Falling::Falling(const CellPolynomial &f, double sign, double shift, double size) {
  take(f, sign, shift, c_, third_, at_one_);
  tiny_ = 8 * std::numeric_limits<double>::epsilon() * (size + std::abs(shift));
}

Falling Falling::slope(const CellPolynomial &f, double sign, double size) {
  CellPolynomial slope;
  for (int q = 0; q < 8; ++q) {
    slope.even[q] = (2 * q + 1) * f.odd[q];
    slope.odd[q] = q < 7 ? (2 * q + 2) * f.even[q + 1] : 0;
  }
  return Falling(slope, sign, 0, size);
}

// In s = t^2, with e2, o2 half of second derivatives.
Falling::Value Falling::at(double t) const {
  const double s = t * t;
  double e = 0, e1 = 0, e2 = 0, o = 0, o1 = 0, o2 = 0;
  for (int q = 7; q >= 0; --q) {
    e2 = e2 * s + e1, e1 = e1 * s + e, e = e * s + c_.even[q];
    o2 = o2 * s + o1, o1 = o1 * s + o, o = o * s + c_.odd[q];
  }
  return {e + t * o, o + 2 * (t * e1 + s * o1), 2 * e1 + 8 * s * e2 + t * (6 * o1 + 8 * s * o2)};
}

DOVETAIL_WIDE double Falling::first_in_cell() const {
  int looks = most_looks;
  return search(-1, 1, at_one_, looks);
}

DOVETAIL_WIDE double Falling::first(double from, double to) const {
  const Value start = at(from);
  if (start.g < -tiny_) return from;
  if (start.g <= tiny_) { // on zero: does it rise? g >= g1 t + g2 t^2 / 2 - third t^3 / 6
    if (third_ == 0 && start.g1 == 0 && start.g2 == 0) return none;
    double safe = 0;                                                // positive up to here
    if (start.g2 > 0 && start.g1 * start.g1 < 2 * start.g2 * tiny_) // as flat as after a turning point
      safe = 1.5 * start.g2 / third_;
    if (start.g1 > 0) {
      const double by_slope = std::sqrt(3 * start.g1 / third_);
      safe = std::max(safe, start.g2 >= 0 ? by_slope : std::min(by_slope, -start.g1 / start.g2));
    }
    if (safe == 0) return from;
    from += safe;
    if (from >= to) return none;
  }
  int looks = most_looks;
  return search(from, to, to == 1 ? at_one_ : at(to).g, looks);
}

// Newton's step, of the terms up to t^6 alone: saves a look at all of them.
double Falling::improvement(double t) const {
  const double *e = c_.even, *o = c_.odd, s = t * t;
  const double value = e[0] + s * (e[1] + s * (e[2] + s * e[3])) + t * (o[0] + s * (o[1] + s * o[2]));
  const double slope = o[0] + s * (3 * o[1] + s * 5 * o[2]) + t * (2 * e[1] + s * (4 * e[2] + s * 6 * e[3]));
  return slope < 0 ? value / slope : 0;
}

// Encloses g between quadratics around the middle; halves the stretch where that does not decide.
double Falling::search(double from, double to, double at_to, int &looks) const {
  const double middle = (from + to) / 2, half = (to - from) / 2, rest = third_ * half * half * half / 6;
  const Value v = middle == 0 ? Value{c_.even[0], c_.odd[0], 2 * c_.even[1]} : at(middle);
  const bool turns = v.g2 > 0 && std::abs(v.g1) < v.g2 * half;
  const double lowest = turns ? v.g - v.g1 * v.g1 / (2 * v.g2) : v.g - std::abs(v.g1) * half + v.g2 * half * half / 2;
  if (lowest - rest >= -tiny_) return none;
  const double slope_change = std::abs(v.g2) * half + third_ * half * half / 2;
  if (v.g1 - slope_change > 0) return none; // rises throughout
  const bool falls = at_to<-tiny_, bent = std::abs(v.g2)> third_ * half;
  const bool once = v.g1 + slope_change < 0 || (bent && (falls || v.g2 < 0)); // monotone, convex or concave
  if (once || --looks <= 0) {
    if (!falls) return none;
    const double root = v.g1 * v.g1 - 2 * v.g * v.g2; // of the quadratic, where it falls
    double guess = root < 0 ? 0 : 2 * v.g / (std::sqrt(root) - v.g1);
    if (middle == 0) guess -= improvement(guess);
    return polish(from, to, std::clamp(middle + guess, from, to));
  }
  const double in_left = search(from, middle, v.g, looks);
  return in_left < none ? in_left : search(middle, to, at_to, looks);
}

// Halley's method between bounds, g(low) >= 0 > g(high).
double Falling::polish(double low, double high, double t) const {
  for (int i = 0; i < 100; ++i) {
    const Value v = at(t);
    (v.g > 0 ? low : high) = t;
    const double halley = -2 * v.g * v.g1 / (2 * v.g1 * v.g1 - v.g * v.g2), next = t + halley;
    if (!(next >= low && next <= high)) { // also where it is 0 / 0
      t = (low + high) / 2;
      if (high - low < 1e-15) return t;
      continue;
    }
    t = next;
    const double change = std::abs(halley),
                 left = change * change * change * (v.g2 * v.g2 / 4 / std::abs(v.g1) + third_ / 6);
    if (std::abs(v.g) <= tiny_ || left <= tiny_) return t;
  }
  return t;
}

} // namespace dovetail
