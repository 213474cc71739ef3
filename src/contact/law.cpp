#include "contact/law.hpp"

namespace dovetail {
namespace {

// The two sliders of a pressed point, each on its own.
void rub_apart(const ContactPoint &point, const double *x, StaticForce &out) {
  for (int d = 0; d < 2; ++d) {
    const double trial = point.kt[d] * x[d], bound = point.mu[d] * out.force[2], side = slips(trial, bound);
    if (side == 0) {
      out.force[d] = trial;
      out.slope[d][d] = point.kt[d];
    } else {
      out.force[d] = side * bound;
      out.slope[d][2] = side * point.mu[d] * point.kn;
      out.w[d] = x[d] - out.force[d] / point.kt[d];
    }
  }
}

// The one slider of a pressed point under the cone.
void rub_together(const ContactPoint &point, const double *x, StaticForce &out) {
  const double mu = point.mu[0], bound = mu * out.force[2];
  std::array<double, 2> T{point.kt[0] * x[0], point.kt[1] * x[1]}, along;
  const bool slipping = slips(std::hypot(T[0], T[1]), bound) != 0;
  const double shrink = slipping ? drawn_back(bound, T, along) : 1;
  for (int d = 0; d < 2; ++d) {
    out.force[d] = T[d];
    if (!slipping) {
      out.slope[d][d] = point.kt[d];
      continue;
    }
    out.w[d] = x[d] - T[d] / point.kt[d];
    out.slope[d][2] = mu * point.kn * along[d];
    for (int e = 0; e < 2; ++e) out.slope[d][e] = shrink * ((d == e) - along[d] * along[e]) * point.kt[e];
  }
}

} // namespace

StaticForce static_force(const ContactPoint &point, const double *x) {
  StaticForce out;
  const double closing = x[2] - point.gap;
  if (point.law == Law::bilateral) {
    out.force[2] = point.kn * closing;
    out.slope[2][2] = point.kn;
    return out;
  }
  const bool friction = has_friction(point.law);
  if (friction && closing <= 0) out.w = {x[0], x[1]};
  if (closing < 0) return out;
  out.slope[2][2] = point.kn; // touching without force, too: a body held by its joint alone keeps a regular tangent
  out.force[2] = pressed(point.kn, closing);
  if (!friction) return out;
  if (closing == 0)
    for (int d = 0; d < 2; ++d) out.slope[d][d] = point.kt[d];
  else if (point.law == Law::cone)
    rub_together(point, x, out);
  else
    rub_apart(point, x, out);
  return out;
}

} // namespace dovetail
