#pragma once
// Modes of one nodal diameter of a cyclic structure, with springs on the contact dofs of its sector. Dense.
#include "stuck/sector_pencil.hpp"

namespace dovetail {

/// Of the index h = 0 .. N / 2, as the other pencil(). Collective.
HermitianPencil pencil(const ReducedModel &model, int h, const std::vector<double> &springs, int root);

struct SectorModes {
  std::vector<double> squares; ///< w^2, ascending, exactly 0 of rigid motions
  ComplexDense shapes;         ///< (n, count) v^H M v = 1, the first large entry real and positive
};

/// The `count` lowest of a pencil. InputError, of `file`, if its mass is not positive definite.
SectorModes sector_modes(const HermitianPencil &of, int count, const std::filesystem::path &file);

/// Those of the index h of either sign, alike on every rank. Collective.
SectorModes sector_modes(const ReducedModel &model, int h, const std::vector<double> &springs, int count);

} // namespace dovetail
