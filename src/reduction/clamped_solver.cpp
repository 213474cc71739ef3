#include "reduction/clamped_solver.hpp"

#include "support/error.hpp"

namespace dovetail {

ClampedSolver::ClampedSolver(Mat K_ee, std::string model_name) : K_(K_ee), model_name_(std::move(model_name)) {
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(K_), &comm_), "analysing K_ee");
  check(MatGetLocalSize(K_, &own_rows_, nullptr), "analysing K_ee");
  check(MatSetOption(K_, MAT_SPD, PETSC_TRUE), "analysing K_ee"); // before the factor is made: else MUMPS takes LU
  check(MatSetOptionsPrefixFactor(K_, "kee_"), "analysing K_ee");
  analyse(20);
}

void ClampedSolver::analyse(PetscInt room) {
  MatFactorInfo info;
  PetscInt error = 0, detail = 0;
  check(MatGetFactor(K_, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, factor_.out()), "analysing K_ee");
  check(MatMumpsSetIcntl(factor_, 14, room), "analysing K_ee"); // beyond the estimate [%]; no pivoting, so little
  check(MatMumpsSetIcntl(factor_, 27, 128), "analysing K_ee");  // right-hand sides it takes at a time
  check(MatFactorInfoInitialize(&info), "analysing K_ee");
  check(MatCholeskyFactorSymbolic(factor_, K_, nullptr, &info), "analysing K_ee");
  check(MatMumpsGetInfog(factor_, 1, &error), "analysing K_ee");
  check(MatMumpsGetInfog(factor_, 2, &detail), "analysing K_ee");
  if (error < 0)
    throw ComputeError("while analysing K_ee: MUMPS error " + std::to_string(error) + " (" + std::to_string(detail) +
                       ")" + (error == -7 || error == -13 ? "; out of memory: take a machine with more of it" : ""));
}

void ClampedSolver::factor() {
  for (int attempt = 0;; ++attempt) {
    MatFactorInfo options;
    PetscInt info = 0, detail = 0, negative = 0, room = 0;
    check(MatFactorInfoInitialize(&options), "factoring K_ee");
    const PetscErrorCode code = MatCholeskyFactorNumeric(factor_, K_, &options);
    MatMumpsGetInfog(factor_, 1, &info);
    MatMumpsGetInfog(factor_, 2, &detail);
    MatMumpsGetInfog(factor_, 12, &negative); // MUMPS goes on over negative pivots and only counts them
    MatMumpsGetIcntl(factor_, 14, &room);
    if (info == -10 || info == -40 || (info >= 0 && negative > 0))
      throw InputError(
          model_name_ + ": K_ee, the stiffness with the contact dofs held, is not positive definite (MUMPS " +
          std::to_string(info) +
          "): either constraints are missing, so that a body can still move as a whole, or K is not the "
          "stiffness of a stable structure. Remove the clamped dofs from K and M, and check which dofs are "
          "named in /contact/dofs.");
    check(code, "factoring K_ee");
    if (info >= 0) return;
    const bool short_of_room = info == -8 || info == -9;
    if (!short_of_room || attempt > 0)
      throw ComputeError(
          "while factoring K_ee: MUMPS error " + std::to_string(info) + " (" + std::to_string(detail) + ")" +
          (short_of_room ? "; its workspace was too small twice: try -kee_mat_mumps_icntl_14 400"
           : info == -13 ? "; out of memory: take more ranks or a machine with more of it"
           : info == -90 ? "; its files could not be written: out of core it needs room where TMPDIR points"
                         : ""));
    check(PetscOptionsClearValue(nullptr, "-kee_mat_mumps_icntl_14"), "factoring K_ee"); // it was not enough
    analyse(std::max<PetscInt>(100, 2 * room)); // after a failure PETSc 3.18 skips factorisations without a word
  }
}

void ClampedSolver::solve(Vec b, Vec x) const { check(MatSolve(factor_, b, x), "solving with K_ee"); }

Tall ClampedSolver::solve(const Tall &B) const {
  Tall X(own_rows_, B.columns);
  const UniqueMat from = dense_view(comm_, B, 0, B.columns), to = dense_view(comm_, X, 0, B.columns);
  check(MatMatSolve(factor_, from, to), "solving with K_ee");
  return X;
}

void ClampedSolver::solve_sparse(Mat rows, Tall &X, PetscInt first, PetscInt count) const {
  const UniqueMat to = dense_view(comm_, X, first, count);
  check(MatMatTransposeSolve(factor_, rows, to), "solving with K_ee");
}

std::string ClampedSolver::ordering() const {
  PetscInt used = -1;
  check(MatMumpsGetInfog(factor_, 7, &used), "asking for the ordering");
  const char *names[] = {"AMD", "given", "AMF", "SCOTCH", "PORD", "METIS", "QAMD"};
  return used >= 0 && used <= 6 ? names[used] : std::to_string(used);
}

double ClampedSolver::forecast_bytes() const {
  PetscInt out_of_core = 0, mebibytes = 0;
  check(MatMumpsGetIcntl(factor_, 22, &out_of_core), "asking for the memory of the factor");
  check(MatMumpsGetInfo(factor_, out_of_core ? 17 : 15, &mebibytes), "asking for the memory of the factor");
  return 1e6 * mebibytes;
}

double ClampedSolver::forecast_flops() const {
  PetscReal flops = 0;
  check(MatMumpsGetRinfog(factor_, 1, &flops), "asking for the operations of the factor");
  return flops;
}

} // namespace dovetail
