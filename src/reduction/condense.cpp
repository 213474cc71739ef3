#include "reduction/condense.hpp"

#include <algorithm>

#include "support/error.hpp"

namespace dovetail {

// Own rows of a matrix with one row and one column per contact dof, row-major.
std::vector<double> dense_rows(Mat A) {
  PetscInt begin, end, columns;
  check(MatGetOwnershipRange(A, &begin, &end), "reading rows");
  check(MatGetSize(A, nullptr, &columns), "reading rows");
  std::vector<double> rows(static_cast<std::size_t>(end - begin) * columns, 0.0);
  for (PetscInt i = begin; i < end; ++i) {
    PetscInt count;
    const PetscInt *at;
    const double *values;
    check(MatGetRow(A, i, &count, &at, &values), "reading rows");
    for (PetscInt j = 0; j < count; ++j) rows[static_cast<std::size_t>(i - begin) * columns + at[j]] += values[j];
    check(MatRestoreRow(A, i, &count, &at, &values), "reading rows");
  }
  return rows;
}

// Adds factor * block to columns [first, ...) of own rows, stored row-major with `width` columns.
void add_block(std::vector<double> &rows, PetscInt width, PetscInt first, double factor, const Tall &block) {
  for (PetscInt j = 0; j < block.columns; ++j)
    for (PetscInt i = 0; i < block.rows; ++i)
      rows[static_cast<std::size_t>(i) * width + first + j] += factor * block.column(j)[i];
}

// Rows [first, first + count) of -K_ce, which are right-hand sides of eq (16), on rank 0.
SparseColumns right_hand_sides(Mat K_ce_on_host, PetscInt first, PetscInt count) {
  SparseColumns sides;
  PetscInt begin, end;
  check(MatGetOwnershipRange(K_ce_on_host, &begin, &end), "collecting right-hand sides");
  for (PetscInt i = std::max(first, begin); i < std::min(first + count, end); ++i) { // rank 0 owns all of them
    PetscInt entries;
    const PetscInt *columns;
    const double *values;
    check(MatGetRow(K_ce_on_host, i, &entries, &columns, &values), "collecting right-hand sides");
    sides.row.insert(sides.row.end(), columns, columns + entries);
    for (PetscInt at = 0; at < entries; ++at) sides.value.push_back(-values[at]);
    check(MatRestoreRow(K_ce_on_host, i, &entries, &columns, &values), "collecting right-hand sides");
    sides.begin.push_back(static_cast<int>(sides.row.size()));
  }
  return sides;
}

UniqueMat on_host(Mat A) { // all of it on rank 0
  MPI_Comm comm;
  int rank;
  PetscInt rows, columns;
  UniqueIS all_rows, all_columns;
  UniqueMat moved;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(A), &comm), "collecting right-hand sides");
  MPI_Comm_rank(comm, &rank);
  check(MatGetSize(A, &rows, &columns), "collecting right-hand sides");
  check(ISCreateStride(comm, rank == 0 ? rows : 0, 0, 1, all_rows.out()), "collecting right-hand sides");
  check(ISCreateStride(comm, rank == 0 ? columns : 0, 0, 1, all_columns.out()), "collecting right-hand sides");
  check(MatCreateSubMatrix(A, all_rows, all_columns, MAT_INITIAL_MATRIX, moved.out()), "collecting right-hand sides");
  return moved;
}

// The lower triangle of a symmetric matrix from its upper one, own rows row-major.
void mirror_upper(MPI_Comm comm, PetscInt points, std::vector<double> &rows) {
  int size, rank;
  MPI_Comm_size(comm, &size);
  MPI_Comm_rank(comm, &rank);
  const PetscInt width = 3 * points, first = 3 * share_of(points, rank, size).begin,
                 own = 3 * share_of(points, rank, size).size();
  std::vector<std::vector<double>> outgoing(size); // own rows, columns of a later rank, transposed
  std::vector<MPI_Request> sending(size, MPI_REQUEST_NULL);
  for (int to = rank + 1; to < size; ++to) {
    const PetscInt begin = 3 * share_of(points, to, size).begin, count = 3 * share_of(points, to, size).size();
    outgoing[to].resize(static_cast<std::size_t>(own) * count);
    for (PetscInt i = 0; i < own; ++i)
      for (PetscInt j = 0; j < count; ++j)
        outgoing[to][static_cast<std::size_t>(j) * own + i] = rows[static_cast<std::size_t>(i) * width + begin + j];
    MPI_Isend(outgoing[to].data(), own * count, MPI_DOUBLE, to, 0, comm, &sending[to]);
  }
  for (PetscInt i = 0; i < own; ++i)
    for (PetscInt j = 0; j < i; ++j)
      rows[static_cast<std::size_t>(i) * width + first + j] = rows[static_cast<std::size_t>(j) * width + first + i];
  for (int from = 0; from < rank; ++from) {
    const PetscInt begin = 3 * share_of(points, from, size).begin, count = 3 * share_of(points, from, size).size();
    std::vector<double> incoming(static_cast<std::size_t>(own) * count);
    MPI_Recv(incoming.data(), own * count, MPI_DOUBLE, from, 0, comm, MPI_STATUS_IGNORE);
    for (PetscInt i = 0; i < own; ++i)
      std::copy_n(&incoming[static_cast<std::size_t>(i) * count], count,
                  &rows[static_cast<std::size_t>(i) * width + begin]);
  }
  MPI_Waitall(size, sending.data(), MPI_STATUSES_IGNORE);
}

} // namespace dovetail
