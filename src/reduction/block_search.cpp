#include "reduction/block_search.hpp"

#include <slepcblaslapack.h> // needs petscsys.h before it

#include <algorithm>
#include <cmath>

namespace dovetail {

// S(:, 0:n) becomes S(:, 0:m) C with C (m, n) column-major.
PetscErrorCode Search::rotate(BV S, PetscInt m, PetscInt n, const double *C) {
  PetscFunctionBegin;
  UniqueMat Q;
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, m, n, const_cast<double *>(C), Q.out()));
  PetscCall(BVSetActiveColumns(S, 0, m));
  PetscCall(BVMultInPlace(S, Q, 0, n));
  PetscFunctionReturn(0);
}

PetscErrorCode Search::create(ST st, BV V, BV start) {
  PetscFunctionBegin;
  PetscInt width;
  st_ = st, V_ = V, start_ = start;
  PetscCall(PetscObjectGetComm(reinterpret_cast<PetscObject>(V), &comm_));
  PetscCall(STGetMatrix(st, 1, &M_));
  PetscCall(BVGetSizes(V, nullptr, nullptr, &most));
  PetscCall(BVGetSizes(start, nullptr, nullptr, &width));
  PetscCall(BVDuplicateResize(V, width, W_.out()));
  PetscCall(BVDuplicateResize(V, width, MW_.out()));
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, most, width, nullptr, C_.out()));
  H_.assign(static_cast<std::size_t>(most) * most, 0.0);
  PetscFunctionReturn(0);
}

PetscErrorCode Search::set_columns(PetscInt n) {
  PetscFunctionBegin;
  PetscCall(BVSetActiveColumns(W_, 0, n));
  PetscCall(BVSetActiveColumns(MW_, 0, n));
  PetscFunctionReturn(0);
}

PetscErrorCode Search::multiply() { // MW = M W
  PetscFunctionBegin;
  PetscCall(BVMatMult(W_, M_, MW_));
  PetscFunctionReturn(0);
}

// W = K^-1 MW. SLEPc 3.21 and later leave gaps between columns, and the solves of PETSc's own factors and of MUMPS
// there do not heed them: they get copies without.
PetscErrorCode Search::solve() {
  PetscFunctionBegin;
  Mat from, to;
  UniqueMat sides, solutions;
  PetscInt rows, n;
  PetscCall(BVGetMat(MW_, &from));
  PetscCall(MatGetLocalSize(from, &rows, nullptr));
  PetscCall(MatGetSize(from, nullptr, &n));
  PetscCall(MatCreateDense(comm_, rows, PETSC_DECIDE, PETSC_DETERMINE, n, nullptr, sides.out()));
  PetscCall(MatCreateDense(comm_, rows, PETSC_DECIDE, PETSC_DETERMINE, n, nullptr, solutions.out()));
  PetscCall(MatCopy(from, sides, SAME_NONZERO_PATTERN));
  PetscCall(BVRestoreMat(MW_, &from));
  PetscCall(STMatMatSolve(st_, sides, solutions));
  PetscCall(BVGetMat(W_, &to));
  PetscCall(MatCopy(solutions, to, SAME_NONZERO_PATTERN));
  PetscCall(BVRestoreMat(W_, &to));
  PetscFunctionReturn(0);
}

// G = S(:, 0:m)^T MW(:, 0:n), (m, n) column-major; C has it, too.
PetscErrorCode Search::products(BV S, PetscInt m, PetscInt n, std::vector<double> &G) {
  PetscFunctionBegin;
  const double *values;
  PetscCall(BVSetActiveColumns(S, 0, m));
  PetscCall(BVSetActiveColumns(MW_, 0, n));
  PetscCall(BVDot(MW_, S, C_));
  PetscCall(MatDenseGetArrayRead(C_, &values));
  G.clear();
  for (PetscInt j = 0; j < n; ++j) G.insert(G.end(), values + j * most, values + j * most + m);
  PetscCall(MatDenseRestoreArrayRead(C_, &values));
  PetscFunctionReturn(0);
}

