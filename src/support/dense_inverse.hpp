#pragma once
// Solves with a dense matrix that several ranks share, by factors of ScaLAPACK.
#include "support/block_cyclic.hpp"
#include "support/error.hpp"
#include "support/handle.hpp"

namespace dovetail {

class DenseInverse {
public:
  /// Of a MATMPIDENSE, square and not singular. Collective, like all that follows.
  explicit DenseInverse(Mat A);
  DenseInverse(const DenseInverse &) = delete; // PETSc knows where it is

  void set_up(KSP ksp, Mat A);           ///< for A itself; this must outlive it
  void rethrow() { courier_.rethrow(); } ///< what a solve has thrown within PETSc

  template <class Work> PetscErrorCode run(Work &&work) { return courier_.run(work); } ///< for PETSc

private:
  void solve(Vec r, Vec x);

  const BlockCyclic grid_;
  SpreadFactors factors_;
  Courier courier_;
};

} // namespace dovetail
