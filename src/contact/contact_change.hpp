#pragma once
// Contact points with other parameters, and the derivative of their forces by them.
//
// No law needs a derivative of its own for this. T depends on k_t (x_t - w) and on mu k_n p alone, N on k_n p, where
// p = x_n - x_n0. So with J = dg/dx, whatever the law,
//     k_t dg/dk_t = J (x_t - w),   k_n dg/dk_n = J p,   mu dT/dmu = J_Tn p,   dg/dx_n0 = -J_n 1,   dg/dw = -J_t 1.
#include "contact/law.hpp"
#include "contact/path_parameter.hpp"

namespace dovetail {

/// The point with factors on its parameters, and its gap moved.
ContactPoint changed(ContactPoint point, const Setting::Contact &by);

/// The motions that change forces as a parameter does.
struct EquivalentMotion {
  std::array<double, 3> all{};      ///< what x_t - w in both directions, and p, are multiplied by
  std::array<double, 2> friction{}; ///< likewise p, in the rows of either tangential force only
  double closing = 0;               ///< added to x_n

  EquivalentMotion() = default; ///< nothing changes
  /// At the setting `now`, which has no factor 0, along `slope`.
  EquivalentMotion(const Setting::Contact &now, const Setting::Contact &slope);
};

/// What is weighed together with some vector, by every parameter of a point: parameter times derivative, but for the
/// gap.
struct ByParameter {
  double normal_stiffness = 0;
  std::array<double, 2> tangential_stiffness{}, friction{};
  double gap = 0;
};

} // namespace dovetail
