#pragma once
// Joints within a sector in relative displacements from the start, u = T q, as those of any other model: no nodal
// diameter changes them. So the real modes hold x alone of them, no sums of pairs and no nodes of faces.
#include <vector>

#include "model/full_model.hpp"

namespace dovetail {

/// The sector in unknowns q, of which x of a joint within it are three: contact points a = x on the ground.
CyclicSector changed(const CyclicSector &sector);

/// Matrices, loads and sector of the model in q, and what `wanted`, dofs in rising order, or all of them, move by.
/// Collective.
void change_within_sector(FullModel &model, bool all, const std::vector<PetscInt> &wanted);

} // namespace dovetail
