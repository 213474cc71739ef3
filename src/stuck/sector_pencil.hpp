#pragma once
// The reduced matrices of a sector in one index, whole on one rank.
#include <vector>

#include "stuck/layout.hpp"
#include "support/hermitian.hpp"

namespace dovetail {

struct HermitianPencil { // of the modes and the contact dofs
  ComplexDense K, M;
};

/// With `springs`, (own contact dofs), in K; on rank `root`, elsewhere empty. Collective.
HermitianPencil pencil(const ReducedModel &model, const SectorIndex &index, const std::vector<double> &springs,
                       int root);

} // namespace dovetail