// W -= V G with G = V^T MW, the first m columns of V and n of W.
PetscErrorCode Search::without_basis(PetscInt m, PetscInt n, std::vector<double> &G) {
  PetscFunctionBegin;
  PetscCall(products(V_, m, n, G));
  PetscCall(BVSetActiveColumns(W_, 0, n));
  PetscCall(BVMult(W_, -1, 1, V_, C_));
  PetscFunctionReturn(0);
}

PetscErrorCode Search::take_block(PetscInt n) { // from W to behind what is known
  PetscFunctionBegin;
  PetscInt dimensions; // what is beyond them is round-off, however well it is normalised
  PetscCall(BVGetSizes(V_, nullptr, &dimensions, nullptr));
  block = n = std::min(n, dimensions - known);
  if (n == 0) PetscFunctionReturn(0);
  PetscCall(BVSetActiveColumns(W_, 0, n));
  PetscCall(BVSetActiveColumns(V_, known, known + n));
  PetscCall(BVCopy(W_, V_));
  PetscFunctionReturn(0);
}

PetscErrorCode Search::begin() {
  PetscFunctionBegin;
  std::vector<double> G, R;
  PetscInt n;
  PetscCall(BVGetSizes(start_, nullptr, nullptr, &n));
  PetscCall(set_columns(n));
  PetscCall(BVSetActiveColumns(start_, 0, n));
  PetscCall(BVMatMult(start_, M_, MW_)); // without what has no mass
  PetscCall(solve());
  PetscCall(multiply());
  PetscCall(products(W_, n, n, G));
  double largest = 0;
  for (PetscInt j = 0; j < n; ++j) largest = std::max(largest, G[static_cast<std::size_t>(j) * (n + 1)]);
  double size = std::sqrt(largest);
  for (int pass = 0; pass < 2 && n > 0; ++pass, size = 1) {
    if (known > 0) {
      PetscCall(set_columns(n));
      PetscCall(multiply());
      PetscCall(without_basis(known, n, G));
    }
    PetscCall(orthonormalise(n, size, R));
  }
  PetscCheck(n > 0 || known > 0, comm_, PETSC_ERR_USER_INPUT,
             "The inner product is not well defined: indefinite matrix");
  PetscCall(take_block(n));
  PetscFunctionReturn(0);
}

PetscErrorCode Search::begin_with_other_noise() {
  PetscFunctionBegin;
  PetscInt n, rows;
  PetscCall(BVGetSizes(start_, &rows, nullptr, &n));
  for (PetscInt j = 0; j < n; ++j) {
    Vec column;
    double *x;
    PetscCall(BVGetColumn(start_, j, &column));
    PetscCall(VecGetArray(column, &x));
    for (PetscInt i = 0; i < rows; ++i) x[i] = 2 * x[i] * x[i] - 1; // in [-1, 1] again, whatever the partition
    PetscCall(VecRestoreArray(column, &x));
    PetscCall(BVRestoreColumn(start_, j, &column));
  }
  block = 0;
  PetscCall(begin());
  PetscFunctionReturn(0);
}

