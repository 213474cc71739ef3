#pragma once
// Friction in the plane over a step in which motion and normal force go linearly, exactly: stick until the force meets
// the bound, then T' = y' - lambda T with |T| = R, y = K x. With psi the angle from y' to T that is
//     tan(psi / 2) = tan(psi_0 / 2) exp(-integral of |y'| / R),
// whatever the two stiffnesses are. The error is that of a motion taken to be linear between samples: 1 / N^2.
#include <array>

#include "contact/jet.hpp"
#include "contact/law.hpp"

namespace dovetail {

/// T from its value before the step, by the increment y = K dx and the bounds mu N then and now, not below 0.
/// Returns whether it slips at the end.
template <class Real>
bool cone_step(std::array<Real, 2> &T, const std::array<Real, 2> &y, const Real &before, const Real &now) {
  using std::exp, std::sqrt;
  constexpr double small = 1e-6; // of the bound: a step whose curvature is none
  const std::array<Real, 2> trial{T[0] + y[0], T[1] + y[1]};
  const Real reached = trial[0] * trial[0] + trial[1] * trial[1];
  if (!slips_forth(std::sqrt(value_of(reached)), value_of(now))) {
    T = trial;
    return false;
  }
  if (!(value_of(now) > 0)) {
    T = {Real(0), Real(0)};
    return true;
  }
  const Real grows = now - before, a = y[0] * y[0] + y[1] * y[1] - grows * grows,
             b = T[0] * y[0] + T[1] * y[1] - before * grows;
  Real c = T[0] * T[0] + T[1] * T[1] - before * before; // |T|^2 - R^2 = c + 2 b s + a s^2 while it sticks
  if (value_of(c) > 0) c = Real(0);
  const Real square = b * b - a * c, root = value_of(square) > 0 ? sqrt(square) : Real(0);
  Real s = value_of(b) > 0 ? Real(0) - c / (b + root) : value_of(a) > 0 ? (root - b) / a : Real(0);
  if (value_of(s) > 1) s = Real(1);
  const Real bound = before + s * grows, left = Real(1) - s;
  const std::array<Real, 2> from{T[0] + s * y[0], T[1] + s * y[1]}, rest{left * y[0], left * y[1]};
  const Real length2 = rest[0] * rest[0] + rest[1] * rest[1];
  const auto drawn = [&](const Real &x, const Real &z) { // onto the bound
    const Real shrink = now / sqrt(x * x + z * z);
    T = {shrink * x, shrink * z};
    return true;
  };
  if (!(value_of(bound) > small * value_of(now))) return drawn(rest[0], rest[1]); // it has just landed
  if (!(value_of(length2) > small * small * value_of(now) * value_of(now)))
    return drawn(from[0] + rest[0], from[1] + rest[1]);
  const Real length = sqrt(length2), size = sqrt(from[0] * from[0] + from[1] * from[1]);
  const std::array<Real, 2> u{rest[0] / length, rest[1] / length}, e{from[0] / size, from[1] / size};
  const Real cosine = e[0] * u[0] + e[1] * u[1], sine = u[0] * e[1] - u[1] * e[0];
  const Real turned = exp(Real(0) - length / bound * log_mean(now / bound - Real(1)));
  const Real ahead = Real(1) + cosine, behind = (Real(1) - cosine) * turned * turned, sum = ahead + behind;
  const Real along = now * (ahead - behind) / sum, across = now * Real(2) * sine * turned / sum;
  T = {along * u[0] - across * u[1], along * u[1] + across * u[0]};
  return true;
}

} // namespace dovetail
