#pragma once
// One Cholesky factorisation of K_ee by MUMPS, shared by x_e0, Psi and the modes.
#include <string>

#include "reduction/tall.hpp"
#include "support/handle.hpp"

namespace dovetail {

class ClampedSolver {
public:
  /// Analyses K_ee, which must live as long: ordering, and what the factorisation will take. Collective.
  ClampedSolver(Mat K_ee, std::string model_name);

  /// Factors K_ee; once more with twice the workspace if that was too small. Collective. InputError in words if K_ee is
  /// not positive definite, ComputeError if MUMPS fails otherwise.
  void factor();

  void solve(Vec b, Vec x) const;
  Tall solve(const Tall &B) const; ///< many right-hand sides
  /// Columns [first, first + count) of X from sparse right-hand sides. `rows` (count, n_e) holds them as rows, all on
  /// rank 0, which is where MUMPS wants them.
  void solve_sparse(Mat rows, Tall &X, PetscInt first, PetscInt count) const;

  std::string ordering() const;  ///< as MUMPS names it, e.g. "SCOTCH"
  double forecast_bytes() const; ///< what MUMPS says this rank's share of the factorisation will take
  double forecast_flops() const; ///< of the factorisation, over all ranks

private:
  void analyse(PetscInt room);

  Mat K_;
  std::string model_name_;
  MPI_Comm comm_;
  PetscInt own_rows_ = 0;
  UniqueMat factor_;
};

} // namespace dovetail
