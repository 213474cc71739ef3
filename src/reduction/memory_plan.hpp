#pragma once
// What a reduction will take before it takes it.
#include <string>

#include "reduction/clamped_structure.hpp"

namespace dovetail {

struct MemoryPlan {
  bool keep_psi = true;     ///< Psi whole; otherwise a block at a time, with twice as many solves
  PetscInt block = 256;     ///< columns of Psi solved for at once
  double bytes = 0;         ///< most this rank will have taken, by forecast
  double total_bytes = 0;   ///< the same over all ranks
  double machine_bytes = 0; ///< the same over the ranks of this rank's machine
  double room_bytes = 0;    ///< what they may take there: all that is free, or the user's limit
};

/// For `modes` modes, keeping `kept_rows` own rows of Phi and Psi; `limit`: bytes the ranks of a machine may take
/// together, 0 for all that is free. Collective; the same on every rank but for `bytes`.
MemoryPlan plan_memory(const ClampedStructure &parts, PetscInt modes, PetscInt kept_rows, double limit,
                       bool count_modes = false);

/// Throws ComputeError with advice if the plan does not fit. Collective.
void refuse_if_too_large(const ClampedStructure &parts, const MemoryPlan &plan);

/// In a line: "2.1 GiB over all ranks, 1.2 GiB of 20 GiB free on the fullest machine".
std::string in_words(const MemoryPlan &plan);

} // namespace dovetail
