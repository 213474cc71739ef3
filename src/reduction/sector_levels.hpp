#pragma once
// Craig-Bampton on two levels for a cyclic sector: real modes and constraint modes of dofs b, contact points and faces,
// are the same for all nodal diameters; on them, for each index h, complex modes with x held. Dense from here on.
#include "reduction/clamped_structure.hpp"
#include "reduction/reduced_model.hpp"

namespace dovetail {

struct SecondLevel {
  PetscInt modes = 0;               ///< N_a of each index
  std::filesystem::path model_file; ///< for messages
  bool exact = false;               ///< modes are iterated until no interior mode is missed
  bool residuals = false; ///< else: the higher half of the modes, 16 at most, is made of what is asked of the rest
  int judged = 0;         ///< else: the index whose modes are judged by a step
};

struct SectorModel {
  Reduction reduction;
  double left_out = -1; ///< change of a frequency by one step towards the exact modes, the largest, relative; or -1
  int steps = 0;        ///< of the exact modes, the most of any index
};

/// The reduced model of a sector from that of dofs b. Ranks share out the indices. `parts` with factors, unless every
/// mode there is is among the interior ones, and `interior`, their shapes. Collective. InputError: a rigid motion, a
/// mass that is not positive.
SectorModel sector_model(const ClampedStructure &parts, const Tall &interior, Reduction &&held,
                         const SecondLevel &settings);

/// Counts in what this takes when Psi is gone. Collective.
void plan_sector(const ClampedStructure &parts, PetscInt interior_modes, const SecondLevel &settings, MemoryPlan &plan);

} // namespace dovetail
