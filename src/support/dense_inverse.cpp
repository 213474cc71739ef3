#include "support/dense_inverse.hpp"

#include <algorithm>
#include <numeric>

#include "support/gathered.hpp"
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

DenseInverse::DenseInverse(Mat A) : grid_(comm_of(A), order_of(A), rows_of(A)), factors_(grid_) {
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
  PetscInt begin, end;
  check(VecGetOwnershipRange(r, &begin, &end), doing);
  const ReadValues from(r);
  std::vector<double> all = gathered(grid_.comm(), MPI_DOUBLE, std::vector<double>(from + 0, from + (end - begin)));
  factors_.solve(all.data());
  std::copy(all.begin() + begin, all.begin() + end, static_cast<double *>(Values(x)));
}

} // namespace dovetail
