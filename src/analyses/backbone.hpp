#pragma once
// A nonlinear mode over its amplitude, by plain arc length: from the stuck structure, where the mode is a straight
// line, to the onset of slip or lift-off in one step, and on.
#include <complex>
#include <functional>
#include <vector>

#include "analyses/branch.hpp"
#include "problems/mode_balance.hpp"
#include "support/archive.hpp"

namespace dovetail {

/// All in scaled numbers.
struct BackboneSettings {
  double from = 0, to = 0; ///< modal amplitude; what is below `from` is gone through and not reported
  std::vector<double> at;  ///< amplitudes solved exactly, ascending, between those
  double to_force = 0;     ///< or until this factor on the load is reached; 0: not asked for
  double step = 0;         ///< first arc length beyond the onset
  int max_points = 1;
  double between = 1e-3; ///< as in BranchSettings
  /// (own dofs) of the stuck structure's mode, of length 1 with the mass; complex of a cyclic sector alone.
  std::vector<std::complex<double>> shape;
  double omega = 0;     ///< its frequency
  double onset = 0;     ///< amplitude of the first event; infinite where there is none
  bool straight = true; ///< below it the mode is a straight line
};

struct BackbonePoint {
  NonlinearMode &mode; ///< evaluated at the point
  const ModeState &state;
  const ModeBalance &balance;
  double arclength;
  Corrector::Outcome newton;
  double progress; ///< 0..1, of the decades from `from` to `to`
  bool located;    ///< found within a step, which led farther
};

struct BackboneObserver {
  std::function<void(const BackbonePoint &)> point;
  std::function<void(const BranchEvent &)> event; ///< its parameter: the modal amplitude
  std::function<bool()> interrupted = {};         ///< asked after each step, agreed on by all ranks. Optional.
  std::function<void(BranchState)> state = {};    ///< before each step: enough to go on from. Optional.
  std::function<void(Archive &)> archive = {};    ///< what the observer itself has in that state. Optional.
};

/// Ends are `arrived`, also with the force reached, `max_points`, `interrupted`,
/// `stalled` and `no_start`; the summary's parameters are modal amplitudes. Goes on from `state` of an interrupted run
/// with the same settings, unless null. Collective.
BranchSummary follow_backbone(HarmonicSystem &system, const NewtonSettings &newton, const BackboneSettings &settings,
                              const BackboneObserver &observer, const BranchState *state = nullptr);

} // namespace dovetail
