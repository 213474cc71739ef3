#pragma once
// The names of the counts of a run, in summary.json and state.h5.
#include "analyses/branch_state.hpp"

namespace dovetail {

/// Calls act(name, number) for each; works for a Counts to be read and to be filled.
template <class Numbers, class Act> void for_each_count(Numbers &counts, Act &&act) {
  act("points", counts.points);
  act("folds", counts.folds);
  act("peaks", counts.peaks);
  act("branch_points", counts.branch_points);
  act("stability_changes", counts.stability_changes);
  act("step_cuts", counts.cuts);
  act("corners", counts.corners);
  act("harmonics", counts.harmonics);
  act("leaps", counts.leaps);
  act("integrations", counts.integrations);
  act("missed", counts.missed);
  act("adaptations", counts.adaptations);
  act("newton_iterations", counts.newton);
  act("linear_iterations", counts.linear);
  act("inexact_linear_solves", counts.inexact);
}

} // namespace dovetail
