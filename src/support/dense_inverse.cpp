#include "support/dense_inverse.hpp"

#include <algorithm>
#include <numeric>

#include "support/int_count.hpp"
#include "support/shell.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "solving with a dense matrix";

MPI_Comm comm_of(Mat A) { return PetscObjectComm(reinterpret_cast<PetscObject>(A)); }

int order_of(Mat A) {
  PetscInt n;
  check(MatGetSize(A, &n, nullptr), doing);
  return int_count(n, "rows of a dense matrix");
}

std::vector<std::vector<int>> rows_of(Mat A) {
  int size;
  const PetscInt *begin;
  MPI_Comm_size(comm_of(A), &size);
  check(MatGetOwnershipRanges(A, &begin), doing);
  std::vector<std::vector<int>> rows(size);
  for (int rank = 0; rank < size; ++rank) {
    rows[rank].resize(begin[rank + 1] - begin[rank]);
    std::iota(rows[rank].begin(), rows[rank].end(), static_cast<int>(begin[rank]));
  }
  return rows;
}

} // namespace

DenseInverse::DenseInverse(Mat A) : rows_(rows_of(A)), grid_(comm_of(A), order_of(A), rows_), factors_(grid_) {
  const double *values;
  PetscInt stride;
  check(MatDenseGetArrayRead(A, &values), doing);
  check(MatDenseGetLDA(A, &stride), doing);
  std::vector<double> line(grid_.order());
  const bool regular = factors_.factor([&](std::size_t i) {
    for (std::size_t j = 0; j < line.size(); ++j) line[j] = values[i + j * stride];
    return line.data();
  });
  check(MatDenseRestoreArrayRead(A, &values), doing);
  if (!regular) throw ComputeError(std::string("while ") + doing + ": it is singular");
}

void DenseInverse::set_up(KSP ksp, Mat A) { shell_solver<&DenseInverse::solve>(ksp, A, this, doing); }

void DenseInverse::solve(Vec r, Vec x) {
  std::vector<int> counts, first;
  for (const std::vector<int> &rows : rows_) {
    first.push_back(first.empty() ? 0 : first.back() + counts.back());
    counts.push_back(static_cast<int>(rows.size()));
  }
  std::vector<double> all(grid_.order());
  int rank;
  MPI_Comm_rank(grid_.comm(), &rank);
  MPI_Allgatherv(ReadValues(r), counts[rank], MPI_DOUBLE, all.data(), counts.data(), first.data(), MPI_DOUBLE,
                 grid_.comm());
  factors_.solve(all.data());
  std::copy_n(all.begin() + first[rank], counts[rank], static_cast<double *>(Values(x)));
}

} // namespace dovetail
