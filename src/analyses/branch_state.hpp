#pragma once
// Where a continuation stands between two steps: all it takes to go on as if it had never stopped.
#include <vector>

#include "continuation/curve.hpp"
#include "support/archive.hpp"
#include "support/growing_list.hpp"

namespace dovetail {

/// What has happened along a branch so far.
struct Counts : SolveCounts {
  int points = 0;
  int folds = 0, peaks = 0, branch_points = 0, stability_changes = 0; ///< located
  int cuts = 0, corners = 0;
  int harmonics = 0, leaps = 0, integrations = 0; ///< by recovery: added, parameter jumps without and with integration
  int missed = 0;                                 ///< frequencies of `at` without solution
  int adaptations = 0;                            ///< of the harmonics to the tolerance
};

/// Complete on rank 0 only. Vectors in the order of the results: (n, 2H+1) coefficients, then Omega; scaled.
struct BranchState {
  int harmonics = 0, samples = 0; ///< in force here; more than the case asks for if recovery raised them
  std::vector<double> y, tangent;
  Archive::Fields fields; ///< step lengths, norms, signs: the continuation's own
  GrowingList trail;      ///< marks of the points behind, by which a curve that runs back over itself is known
  Counts counts;
};

} // namespace dovetail
