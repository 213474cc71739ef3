#pragma once
// Damping of the structure as the case file gives it; contacts have their friction.
#include <vector>

namespace dovetail {

/// Damping ratio of one mode of the stuck structure.
struct ModeRatio {
  int mode; ///< from 1
  double ratio;
};

/// Viscous C = stiffness K + mass M, and hysteretic i structural K in every harmonic but the mean.
struct Damping {
  // A number alone is what damping.stiffness gives.
  Damping(double by_stiffness = 0, double by_mass = 0, double loss = 0)
      : stiffness(by_stiffness), mass(by_mass), structural(loss) {}

  double stiffness;              ///< b [s]
  double mass;                   ///< a [1/s]
  double structural;             ///< eta [-]
  std::vector<ModeRatio> ratios; ///< besides

  /// An entry of C.
  double viscous(double k, double m) const { return stiffness * k + mass * m; }
  /// Motions in time are computed: hysteretic damping has none, ratios of single modes are not taken there.
  bool acts_in_time() const { return structural == 0 && ratios.empty(); }
};

} // namespace dovetail
