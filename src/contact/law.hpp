#pragma once
// The contact law at one instant (docs/theory/contact-laws.md). The march over samples and the preload are made of
// these few lines; the exact evaluation uses what follows from them for a slider over time (slider.hpp). `Real` is
// double, or a vector of doubles that holds one contact point per lane.
#include <cmath>

#include "contact/contact_point.hpp"

namespace dovetail {

/// Where a contact point stands before it vibrates: displacement and memory at the end of the preload.
struct Standstill {
  std::array<double, 3> x{};     ///< x_p: t1, t2, n [m]
  std::array<double, 3> force{}; ///< g(x_p) [N]
  Memory w{};                    ///< w_p [m]
};

/// Normal force [N] of a spring that only pushes; closing = x_n - x_n0.
template <class Real> inline Real pressed(const Real &kn, const Real &closing) {
  return closing > 0 ? kn * closing : Real{};
}

/// Coulomb's law for one slider: `trial` is the force [N] if it sticks, `bound` = mu N >= 0. Sticking changes the trial
/// by k_t dx; slipping, the force stays on the bound and the slider follows.
template <class Real> inline Real rubbed(const Real &trial, const Real &bound) {
  const Real above = trial < -bound ? -bound : trial;
  return above > bound ? bound : above;
}

/// Whether that slider slips forward; backward with `-trial`. A slider that comes back to the very place where it last
/// slipped (shakedown) meets the bound to round-off: that is stick.
template <class Real> inline auto slips_forth(const Real &trial, const Real &bound) {
  return trial >= bound * (1 + 1e-12);
}

/// The sign of its force if it slips, 0 while it sticks.
inline int slips(double trial, double bound) {
  return slips_forth(trial, bound) ? 1 : slips_forth(-trial, bound) ? -1 : 0;
}

/// The cone's law for a trial beyond the bound: it is drawn back along its own direction e, T = bound e. Returns
/// bound / |trial|, by which changes across e shrink; without trial there is neither direction nor force.
inline double drawn_back(double bound, std::array<double, 2> &T, std::array<double, 2> &e) {
  const double size = std::hypot(T[0], T[1]);
  for (int d = 0; d < 2; ++d) e[d] = size > 0 ? T[d] / size : 0, T[d] = bound * e[d];
  return size > 0 ? bound / size : 0;
}

/// Force at a standstill x = (t1, t2, n), reached from memory w = 0 (eq 7), with its derivative and the memory left.
struct StaticForce {
  std::array<double, 3> force{};                ///< [N]
  std::array<std::array<double, 3>, 3> slope{}; ///< d force / d x [N/m]
  Memory w{};                                   ///< [m]
};

StaticForce static_force(const ContactPoint &point, const double *x);

} // namespace dovetail
