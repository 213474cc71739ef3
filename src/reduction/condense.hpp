#pragma once
// Parts of the condensation to contact dofs and modes that are the same for every matrix.
#include "reduction/clamped_structure.hpp"
#include "reduction/reduced_model.hpp"

namespace dovetail {

/// Own rows of a matrix with one row and one column per contact dof, row-major.
std::vector<double> dense_rows(Mat A);

/// Adds factor * block to columns [first, ...) of own rows, stored row-major with `width` columns.
void add_block(std::vector<double> &rows, PetscInt width, PetscInt first, double factor, const Tall &block);

/// All of a matrix on rank 0. Collective.
UniqueMat on_host(Mat A);

/// Rows [first, first + count) of -K_ce, which are right-hand sides of eq (16), on rank 0.
SparseColumns right_hand_sides(Mat K_ce_on_host, PetscInt first, PetscInt count);

/// The lower triangle of a symmetric matrix from its upper one, own rows row-major. Collective.
void mirror_upper(MPI_Comm comm, PetscInt points, std::vector<double> &rows);

} // namespace dovetail
