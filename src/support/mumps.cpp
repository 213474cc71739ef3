#include "support/mumps.hpp"

#include <cstdlib>

#include "support/error.hpp"

namespace dovetail {
namespace {

bool solved_by_mumps(KSP ksp) {
  PC pc;
  MatSolverType type;
  PetscBool mumps = PETSC_FALSE;
  check(KSPGetPC(ksp, &pc), "asking for the solver");
  check(PCFactorGetMatSolverType(pc, &type), "asking for the solver");
  check(PetscStrcmp(type, MATSOLVERMUMPS, &mumps), "asking for the solver");
  return mumps;
}

} // namespace

void order_the_same_way() { setenv("SCOTCH_PTHREAD_NUMBER", "1", 1); }

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
  check(MatMumpsSetIcntl(mumps_factor(ksp), 33, 1), "setting up MUMPS");  // determinant
}

int determinant_sign(KSP ksp) {
  if (!solved_by_mumps(ksp)) return 0;
  PetscReal mantissa;
  check(MatMumpsGetRinfog(mumps_factor(ksp), 12, &mantissa), "asking for a determinant");
  return mantissa > 0 ? 1 : mantissa < 0 ? -1 : 0;
}

std::string recover_lu(KSP ksp, Mat A) {
  PetscInt error = 0, detail = 0, room = 0;
  if (solved_by_mumps(ksp)) {
    check(MatMumpsGetInfog(mumps_factor(ksp), 1, &error), "recovering from a failed factorisation");
    check(MatMumpsGetInfog(mumps_factor(ksp), 2, &detail), "recovering from a failed factorisation");
    check(MatMumpsGetIcntl(mumps_factor(ksp), 14, &room), "recovering from a failed factorisation");
  }
  check(KSPReset(ksp), "recovering from a failed factorisation");
  factor_by_lu(ksp, A);
  check(KSPSetFromOptions(ksp), "recovering from a failed factorisation");
  const bool short_of_room = error == -8 || error == -9;
  if (short_of_room) check(MatMumpsSetIcntl(mumps_factor(ksp), 14, 2 * room), "recovering from a failed factorisation");
  if (error == 0 || error == -10) return "the Jacobian is singular";
  const std::string code = " (MUMPS " + std::to_string(error) + ", " + std::to_string(detail) + ")";
  if (short_of_room) return "the workspace of the factorisation was too small" + code + ", doubled now";
  if (error == -13) return "no memory for the factors of the Jacobian" + code + "; take more ranks";
  return "the Jacobian could not be factored" + code;
}

Mat mumps_factor(KSP ksp) {
  PC pc;
  Mat factor = nullptr;
  check(KSPGetPC(ksp, &pc), "reaching a factor");
  check(PCFactorGetMatrix(pc, &factor), "reaching a factor");
  return factor;
}

} // namespace dovetail
