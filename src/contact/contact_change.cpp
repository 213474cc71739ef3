#include "contact/contact_change.hpp"

namespace dovetail {

ContactPoint changed(ContactPoint point, const Setting::Contact &by) {
  point.kn *= by.normal_stiffness, point.gap += by.gap;
  for (int d = 0; d < 2; ++d) point.kt[d] *= by.tangential_stiffness[d], point.mu[d] *= by.friction[d];
  return point;
}

EquivalentMotion::EquivalentMotion(const Setting::Contact &now, const Setting::Contact &slope) : closing(-slope.gap) {
  for (int d = 0; d < 2; ++d) {
    all[d] = slope.tangential_stiffness[d] / now.tangential_stiffness[d];
    friction[d] = slope.friction[d] / now.friction[d];
  }
  all[2] = slope.normal_stiffness / now.normal_stiffness;
}

} // namespace dovetail
