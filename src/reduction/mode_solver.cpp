#include "reduction/mode_solver.hpp"

#include <slepc/private/epsimpl.h> // the category of a type

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numeric>

#include "reduction/block_lanczos.hpp"
#include "support/error.hpp"
#include "support/hash.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "computing modes";
constexpr double tolerance = 1e-12; // of a pair's residual, relative to its value: shapes then agree between ranks
constexpr double tolerance_of_preconditioned = 1e-13; // relative to the norms of K and M: their residuals are of K

// K^-1 as SLEPc wants it: the preconditioner of its linear solver.
struct Inverse {
  const ClampedSolver &solver;
  Courier courier;
};

Inverse &inverse_of(PC pc) {
  Inverse *inverse = nullptr;
  PCShellGetContext(pc, &inverse);
  return *inverse;
}

PetscErrorCode solve_columns(PC pc, Mat B, Mat X) {
  Inverse &inverse = inverse_of(pc);
  return inverse.courier.run([&] {
    PetscInt rows, columns, from, to;
    const double *b;
    double *x;
    check(MatGetLocalSize(B, &rows, nullptr), doing);
    check(MatGetSize(B, nullptr, &columns), doing);
    check(MatDenseGetLDA(B, &from), doing);
    check(MatDenseGetLDA(X, &to), doing);
    Tall sides(rows, columns);
    check(MatDenseGetArrayRead(B, &b), doing);
    for (PetscInt j = 0; j < columns; ++j) std::copy_n(b + j * from, rows, sides.column(j));
    check(MatDenseRestoreArrayRead(B, &b), doing);
    const Tall solution = inverse.solver.solve(sides);
    check(MatDenseGetArrayWrite(X, &x), doing);
    for (PetscInt j = 0; j < columns; ++j) std::copy_n(solution.column(j), rows, x + j * to);
    check(MatDenseRestoreArrayWrite(X, &x), doing);
  });
}

PetscErrorCode solve_column(PC pc, Vec b, Vec x) {
  Inverse &inverse = inverse_of(pc);
  return inverse.courier.run([&] {
    PetscInt rows;
    const double *from;
    double *to;
    check(VecGetLocalSize(b, &rows), doing);
    Tall side(rows, 1);
    check(VecGetArrayRead(b, &from), doing);
    std::copy_n(from, rows, side.column(0));
    check(VecRestoreArrayRead(b, &from), doing);
    const Tall solution = inverse.solver.solve(side);
    check(VecGetArrayWrite(x, &to), doing);
    std::copy_n(solution.column(0), rows, to);
    check(VecRestoreArrayWrite(x, &to), doing);
  });
}

double noise(std::uint64_t seed) { // in [-1, 1), the same for the same seed
  return static_cast<double>(mix(seed + 0x9e3779b97f4a7c15u) >> 11) * 0x1p-52 - 1;
}

// The first block, the same on any number of ranks.
void set_start(EPS eps, Mat K, const std::vector<long> &names) {
  PetscInt n;
  check(MatGetSize(K, &n, nullptr), doing);
  std::vector<UniqueVec> block(std::min(lanczos_block, n));
  std::vector<Vec> vectors;
  for (std::size_t j = 0; j < block.size(); ++j) {
    double *values;
    check(MatCreateVecs(K, block[j].out(), nullptr), doing);
    check(VecGetArrayWrite(block[j], &values), doing);
    for (std::size_t i = 0; i < names.size(); ++i)
      values[i] = noise(names[i] * lanczos_block + static_cast<PetscInt>(j));
    check(VecRestoreArrayWrite(block[j], &values), doing);
    vectors.push_back(block[j]);
  }
  check(EPSSetInitialSpace(eps, static_cast<PetscInt>(vectors.size()), vectors.data()), doing);
}

