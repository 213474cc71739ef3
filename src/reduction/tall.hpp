#pragma once
// Tall dense matrices whose rows are spread over the ranks like those of a sparse one, and the products made of them.
#include <vector>

#include "support/handle.hpp"

namespace dovetail {

/// This rank's rows, column by column.
struct Tall {
  PetscInt rows = 0, columns = 0;
  std::vector<double> values;

  Tall() = default;
  Tall(PetscInt own_rows, PetscInt n) : rows(own_rows), columns(n), values(static_cast<std::size_t>(own_rows) * n) {}
  double *column(PetscInt j) { return values.data() + static_cast<std::size_t>(j) * rows; }
  const double *column(PetscInt j) const { return values.data() + static_cast<std::size_t>(j) * rows; }
  void drop_columns_from(PetscInt j) { columns = j, values.resize(static_cast<std::size_t>(rows) * j); }
};

/// Columns [first, first + count) as a PETSc matrix without copying; S must outlive it.
UniqueMat dense_view(MPI_Comm comm, const Tall &S, PetscInt first, PetscInt count);

/// A S for sparse A whose columns are distributed like the rows of S; S here means columns [first, first + count).
Tall multiply(Mat A, const Tall &S, PetscInt first, PetscInt count);
inline Tall multiply(Mat A, const Tall &S) { return multiply(A, S, 0, S.columns); }

/// Adds columns [first, first + S.columns) of the sparse A to S.
void add_columns(Mat A, PetscInt first, Tall &S);

/// This rank's part of S^T T, S and T from columns s and t on: (m, n) column-major. Sum over the ranks to get the
/// product.
std::vector<double> own_gram(const Tall &S, PetscInt s, PetscInt m, const Tall &T, PetscInt t, PetscInt n);
/// S^T T on every rank.
std::vector<double> gram(MPI_Comm comm, const Tall &S, PetscInt s, PetscInt m, const Tall &T, PetscInt t, PetscInt n);

/// T -= S C with the first m columns of S and C (m, T.columns) column-major.
void subtract_product(const Tall &S, PetscInt m, const std::vector<double> &C, Tall &T);

/// The first n columns of S become its first m columns times C (m, n) column-major, n <= m, a panel of rows at a time.
void rotate(Tall &S, PetscInt m, PetscInt n, const double *C);

/// All rows of this rank's share (own_share) of the columns of S. Collective.
Tall whole_columns(MPI_Comm comm, const Tall &S);
/// The way back: own rows of `count` columns, all rows of a share of them on each rank, to columns [first, ...) of S.
void take_own_rows(MPI_Comm comm, const Tall &whole, Tall &S, PetscInt first, PetscInt count);

} // namespace dovetail
