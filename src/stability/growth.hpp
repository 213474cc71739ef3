#pragma once
// The fastest growth among exponents or multipliers, and what kind of instability it would be.
#include <complex>
#include <limits>
#include <vector>

#include "stability/stability.hpp"
#include "stability/waves.hpp"

namespace dovetail {

struct Growth {
  double value = std::numeric_limits<double>::quiet_NaN(); ///< largest real part of an exponent over Omega
  Stability::Kind kind = Stability::Kind::none;            ///< what it is, should it be positive

  bool known() const { return value == value; }
  bool positive() const; ///< beyond round-off
  bool negative() const;
};

/// Of multipliers; not known if there are none.
Growth largest_of(const std::vector<std::complex<double>> &multipliers);

/// Of exponents over Omega from Hill's method, `indifferent` of them being 0 because something can move freely. They
/// are those near zero; further ones grow no faster than a little below zero, which is the answer if there are none.
Growth largest_of(std::vector<std::complex<double>> exponents, Waves waves, int indifferent = 0);

/// The larger one; not known unless both are.
Growth larger(const Growth &a, const Growth &b);

/// What two methods amount to; one of them may not have been asked. `trust_monodromy`: it knows its own sign.
Stability conclude(const Growth &by_monodromy, const Growth &by_hill, bool trust_monodromy);

/// From Hill's method with sampled contact forces: a verdict only where multipliers are well away from 1.
Stability conclude_sampled(const Growth &by_hill);

/// From Hill's method alone, exponents being good to `accuracy`.
Stability conclude_alone(const Growth &by_hill, double accuracy);

} // namespace dovetail
