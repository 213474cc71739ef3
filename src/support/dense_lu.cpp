#include "support/dense_lu.hpp"

#include <petscsys.h>

#include <petscblaslapack.h>

#include <algorithm>
#include <vector>

#include "support/error.hpp"

namespace dovetail {
namespace {

struct Factors {
  std::vector<double> values; // (n, n) by columns
  std::vector<PetscBLASInt> pivots;
  int sign = 0; // of the determinant
};

Factors &of(PC pc) {
  void *context;
  check(PCShellGetContext(pc, &context), "reaching a factor");
  return *static_cast<Factors *>(context);
}

PetscErrorCode factor(PC pc) {
  Factors &factors = of(pc);
  Mat A;
  PetscCall(PCGetOperators(pc, nullptr, &A));
  PetscInt rows, none;
  PetscBool done;
  const PetscInt *starts, *columns;
  const double *entries;
  PetscCall(MatGetRowIJ(A, 0, PETSC_FALSE, PETSC_FALSE, &rows, &starts, &columns, &done));
  PetscCall(MatSeqAIJGetArrayRead(A, &entries));
  factors.values.assign(static_cast<std::size_t>(rows) * rows, 0);
  for (PetscInt i = 0; i < rows; ++i)
    for (PetscInt e = starts[i]; e < starts[i + 1]; ++e)
      factors.values[i + static_cast<std::size_t>(columns[e]) * rows] = entries[e];
  PetscCall(MatSeqAIJRestoreArrayRead(A, &entries));
  PetscCall(MatRestoreRowIJ(A, 0, PETSC_FALSE, PETSC_FALSE, &none, &starts, &columns, &done));
  PetscBLASInt n, info;
  PetscCall(PetscBLASIntCast(rows, &n));
  factors.pivots.resize(n);
  LAPACKgetrf_(&n, &n, factors.values.data(), &n, factors.pivots.data(), &info);
  factors.sign = info == 0 ? 1 : 0;
  for (PetscBLASInt i = 0; i < n; ++i) {
    if (factors.values[i + static_cast<std::size_t>(i) * n] < 0) factors.sign = -factors.sign;
    if (factors.pivots[i] != i + 1) factors.sign = -factors.sign;
  }
  PetscCall(PCSetFailedReason(pc, info == 0 ? PC_NOERROR : PC_FACTOR_NUMERIC_ZEROPIVOT));
  return 0;
}

PetscErrorCode solve(PC pc, Vec b, Vec x) {
  const Factors &factors = of(pc);
  PetscCall(VecCopy(b, x));
  double *values;
  PetscCall(VecGetArray(x, &values));
  const PetscBLASInt n = static_cast<PetscBLASInt>(factors.pivots.size()), one = 1;
  PetscBLASInt info;
  LAPACKgetrs_("N", &n, &one, factors.values.data(), &n, factors.pivots.data(), values, &n, &info);
  PetscCall(VecRestoreArray(x, &values));
  return 0;
}

PetscErrorCode forget(PC pc) {
  delete &of(pc);
  return 0;
}

} // namespace

void factor_densely(KSP ksp, Mat A) {
  PC pc;
  check(KSPSetOperators(ksp, A, A), "setting up LAPACK");
  check(KSPSetType(ksp, KSPPREONLY), "setting up LAPACK");
  check(KSPGetPC(ksp, &pc), "setting up LAPACK");
  check(PCSetType(pc, PCSHELL), "setting up LAPACK");
  check(PCShellSetName(pc, "dense LU"), "setting up LAPACK");
  check(PCShellSetContext(pc, new Factors), "setting up LAPACK");
  check(PCShellSetDestroy(pc, forget), "setting up LAPACK");
  check(PCShellSetSetUp(pc, factor), "setting up LAPACK");
  check(PCShellSetApply(pc, solve), "setting up LAPACK");
}

bool factored_densely(KSP ksp) {
  PC pc;
  PetscBool same;
  check(KSPGetPC(ksp, &pc), "asking for the solver");
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCSHELL, &same), "asking for the solver");
  return same;
}

int dense_determinant_sign(KSP ksp) {
  PC pc;
  check(KSPGetPC(ksp, &pc), "asking for a determinant");
  return of(pc).sign;
}

} // namespace dovetail
