#pragma once
// Energies of a nonlinear mode over one period, and the load at whose resonance it is the response.
#include "problems/nonlinear_mode.hpp"

namespace dovetail {

/// Scaled, of the point of the mode evaluated last.
struct ModeBalance {
  double friction = 0;  ///< dissipated by the contacts
  double structure = 0; ///< dissipated by the damping of the structure
  double fed = 0;       ///< by the artificial term
  double unit = 0;      ///< what that feeds for zeta = 1
  /// Factor on the load at whose phase resonance this is the motion, by its lowest harmonic; infinite where the load
  /// does no work on it.
  double load = 0;

  /// Of the identity friction + structure = fed, as a damping ratio.
  double error() const { return (friction + structure - fed) / unit; }
  /// Damping ratio by the energies alone.
  double ratio() const { return (friction + structure) / unit; }
};

/// Collective.
ModeBalance balance_of(const NonlinearMode &mode, const ModeState &state);

} // namespace dovetail
