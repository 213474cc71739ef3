#pragma once
// Which rank gets which elastic dof: a METIS partition of the graph of K, so that products with K_ee and M_ee talk
// little.
#include <array>
#include <vector>

#include <petscmat.h>

namespace dovetail {

/// Own elastic dofs, ascending: all but those in `contact`. Balanced in number, and in how many of them touch a contact
/// dof, since these carry the right-hand sides of Psi. The graph is gathered on rank 0, a node of the mesh counting
/// once. Collective.
std::vector<PetscInt> elastic_share(Mat K, const std::vector<std::array<PetscInt, 3>> &contact);

} // namespace dovetail
