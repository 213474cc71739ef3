#pragma once
// Which law holds at a contact point, and its parameters (docs/theory/contact-laws.md). Direction 0 is t1, 1 is t2.
#include <array>

namespace dovetail {

enum class Law {
  coulomb,    ///< unilateral normal spring, and a friction slider in each tangential direction on its own
  cone,       ///< the same with |(T1, T2)| <= mu N: the two directions share one slider; mu[0] = mu[1]
  unilateral, ///< normal spring that pushes only, no friction
  bilateral   ///< normal spring that pushes and pulls, no friction
};

constexpr bool has_friction(Law law) { return law == Law::coulomb || law == Law::cone; }

struct ContactPoint {
  Law law = Law::coulomb;
  double kn = 0;              ///< normal stiffness [N/m], > 0
  std::array<double, 2> kt{}; ///< tangential stiffness [N/m], > 0 where there is friction, else without meaning
  std::array<double, 2> mu{}; ///< friction coefficient [-], >= 0
  double gap = 0;             ///< x_n0, lift-off displacement [m]: closed where x_n > x_n0
};

/// Springs of a closed point that sticks, t1, t2, n [N/m].
inline std::array<double, 3> stuck_springs(const ContactPoint &point) {
  const bool rubs = has_friction(point.law);
  return {rubs ? point.kt[0] : 0, rubs ? point.kt[1] : 0, point.kn};
}

constexpr int exactly = 0; ///< in place of a number of samples per period: no sampling

/// Samples per period where a law must be sampled and nobody says how.
constexpr int enough_samples(int harmonics) {
  int samples = 256;
  while (samples < 40 * harmonics) samples *= 2;
  return samples;
}

/// Slider positions w [m]: the law's memory.
using Memory = std::array<double, 2>;

} // namespace dovetail
