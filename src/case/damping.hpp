#pragma once
// Damping of the structure as the case file gives it; contacts have their friction.
#include <vector>

namespace dovetail {

/// Damping ratio of one mode.
struct ModeRatio {
  int mode; ///< from 1
  double ratio;
};

/// Viscous C = stiffness K + mass M, and hysteretic i structural K in every harmonic but the mean; and besides what is
/// not proportional to K and M (src/modal/dampers.hpp).
struct Damping {
  // A number alone is what damping.stiffness gives.
  Damping(double by_stiffness = 0, double by_mass = 0, double loss = 0)
      : stiffness(by_stiffness), mass(by_mass), structural(loss) {}

  double stiffness;              ///< b [s]
  double mass;                   ///< a [1/s]
  double structural;             ///< eta [-]
  std::vector<ModeRatio> ratios; ///< besides
  bool of_fixed = false;         ///< they are of the modes with all contact dofs held, not of those with contacts stuck
  bool matrix = false;           ///< the model's viscous matrix C, too
  bool contact = false;          ///< stiffness also takes the springs of contacts that stick at the preload state
  bool of_parts = false;         ///< structural is of the model's own matrix, not of K

  /// All of it times a factor, but for ratios, which are no numbers of K and M.
  Damping times(double factor) const {
    Damping out = *this;
    out.stiffness *= factor, out.mass *= factor, out.structural *= factor;
    return out;
  }
  /// A proportional entry of C.
  double viscous(double k, double m) const { return stiffness * k + mass * m; }
  /// Some of it is not proportional to K and M.
  bool has_dampers() const {
    return !ratios.empty() || matrix || (contact && stiffness != 0) || (of_parts && structural != 0);
  }
  /// Some of it is of the modes of the structure with its joint stuck.
  bool has_stuck_ratios() const { return !ratios.empty() && !of_fixed; }
  /// Some of it is of the joint, as the case has it.
  bool depends_on_joint() const { return has_stuck_ratios() || (contact && stiffness != 0); }
  /// Motions in time have it: hysteretic damping is an equation of each harmonic.
  bool acts_in_time() const { return structural == 0; }
};

} // namespace dovetail
