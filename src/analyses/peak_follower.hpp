#pragma once
// The peak of a response curve, followed over a parameter: docs/theory/equations.md, section 9.
#include "analyses/branch.hpp"
#include "problems/peak_track.hpp"

namespace dovetail {

enum class TrackedPeak { amplitude, phase };

/// All values in scaled numbers.
struct TrackSettings {
  const PathParameter *parameter = nullptr;
  double from = 0, to = 0; ///< of it
  std::vector<double> at;  ///< solved exactly whenever the track passes them
  TrackedPeak kind = TrackedPeak::amplitude;
  int max_points = 1;    ///< of the track
  BranchSettings search; ///< the sweep over the frequency in which the highest peak is taken for the first
};

/// Finds the highest peak of what is watched in the sweep at the first value, from the motion near y = [X; Omega], and
/// follows it to the last one. `system`: over the frequency, at the first value; `preload`: of its model, where the
/// parameter changes the joint. Or goes on from `state` of an interrupted run with the same settings. Points and events
/// go to the observer. Collective.
BranchSummary follow_peak(HarmonicSystem &system, std::shared_ptr<VariedPreload> preload, const NewtonSettings &newton,
                          const TrackSettings &settings, Vec y, const BranchObserver &observer,
                          const BranchState *state = nullptr);

} // namespace dovetail
