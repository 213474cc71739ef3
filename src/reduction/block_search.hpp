#pragma once
// The basis of block Lanczos on SLEPc's BV: blocks of K^-1 M V, orthonormal in M, and the Ritz pairs in it.
#include <slepceps.h>

#include <vector>

#include "support/handle.hpp"

namespace dovetail {

using UniqueBV = Handle<BV, BVDestroy>;

struct Ritz {
  std::vector<double> value, vector; ///< (k), (k, k) column-major; largest magnitude first
};

/// The functions return PETSc's error codes: they work inside of SLEPc. Collective.
class Search {
public:
  PetscInt known = 0; ///< columns of the basis that have been through K^-1 M
  PetscInt block = 0; ///< columns behind them: the next block
  PetscInt most = 0;  ///< columns the basis can hold

  /// V becomes the basis; `start` is noise in [-1, 1] and gets other values.
  PetscErrorCode create(ST st, BV V, BV start);

  /// A next block, orthogonal to all before; empty if nothing is left that has mass.
  PetscErrorCode begin();
  PetscErrorCode begin_with_other_noise();
  /// One block further: what is new in K^-1 M times the block. No next block if nothing is.
  PetscErrorCode expand();

  PetscErrorCode ritz_pairs(Ritz &found) const;
  double residual(const Ritz &found, PetscInt pair) const; ///< || K^-1 M x - value x || in M

  PetscErrorCode keep_only(const Ritz &found, PetscInt count); ///< the best Ritz vectors instead of the basis
  PetscErrorCode restart(const Ritz &found, PetscInt count);   ///< with those, and the next block behind them

private:
  MPI_Comm comm_ = MPI_COMM_NULL;
  ST st_ = nullptr;
  Mat M_ = nullptr;
  UniqueMat C_;                      // (most, width) products with the basis
  BV V_ = nullptr, start_ = nullptr; // of the caller
  UniqueBV W_, MW_;                  // a block and M times it; after a step MW belongs to the next block
  PetscInt old_ = 0;                 // columns of the block before
  std::vector<double> H_;            // (most, most) column-major: V^T M K^-1 M V
  std::vector<double> coupling_;     // R of K^-1 M V_old = V C + V_block R, (block, old_) column-major

  double &h(PetscInt i, PetscInt j) { return H_[static_cast<std::size_t>(j) * most + i]; }
  static PetscErrorCode rotate(BV S, PetscInt m, PetscInt n, const double *C);
  PetscErrorCode set_columns(PetscInt n);
  PetscErrorCode multiply();
  PetscErrorCode solve();
  PetscErrorCode products(BV S, PetscInt m, PetscInt n, std::vector<double> &G);
  PetscErrorCode without_basis(PetscInt m, PetscInt n, std::vector<double> &G);
  PetscErrorCode orthonormalise(PetscInt &n, double size, std::vector<double> &R);
  PetscErrorCode by_cholesky(PetscInt n, double least, std::vector<double> &G, bool &done);
  PetscErrorCode by_gram_schmidt(PetscInt &n, double least, std::vector<double> &R);
  PetscErrorCode take_block(PetscInt n);
};

} // namespace dovetail
