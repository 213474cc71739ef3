#pragma once
// The group /cyclic of a reduced file: what indices h > 0 of a cyclic sector have in place of the real matrices.
#include "reduction/reduced_model.hpp"
#include "support/hdf5.hpp"

namespace dovetail {

/// Number of sectors that the file speaks of, 0 if it has no /cyclic. Checks shapes for N_a modes and nc contact dofs.
/// Each rank on its own. InputError.
int sectors_in(const h5::Reader &file, hsize_t modes, hsize_t nc, hsize_t loads);

/// Reads `sectors` and the own rows of all indices into a model whose sizes are set. Each rank on its own. InputError.
void read_sectors(const h5::Reader &file, int sectors, ReducedModel &model);

/// Writes /cyclic; own rows of the recovery begin at `before` of `total`. Collective.
void write_sectors(h5::Writer &file, const Reduction &reduction, hsize_t before, hsize_t total);

} // namespace dovetail
