#pragma once
// Where the structure resonates as it stands at its preload state, with its joint in three states, and whether friction
// at rest can hold what the load pushes.
#include <string>
#include <vector>

#include "case/case.hpp"
#include "preload/contact_preload.hpp"

namespace dovetail {

/// Of a body that the joint alone keeps from sliding. Forces along the motion that is asked for most, which moves some
/// contact point by 1.
struct Sliding {
  double force = 0; ///< where in the period friction is asked for most, with the preload [N]
  double held = 0;  ///< sum of mu N at rest against it [N]

  bool without_bound() const { return force > held; }
};

struct ResonanceSet {
  std::vector<double> omega; ///< [rad/s], ascending; rigid motions are 0
  std::vector<int> in_sweep; ///< of each, the lowest harmonic of the load that meets it in the sweep; 0: none
};

struct Resonances {
  bool known = true;     ///< false: the mass is not positive definite
  ResonanceSet stuck;    ///< with the springs of the closed points, normal and tangential
  ResonanceSet slipping; ///< with the normal springs of the closed points
  ResonanceSet open;     ///< without springs
  double reach = 0;      ///< below it none is missing from any of the three [rad/s]
  /// With the springs of all points, whose modes damping.ratios counts: where there are ratios, and points not closed.
  ResonanceSet all_stuck;
  std::vector<std::vector<int>> driven; ///< of each stuck mode, the harmonics of the load that drive it
  int points = 0, closed = 0;           ///< contact points in all, and closed at rest
  int may_lift = 0;                     ///< points that can lift off
  double clamping = 0;                  ///< sum of their normal forces at rest [N]
  Sliding sliding;
};

/// Ten modes at least, and as many more, up to 80, as harmonics of the load meet in the sweep. `model`: not scaled.
/// Collective. ComputeError.
Resonances resonances(const PreloadedModel &model, const Case &study);

/// (3 own) springs of the points closed at rest, as far as these are stuck; 0 of others.
std::vector<double> closed_springs(const PreloadedModel &model);

/// Harmonics from 1 upwards in which any of the loads works.
std::vector<int> driving_harmonics(const std::vector<LoadCourse> &loads);

} // namespace dovetail