// What -modes_eps_type says, or block Lanczos.
void set_type(EPS eps) {
  char type[80] = "";
  PetscBool given;
  check(PetscOptionsGetString(nullptr, "modes_", "-eps_type", type, sizeof type, &given), "reading options");
  if (!given) std::snprintf(type, sizeof type, "%s", block_lanczos);
  PetscErrorCode (*create)(EPS) = nullptr;
  check(PetscFunctionListFind(EPSList, type, &create), doing);
  if (!create) {
    const char **names = nullptr;
    int count = 0;
    std::string known;
    check(PetscFunctionListGet(EPSList, &names, &count), doing);
    for (int i = 0; i < count; ++i) known += std::string(i ? ", " : "") + names[i];
    check(PetscFree(names), doing);
    throw InputError("-modes_eps_type " + std::string(type) + " is no eigensolver of SLEPc; it has " + known);
  }
  check(EPSSetType(eps, type), doing);
}

EPSWhich which_of(EPS eps) {
  switch (eps->categ) {
  case EPS_CATEGORY_PRECOND:
    return EPS_SMALLEST_REAL;
  case EPS_CATEGORY_CONTOUR:
    return EPS_ALL;
  default:
    return EPS_TARGET_MAGNITUDE;
  }
}

void set_defaults(EPS eps, Mat K, Mat M, PetscInt wanted, Inverse &inverse) {
  ST st;
  KSP ksp;
  PC pc;
  const bool preconditioned = eps->categ == EPS_CATEGORY_PRECOND;
  check(EPSSetOperators(eps, K, M), doing);
  check(EPSSetProblemType(eps, EPS_GHEP), doing);
  check(EPSSetDimensions(eps, wanted, PETSC_DEFAULT, PETSC_DEFAULT), doing);
  check(EPSSetTolerances(eps, preconditioned ? tolerance_of_preconditioned : tolerance, PETSC_DEFAULT), doing);
  if (preconditioned) check(EPSSetConvergenceTest(eps, EPS_CONV_NORM), doing);
  check(EPSSetWhichEigenpairs(eps, which_of(eps)), doing);
  if (eps->categ == EPS_CATEGORY_CONTOUR) return; // it factors matrices of its own
  check(EPSGetST(eps, &st), doing);
  check(STSetType(st, preconditioned ? STPRECOND : STSINVERT), doing);
  check(STGetKSP(st, &ksp), doing);
  check(KSPSetType(ksp, KSPPREONLY), doing);
  check(KSPGetPC(ksp, &pc), doing);
  check(PCSetType(pc, PCSHELL), doing);
  check(PCShellSetName(pc, "the factors of K_ee"), doing);
  check(PCShellSetContext(pc, &inverse), doing);
  check(PCShellSetApply(pc, solve_column), doing);
  check(PCShellSetMatApply(pc, solve_columns), doing);
}

// Options may choose how the modes are found, but not which.
void refuse_contradictions(EPS eps, PetscInt wanted) {
  const auto refuse = [](const std::string &what) {
    throw InputError("the options -modes_ " + what +
                     "; the modes sought are the lowest of K_ee v = w^2 M_ee v, as many "
                     "as reduction.modes says, with the factors of K_ee");
  };
  EPSProblemType problem;
  EPSWhich which;
  PetscInt nev;
  double target, shift;
  check(EPSGetProblemType(eps, &problem), doing);
  check(EPSGetWhichEigenpairs(eps, &which), doing);
  check(EPSGetDimensions(eps, &nev, nullptr, nullptr), doing);
  check(EPSGetTarget(eps, &target), doing);
  if (problem != EPS_GHEP) refuse("(eps_hermitian and the like) ask for another kind of problem");
  if (nev != wanted)
    refuse("eps_nev ask for " + std::to_string(nev) + " eigenvalues instead of " + std::to_string(wanted));
  if (which != which_of(eps)) refuse("(eps_smallest_real and the like) ask for another part of the spectrum");
  if (eps->categ == EPS_CATEGORY_CONTOUR) return;
  ST st;
  PetscBool expected;
  check(EPSGetST(eps, &st), doing);
  check(STGetShift(st, &shift), doing);
  if (target != 0 || shift != 0) refuse("(eps_target, st_shift) shift K_ee");
  const char *type = eps->categ == EPS_CATEGORY_PRECOND ? STPRECOND : STSINVERT;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(st), type, &expected), doing);
  if (!expected) refuse("(st_type) take another transformation than " + std::string(type));
}