PetscErrorCode Search::expand() {
  PetscFunctionBegin;
  const PetscInt all = known + block;
  std::vector<double> C, first, second;
  old_ = block;
  PetscCall(set_columns(old_));
  PetscCall(solve());
  // MW is wanted once more: M times what was found.
  PetscCall(multiply());
  PetscCall(without_basis(all, old_, C));
  double size = 0;
  for (PetscInt j = 0; j < old_; ++j) {
    double sum = 0;
    for (PetscInt i = 0; i < all; ++i) {
      const double value = C[static_cast<std::size_t>(j) * all + i];
      sum += value * value;
      h(i, known + j) = h(known + j, i) =
          i < known ? value : 0.5 * (value + C[static_cast<std::size_t>(i - known) * all + known + j]);
    }
    size = std::max(size, std::sqrt(sum));
  }
  PetscCheck(std::isfinite(size), comm_, PETSC_ERR_FP, "the solution with the first matrix is not finite");
  known = all, block = 0;
  PetscInt n = old_;
  PetscCall(orthonormalise(n, size, first));
  const PetscInt between = n;
  if (between > 0) {
    PetscCall(without_basis(all, n, C)); // again: twice is enough
    PetscCall(orthonormalise(n, 1, second));
  }
  const PetscInt found = n;
  PetscCall(take_block(n));
  coupling_.assign(static_cast<std::size_t>(block) * old_, 0.0); // second * first
  for (PetscInt j = 0; j < old_; ++j)
    for (PetscInt l = 0; l < between; ++l)
      for (PetscInt i = 0; i < block; ++i)
        coupling_[static_cast<std::size_t>(j) * block + i] +=
            second[static_cast<std::size_t>(l) * found + i] * first[static_cast<std::size_t>(j) * between + l];
  PetscFunctionReturn(0);
}

PetscErrorCode Search::ritz_pairs(Ritz &found) const {
  PetscFunctionBegin;
  const PetscBLASInt n = static_cast<PetscBLASInt>(known);
  std::vector<double> A(static_cast<std::size_t>(n) * n), w(n), work(1);
  for (PetscInt j = 0; j < n; ++j)
    std::copy_n(&H_[static_cast<std::size_t>(j) * most], n, &A[static_cast<std::size_t>(j) * n]);
  PetscBLASInt room = -1, info;
  LAPACKsyev_("V", "L", &n, A.data(), &n, w.data(), work.data(), &room, &info);
  room = static_cast<PetscBLASInt>(work[0]);
  work.resize(room);
  LAPACKsyev_("V", "L", &n, A.data(), &n, w.data(), work.data(), &room, &info);
  MPI_Bcast(&info, 1, MPI_INT, 0, comm_); // the same on all ranks to the last bit: decisions hang on it
  MPI_Bcast(A.data(), static_cast<int>(A.size()), MPI_DOUBLE, 0, comm_);
  MPI_Bcast(w.data(), n, MPI_DOUBLE, 0, comm_);
  PetscCheck(info == 0, comm_, PETSC_ERR_LIB, "LAPACK's syev failed (%d)", static_cast<int>(info));
  std::vector<PetscInt> order(n);
  for (PetscInt i = 0; i < n; ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](PetscInt a, PetscInt b) { return std::abs(w[a]) > std::abs(w[b]); });
  found = {};
  for (const PetscInt i : order) {
    const double *column = &A[static_cast<std::size_t>(i) * n];
    found.value.push_back(w[i]);
    found.vector.insert(found.vector.end(), column, column + n);
  }
  PetscFunctionReturn(0);
}

double Search::residual(const Ritz &found, PetscInt pair) const { // || R s ||, s the last rows of the eigenvector
  const double *s = &found.vector[static_cast<std::size_t>(pair) * known + known - old_];
  double squares = 0;
  for (PetscInt i = 0; i < block; ++i) {
    double sum = 0;
    for (PetscInt j = 0; j < old_; ++j) sum += coupling_[static_cast<std::size_t>(j) * block + i] * s[j];
    squares += sum * sum;
  }
  return std::sqrt(squares);
}

PetscErrorCode Search::keep_only(const Ritz &found, PetscInt count) {
  PetscFunctionBegin;
  PetscCall(rotate(V_, known, count, found.vector.data()));
  std::fill(H_.begin(), H_.end(), 0.0);
  for (PetscInt i = 0; i < count; ++i) h(i, i) = found.value[i];
  known = count;
  PetscFunctionReturn(0);
}

PetscErrorCode Search::restart(const Ritz &found, PetscInt count) {
  PetscFunctionBegin;
  const PetscInt k = known;
  PetscCall(keep_only(found, count));
  for (PetscInt j = 0; j < block; ++j) PetscCall(BVCopyColumn(V_, k + j, count + j));
  PetscFunctionReturn(0);
}

} // namespace dovetail
