#pragma once
// What the fixed-interface modes leave out of the elastic motion: the part that moving contacts and the load excite
// most.
#include "reduction/clamped_structure.hpp"
#include "reduction/reduced_model.hpp"

namespace dovetail {

/// Adds to `probes` (own elastic rows, at most lanczos_block columns) the share of a block of constraint modes:
/// `carried`, columns [first, ...) of B = M_ee Psi + M_ec. Column 0 is the caller's; the others are mixtures of all
/// columns of B.
void mix_probes(const Tall &carried, PetscInt first, PetscInt contact_dofs, Tall &probes);

/// Modes left out, by the Rayleigh-Ritz method on K_ee^-1 times the probes less the modes that are kept. As exact
/// statically as the probes reach, and all of what is left if that is no more than they are. Collective.
LeftOut left_out(const ClampedStructure &parts, const Tall &phi, Tall probes);

} // namespace dovetail