std::string how_to_go_on(EPS eps, PetscInt converged, PetscInt wanted, double last) {
  EPSType type;
  PetscInt ncv, most, done;
  double tol;
  EPSConvergedReason reason;
  char text[600], up_to[80] = "";
  check(EPSGetType(eps, &type), doing);
  check(EPSGetDimensions(eps, nullptr, &ncv, nullptr), doing);
  check(EPSGetTolerances(eps, &tol, &most), doing);
  check(EPSGetIterationNumber(eps, &done), doing);
  check(EPSGetConvergedReason(eps, &reason), doing);
  if (converged > 0) std::snprintf(up_to, sizeof up_to, ", those up to %.6g Hz", last);
  std::snprintf(text, sizeof text,
                "while computing modes: %d of %d fixed-interface modes converged%s (SLEPc's %s, %s after %d of at most "
                "%d iterations). Raise -modes_eps_max_it, or -modes_eps_ncv above %d; take another -modes_eps_type; or "
                "ask for fewer in reduction.modes",
                static_cast<int>(converged), static_cast<int>(wanted), up_to, type, EPSConvergedReasons[reason],
                static_cast<int>(done), static_cast<int>(most), static_cast<int>(ncv));
  return text;
}

} // namespace

ElasticModes lowest_pairs(const ClampedSolver &solver, Mat K, Mat M, const std::vector<long> &names, PetscInt wanted,
                          const std::string &model_name) {
  Inverse inverse{solver, {}};
  MPI_Comm comm;
  UniqueEPS eps;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(K), &comm), doing);
  register_block_lanczos();
  check(EPSCreate(comm, eps.out()), doing);
  check(EPSSetOptionsPrefix(eps, "modes_"), doing);
  set_type(eps);
  set_defaults(eps, K, M, wanted, inverse);
  set_start(eps, K, names);
  check(EPSSetFromOptions(eps), "reading the options -modes_");
  refuse_contradictions(eps, wanted);

  const PetscErrorCode code = EPSSolve(eps);
  inverse.courier.rethrow();
  if (code == PETSC_ERR_USER_INPUT) throw InputError(model_name + ": /M is not positive definite on the elastic dofs");
  check(code, doing);

  PetscInt converged;
  EPSConvergedReason reason;
  check(EPSGetConverged(eps, &converged), doing);
  check(EPSGetConvergedReason(eps, &reason), doing);
  std::vector<double> values(converged);
  for (PetscInt j = 0; j < converged; ++j) check(EPSGetEigenvalue(eps, j, &values[j], nullptr), doing);
  if (converged < wanted) {
    if (reason == EPS_DIVERGED_BREAKDOWN)
      throw InputError(model_name + ": only " + std::to_string(converged) + " of the " + std::to_string(wanted) +
                       " modes of reduction.modes have mass");
    const double last = converged > 0 ? *std::max_element(values.begin(), values.end()) : 0;
    throw ComputeError(how_to_go_on(eps, converged, wanted, std::sqrt(std::max(0.0, last)) / (2 * M_PI)));
  }
  std::vector<PetscInt> order(converged);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](PetscInt a, PetscInt b) { return values[a] < values[b]; });
  ElasticModes found;
  found.shapes = Tall(static_cast<PetscInt>(names.size()), wanted);
  UniqueVec shape;
  check(MatCreateVecs(K, shape.out(), nullptr), doing);
  for (PetscInt j = 0; j < wanted; ++j) {
    const double *v;
    check(EPSGetEigenvector(eps, order[j], shape, nullptr), doing);
    check(VecGetArrayRead(shape, &v), doing);
    std::copy_n(v, names.size(), found.shapes.column(j));
    check(VecRestoreArrayRead(shape, &v), doing);
    found.squares.push_back(values[order[j]]);
  }
  return found;
}

} // namespace dovetail
