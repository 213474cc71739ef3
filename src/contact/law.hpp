#pragma once
// The contact law at one instant (theory.md, section 5): elastic-Coulomb slider under a unilateral normal spring.
#include <cmath>

#include "contact/contact_point.hpp"

namespace dovetail {

enum class State { stick, slip, open };

/// Where a contact point stands before it vibrates: displacement and memory at the end of the preload.
struct Standstill {
  std::array<double, 3> x{};     ///< x_p: t1, t2, n [m]
  std::array<double, 3> force{}; ///< g(x_p) [N]
  Memory w{};                    ///< w_p [m]
};

/// Tangential force [N] of one direction, with the slider state that gave it.
struct Slide {
  double force;
  int sign; ///< 0 stick; +1 or -1: slips, force = sign * bound
};

/// Trial from the memory `w`, cut at the friction bound mu N; in slip `w` follows the contact. A slider that comes back
/// to the very place where it last slipped (shakedown) meets the bound to round-off: that is stick.
inline Slide slide(double x, double kt, double bound, double &w) {
  const double trial = kt * (x - w);
  if (std::abs(trial) < bound * (1 + 1e-12)) return {trial, 0};
  const int sign = trial < 0 ? -1 : 1;
  w = x - sign * bound / kt;
  return {sign * bound, sign};
}

/// Force at a standstill x = (t1, t2, n), reached from memory w = 0 (eq 7), with its derivative and the memory left.
struct StaticForce {
  std::array<double, 3> force{};                ///< [N]
  std::array<std::array<double, 3>, 3> slope{}; ///< d force / d x [N/m]
  Memory w{};                                   ///< [m]
};

inline StaticForce static_force(const ContactPoint &point, const double *x) {
  StaticForce out;
  const double closing = x[2] - point.gap;
  if (closing < 0) { // touching without force counts as closed: a body held by its joint alone keeps a regular tangent
    out.w = {x[0], x[1]};
    return out;
  }
  out.force[2] = point.kn * closing;
  out.slope[2][2] = point.kn;
  for (int d = 0; d < 2; ++d) {
    const double bound = point.mu[d] * out.force[2];
    if (closing == 0) {
      out.slope[d][d] = point.kt[d];
      out.w[d] = x[d];
      continue;
    }
    const Slide slid = slide(x[d], point.kt[d], bound, out.w[d]);
    out.force[d] = slid.force;
    if (slid.sign == 0)
      out.slope[d][d] = point.kt[d];
    else
      out.slope[d][2] = slid.sign * point.mu[d] * point.kn;
  }
  return out;
}

} // namespace dovetail
