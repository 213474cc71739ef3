#pragma once
// Modes of the clamped structure made for the loads there are, moving contacts and the excitation: instead of
// eigenmodes, beside them, or to tell what they leave out.
#include "reduction/clamped_structure.hpp"
#include "reduction/elastic_modes.hpp"
#include "reduction/reduced_model.hpp"

namespace dovetail {

/// Weights of mixtures, in (-1, 1], the same on any number of ranks.
double probe_noise(PetscInt row, PetscInt column);

/// The load patterns, a column each, or, where these are more than half a block, as many mixtures of them.
Tall load_probes(MPI_Comm comm, const Tall &forces);

/// Adds to `probes` (own elastic rows, at most lanczos_block columns) the share of a block of constraint modes:
/// `carried`, columns [first, ...) of B = M_ee Psi + M_ec. The first `given` columns are the caller's; the others are
/// mixtures of all columns of B.
void mix_probes(const Tall &carried, PetscInt first, PetscInt contact_dofs, PetscInt given, Tall &probes);

/// Modes that S holds beyond those that are kept, by the Rayleigh-Ritz method on S less its part in them: all of what
/// is left if that is no more than S. Orthogonal to the kept ones as K_ee weighs, so that how those answer statically
/// stays as it is. Collective.
ElasticModes ritz_modes(const ClampedStructure &parts, const ElasticModes &kept, Tall S);

/// Puts modes of S, K_ee^-1 times the probes, in place of the highest half of the modes at most: what moving contacts
/// and the load ask of all modes that are left out, statically and, as M_ee Psi is in B, of their mass. S becomes
/// what these lead to in turn. Returns how many there are. Collective.
PetscInt with_residuals(const ClampedStructure &parts, ElasticModes &modes, Tall &S);

/// What of S is left out of the modes. Collective.
LeftOut left_out(const ClampedStructure &parts, const ElasticModes &kept, const Tall &S);

/// Own rows of B^T phi, B = M_ee Psi + M_ec of a matrix M, for columns of phi from `from` on: (3 own, columns)
/// row-major. Collective.
std::vector<double> carried_by(const ClampedStructure &parts, const Blocks &M, const Tall &phi, PetscInt from = 0);

} // namespace dovetail
