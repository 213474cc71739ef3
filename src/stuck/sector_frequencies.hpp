#pragma once
// Frequencies of a cyclic structure over its nodal diameters, from the reduced matrices of its sector.
#include <vector>

#include "preload/contact_preload.hpp"

namespace dovetail {

/// (N / 2 + 1) lists, of nodal diameters 0 to N / 2, ascending [rad/s]; rigid motions are 0.
using SectorFrequencies = std::vector<std::vector<double>>;

constexpr PetscInt listed_frequencies = 20; ///< of each nodal diameter in results

/// With the contact points held: those of the modes that are kept.
SectorFrequencies held_frequencies(const ReducedModel &model);

/// The `count` lowest, or all, with the springs of points closed at rest, as far as these are stuck. `model`: not
/// scaled. Dense, a nodal diameter to a rank. Collective. InputError if a mass is not positive definite.
SectorFrequencies stuck_frequencies(const PreloadedModel &model, PetscInt count);

} // namespace dovetail
