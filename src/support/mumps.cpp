#include "support/mumps.hpp"

#include "support/error.hpp"

namespace dovetail {

void factor_by_lu(KSP ksp, Mat A) {
  PC pc;
  check(KSPSetOperators(ksp, A, A), "setting up MUMPS");
  check(KSPSetType(ksp, KSPPREONLY), "setting up MUMPS");
  check(KSPGetPC(ksp, &pc), "setting up MUMPS");
  check(PCSetType(pc, PCLU), "setting up MUMPS");
  check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS), "setting up MUMPS");
  check(PCFactorSetUpMatSolverType(pc), "setting up MUMPS");
  check(MatMumpsSetIcntl(mumps_factor(ksp), 6, 0), "setting up MUMPS");   // no column permutation from today's values
  check(MatMumpsSetIcntl(mumps_factor(ksp), 14, 60), "setting up MUMPS"); // room for the pivoting this may cost [%]
}

void recover_lu(KSP ksp, Mat A) {
  check(KSPReset(ksp), "setting up MUMPS");
  factor_by_lu(ksp, A);
  check(KSPSetFromOptions(ksp), "setting up MUMPS");
}

Mat mumps_factor(KSP ksp) {
  PC pc;
  Mat factor = nullptr;
  check(KSPGetPC(ksp, &pc), "reaching a factor");
  check(PCFactorGetMatrix(pc, &factor), "reaching a factor");
  return factor;
}

} // namespace dovetail
