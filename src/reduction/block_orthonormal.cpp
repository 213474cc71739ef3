// How block Lanczos makes a block orthonormal in M.
#include "reduction/block_search.hpp"

#include <slepcblaslapack.h> // needs petscsys.h before it

#include <algorithm>
#include <cmath>

namespace dovetail {
namespace {

constexpr double vanishing = 1e-13; // a direction this much smaller than it was before orthogonalisation is round-off

} // namespace

// W = Q R with W becoming Q and MW becoming M Q, n columns; what vanishes beside `size` is left out. R (n then, n now)
// column-major.
PetscErrorCode Search::orthonormalise(PetscInt &n, double size, std::vector<double> &R) {
  PetscFunctionBegin;
  const double least = vanishing * size;
  bool done = false;
  PetscCall(set_columns(n));
  PetscCall(multiply());
  PetscCall(products(W_, n, n, R));
  for (PetscInt j = 0; j < n; ++j)
    PetscCheck(!(R[static_cast<std::size_t>(j) * (n + 1)] < -1e-8 * size * size), comm_, PETSC_ERR_USER_INPUT,
               "The inner product is not well defined: indefinite matrix");
  PetscCall(by_cholesky(n, least, R, done));
  if (!done) PetscCall(by_gram_schmidt(n, least, R));
  PetscFunctionReturn(0);
}

// In three sweeps over W. Not done, W untouched, if its columns are too nearly dependent for that.
PetscErrorCode Search::by_cholesky(PetscInt n, double least, std::vector<double> &G, bool &done) {
  PetscFunctionBegin;
  constexpr double independent = 1e-4; // what is left of a unit column beside those before it
  const PetscBLASInt order = static_cast<PetscBLASInt>(n);
  PetscBLASInt info;
  std::vector<double> norm(n);
  for (PetscInt j = 0; j < n; ++j) {
    const double square = G[static_cast<std::size_t>(j) * (n + 1)];
    if (!(square > least * least)) PetscFunctionReturn(0);
    norm[j] = std::sqrt(square);
  }
  for (PetscInt j = 0; j < n; ++j)
    for (PetscInt i = 0; i < n; ++i) G[static_cast<std::size_t>(j) * n + i] /= norm[i] * norm[j];
  LAPACKpotrf_("U", &order, G.data(), &order, &info);
  MPI_Bcast(&info, 1, MPI_INT, 0, comm_); // the same on all ranks to the last bit: decisions hang on it
  MPI_Bcast(G.data(), static_cast<int>(G.size()), MPI_DOUBLE, 0, comm_);
  if (info != 0) PetscFunctionReturn(0);
  for (PetscInt j = 0; j < n; ++j) {
    if (G[static_cast<std::size_t>(j) * (n + 1)] < independent) PetscFunctionReturn(0);
    for (PetscInt i = 0; i < n; ++i) G[static_cast<std::size_t>(j) * n + i] *= i <= j ? norm[j] : 0;
  }
  std::vector<double> inverse = G;
  LAPACKtrtri_("U", "N", &order, inverse.data(), &order, &info);
  PetscCheck(info == 0, comm_, PETSC_ERR_LIB, "LAPACK's trtri failed (%d)", static_cast<int>(info));
  PetscCall(rotate(W_, n, n, inverse.data()));
  PetscCall(rotate(MW_, n, n, inverse.data()));
  done = true;
  PetscFunctionReturn(0);
}

// Column by column, each twice.
PetscErrorCode Search::by_gram_schmidt(PetscInt &n, double least, std::vector<double> &R) {
  PetscFunctionBegin;
  std::vector<double> upper(static_cast<std::size_t>(n) * n), c(n);
  PetscInt kept = 0;
  for (PetscInt j = 0; j < n; ++j) {
    double *r = &upper[static_cast<std::size_t>(j) * n];
    const auto beside = [&](PetscInt first, PetscInt end) -> PetscErrorCode { // c = W(:, first:end)^T MW(:, j)
      Vec mw;
      PetscFunctionBegin;
      PetscCall(BVSetActiveColumns(W_, first, end));
      PetscCall(BVGetColumn(MW_, j, &mw));
      PetscCall(BVDotVec(W_, mw, c.data()));
      PetscCall(BVRestoreColumn(MW_, j, &mw));
      PetscFunctionReturn(0);
    };
    for (int pass = 0; pass < 2 && kept > 0; ++pass) {
      std::fill(c.begin(), c.end(), 0.0);
      PetscCall(beside(0, kept));
      for (PetscInt i = 0; i < kept; ++i) r[i] += c[i];
      PetscCall(set_columns(n));
      PetscCall(BVMultColumn(W_, -1, 1, j, c.data())); // with all columns before j: those not kept have zeros
      PetscCall(BVMultColumn(MW_, -1, 1, j, c.data()));
    }
    PetscCall(beside(j, j + 1));
    const double square = c[0];
    if (!(square > least * least)) continue;
    r[kept] = std::sqrt(square);
    for (const BV S : {BV(W_), BV(MW_)}) {
      PetscCall(BVCopyColumn(S, j, kept));
      PetscCall(BVScaleColumn(S, kept, 1 / r[kept]));
    }
    ++kept;
  }
  R.clear();
  for (PetscInt j = 0; j < n; ++j)
    R.insert(R.end(), &upper[static_cast<std::size_t>(j) * n], &upper[static_cast<std::size_t>(j) * n] + kept);
  n = kept;
  PetscFunctionReturn(0);
}

} // namespace dovetail
