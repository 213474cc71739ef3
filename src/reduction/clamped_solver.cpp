#include "reduction/clamped_solver.hpp"

#include "support/error.hpp"
#include "support/mumps.hpp"

namespace dovetail {

ClampedSolver::ClampedSolver(Mat K_ee, const std::string &model_name) {
  MPI_Comm comm;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(K_ee), &comm), "factoring K_ee");
  check(MatSetOption(K_ee, MAT_SPD, PETSC_TRUE), "factoring K_ee"); // before the factor is made: else MUMPS takes LU
  check(KSPCreate(comm, ksp_.out()), "factoring K_ee");
  check(KSPSetOptionsPrefix(ksp_, "kee_"), "factoring K_ee");
  check(KSPSetOperators(ksp_, K_ee, K_ee), "factoring K_ee");
  check(KSPSetType(ksp_, KSPPREONLY), "factoring K_ee");
  PC pc;
  check(KSPGetPC(ksp_, &pc), "factoring K_ee");
  check(PCSetType(pc, PCCHOLESKY), "factoring K_ee");
  check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS), "factoring K_ee");
  check(PCFactorSetUpMatSolverType(pc), "factoring K_ee");
  check(MatMumpsSetIcntl(mumps_factor(ksp_), 14, 40),
        "factoring K_ee"); // room for pivoting beyond the analysis' estimate [%]
  check(KSPSetFromOptions(ksp_), "factoring K_ee");
  const PetscErrorCode code = KSPSetUp(ksp_);
  PetscInt info = 0, detail = 0, negative = 0;
  MatMumpsGetInfog(mumps_factor(ksp_), 1, &info);
  MatMumpsGetInfog(mumps_factor(ksp_), 2, &detail);
  MatMumpsGetInfog(mumps_factor(ksp_), 12, &negative); // MUMPS goes on over negative pivots and only counts them
  if (info == -10 || info == -40 || (info >= 0 && negative > 0))
    throw InputError(model_name + ": K_ee, the stiffness with the contact dofs held, is not positive definite (MUMPS " +
                     std::to_string(info) +
                     "): either constraints are missing, so that a body can still move as a whole, or K is not the "
                     "stiffness of a stable structure. Remove the clamped dofs from K and M, and check which dofs are "
                     "named in /contact/dofs.");
  check(code, "factoring K_ee");
  if (info < 0)
    throw ComputeError("while factoring K_ee: MUMPS error " + std::to_string(info) + " (" + std::to_string(detail) +
                       ")" +
                       (info == -8 || info == -9 ? "; its workspace was too small: try -kee_mat_mumps_icntl_14 100"
                        : info == -13            ? "; out of memory: take more ranks or a machine with more of it"
                                                 : ""));
}

void ClampedSolver::solve(Vec b, Vec x) const { check(KSPSolve(ksp_, b, x), "solving with K_ee"); }

void ClampedSolver::solve(Mat B, Mat X) const { check(MatMatSolve(mumps_factor(ksp_), B, X), "solving with K_ee"); }

std::string ClampedSolver::ordering() const {
  PetscInt used = -1;
  check(MatMumpsGetInfog(mumps_factor(ksp_), 7, &used), "asking for the ordering");
  const char *names[] = {"AMD", "given", "AMF", "SCOTCH", "PORD", "METIS", "QAMD"};
  return used >= 0 && used <= 6 ? names[used] : std::to_string(used);
}

} // namespace dovetail
