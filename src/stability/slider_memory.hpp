#pragma once
// What sliders remember of a small change exp(lambda t) p(t) of the motion. Where one sticks since t_0, the amplitude
// of its force is
//   T = k_t x - v,  v(t) = exp(-lambda (t - t_0)) (k_t x_t + by_n x_n)(t_0),
// and Hill's problem is no polynomial of lambda. But v is what d v / d t = -lambda v makes of its value at t_0, and
// in Legendre polynomials over the stick that is linear in lambda, for a few unknowns more.
#include "stability/waves.hpp"

namespace dovetail {

class SliderMemory {
public:
  SliderMemory() = default; ///< of nothing
  /// Of waves p whose coefficients for the contact points begin at `first`.
  SliderMemory(const std::vector<ContactHistory::Hold> &holds, Waves waves, int harmonics, int first);

  int size() const { return terms * static_cast<int>(sticks_.size()); } ///< of c: of each stick, v / k_t
  /// With lambda / Omega = exponent_shift + t, from c t: contact forces are those by the blocks for a lag of
  /// exponent_shift less what push adds to `force`, and c is what follows.
  void push(const double *ct, double *force) const;
  void follow(const double *ct, const double *p, double *c) const;

private:
  // v is right to 2e-7 for |lambda| = 0.4 Omega in a stick as long as the period, to 1e-9 in half of that.
  static constexpr int terms = 8;
  struct Stick {
    int t, n; // where coefficients of the two directions begin
    double by_n;
    std::vector<double> value;            // (coefficients) of a wave at t_0
    std::vector<double> share;            // (terms, coefficients) of the force, by each polynomial
    std::vector<double> decay, beginning; // (terms, terms), (terms): c = beginning v(t_0) / k_t - decay (c t)
  };
  void remember(const Stick &stick, const double *ct, double *out) const;

  int width_ = 0;
  std::vector<Stick> sticks_;
};

} // namespace dovetail
