#pragma once
// One Cholesky factorisation of K_ee by MUMPS, shared by x_e0, Psi and the modes.
//
// MUMPS on several ranks adds up what they send each other in the order in which it comes: no two runs have the same
// last bits. Up to a size every rank therefore has the whole factor and solves for its share of the right-hand sides.
//
// MUMPS is called itself and not through PETSc: PETSc 3.18 sets up a scatter with an entry per number of the solution
// for every block of right-hand sides, which on two ranks took as long as the solves and as much memory as their
// results.
#include <memory>
#include <string>

#include "reduction/tall.hpp"
#include "support/handle.hpp"

namespace dovetail {

/// Right-hand sides with few entries, each a contiguous list; all on rank 0, which is where MUMPS wants them.
struct SparseColumns {
  std::vector<int> begin{0}; ///< (count + 1)
  std::vector<int> row;      ///< from 0
  std::vector<double> value;
};

class ClampedSolver {
public:
  /// Analyses K_ee, which must live until factor(): ordering, and what the factorisation will take. ICNTL(i) of MUMPS
  /// is set by the option -kee_mat_mumps_icntl_i, as PETSc would; -kee_whole true gives each rank the whole factor and
  /// false a share of one, whatever their size. Collective.
  ClampedSolver(Mat K_ee, std::string model_name);
  ~ClampedSolver();

  /// Factors K_ee; once more with more workspace if that was too small. Collective. InputError in words if K_ee is not
  /// positive definite, ComputeError if MUMPS fails otherwise.
  void factor();

  Tall solve(const Tall &B) const; ///< many right-hand sides
  /// Columns [first, first + count) of X from sparse right-hand sides (read on rank 0 only).
  void solve_sparse(SparseColumns B, Tall &X, PetscInt first, PetscInt count) const;

  std::string ordering() const;  ///< as MUMPS names it, e.g. "SCOTCH"
  double forecast_bytes() const; ///< what MUMPS says this rank's share of the factorisation will take
  double forecast_flops() const; ///< of one factorisation
  bool shared() const;           ///< whether several ranks have one factor between them
  int attempts() const;          ///< factorisations made so far

private:
  struct Mumps;
  std::unique_ptr<Mumps> mumps_;
};

} // namespace dovetail
