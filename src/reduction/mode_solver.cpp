#include "reduction/mode_solver.hpp"

#include <slepc/private/epsimpl.h> // the category of a type

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numeric>

#include "reduction/block_lanczos.hpp"
#include "reduction/factors_pc.hpp"
#include "support/error.hpp"
#include "support/hash.hpp"
#include "support/shell.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "computing modes";
// Of a pair's residual, relative to its value: shapes then agree between ranks. With a preconditioner, of its backward
// error: below that SLEPc's own products of nearly dependent vectors are no longer definite.
constexpr double tolerance = 1e-12;

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
    for (int i = 0; i < count && names[i]; ++i) known += std::string(i ? ", " : "") + names[i]; // PETSc counts its end
    check(PetscFree(names), doing);
    throw InputError("-modes_eps_type " + std::string(type) + " is no eigensolver of SLEPc; it has " + known);
  }
  check(EPSSetType(eps, type), doing);
}

// What K v - w^2 M v is relative to where eigensolvers judge by it: (|K| + w^2 |M|) |v|, v about as long as the mass
// says.
struct Scale {
  double stiffness = 0, mass = 0, length = 0;
};

Scale scale_of(Mat K, Mat M) {
  Scale scale;
  PetscInt n;
  double trace;
  check(MatNorm(K, NORM_INFINITY, &scale.stiffness), doing);
  check(MatNorm(M, NORM_INFINITY, &scale.mass), doing);
  check(MatGetSize(M, &n, nullptr), doing);
  check(MatGetTrace(M, &trace), doing);
  scale.length = trace > 0 ? std::sqrt(n / trace) : 1; // |v| of v^T M v = 1
  return scale;
}

PetscErrorCode backward_error(EPS, double square, double, double residual, double *error, void *context) {
  const Scale &scale = *static_cast<Scale *>(context);
  *error = residual / ((scale.stiffness + std::abs(square) * scale.mass) * scale.length);
  return 0;
}

enum class Way { by_inverse, preconditioned, in_a_region, dense };

Way way_of(EPS eps) {
  PetscBool dense;
  check(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(eps), &dense, EPSSCALAPACK, EPSELPA, EPSELEMENTAL, ""),
        doing);
  return dense                                ? Way::dense
         : eps->categ == EPS_CATEGORY_PRECOND ? Way::preconditioned
         : eps->categ == EPS_CATEGORY_CONTOUR ? Way::in_a_region
                                              : Way::by_inverse;
}

EPSWhich which_of(Way way) {
  return way == Way::by_inverse ? EPS_TARGET_MAGNITUDE : way == Way::in_a_region ? EPS_ALL : EPS_SMALLEST_REAL;
}

// The same on any number of ranks: a block of noise; for others a vector; smooth vectors where no solves make them so.
void set_start(EPS eps, const ClampedSolver &solver, Mat K, Mat M, const std::vector<long> &names, PetscInt wanted) {
  PetscInt n;
  PetscBool in_blocks;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(eps), block_lanczos, &in_blocks), doing);
  check(MatGetSize(K, &n, nullptr), doing);
  const bool smooth = way_of(eps) == Way::preconditioned;
  const PetscInt most = std::min(lanczos_block, n);
  Tall block(static_cast<PetscInt>(names.size()), in_blocks ? most : smooth ? std::min(most, wanted) : 1);
  for (PetscInt j = 0; j < block.columns; ++j)
    for (PetscInt i = 0; i < block.rows; ++i) block.column(j)[i] = noise(first_seed + names[i] * lanczos_block + j);
  if (smooth) block = solver.solve(multiply(M, block));
  std::vector<UniqueVec> owned(block.columns);
  std::vector<Vec> vectors;
  for (PetscInt j = 0; j < block.columns; ++j) {
    check(MatCreateVecs(K, owned[j].out(), nullptr), doing);
    std::copy_n(block.column(j), block.rows, static_cast<double *>(Values(owned[j])));
    vectors.push_back(owned[j]);
  }
  check(EPSSetInitialSpace(eps, block.columns, vectors.data()), doing);
}

void set_defaults(EPS eps, Mat K, Mat M, PetscInt wanted, Inverse &inverse, Scale &scale) {
  ST st;
  KSP ksp;
  PC pc;
  const Way way = way_of(eps);
  const bool preconditioned = way == Way::preconditioned;
  check(EPSSetOperators(eps, K, M), doing);
  check(EPSSetProblemType(eps, EPS_GHEP), doing);
  check(EPSSetDimensions(eps, wanted, PETSC_DEFAULT, PETSC_DEFAULT), doing);
  check(EPSSetTolerances(eps, tolerance, PETSC_DEFAULT), doing);
  if (preconditioned) {
    scale = scale_of(K, M);
    check(EPSSetConvergenceTestFunction(eps, backward_error, &scale, nullptr), doing);
  }
  check(EPSSetWhichEigenpairs(eps, which_of(way)), doing);
  if (way == Way::in_a_region || way == Way::dense) return; // with factors of their own
  check(EPSGetST(eps, &st), doing);
  check(STSetType(st, preconditioned ? STPRECOND : STSINVERT), doing);
  check(STGetKSP(st, &ksp), doing);
  if (!preconditioned) check(KSPSetType(ksp, KSPPREONLY), doing);
  check(KSPGetPC(ksp, &pc), doing);
  precondition_by(inverse, pc);
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
  const Way way = way_of(eps);
  check(EPSGetProblemType(eps, &problem), doing);
  check(EPSGetWhichEigenpairs(eps, &which), doing);
  check(EPSGetDimensions(eps, &nev, nullptr, nullptr), doing);
  check(EPSGetTarget(eps, &target), doing);
  if (problem != EPS_GHEP) refuse("(eps_hermitian and the like) ask for another kind of problem");
  if (nev != wanted)
    refuse("eps_nev ask for " + std::to_string(nev) + " eigenvalues instead of " + std::to_string(wanted));
  if (which != which_of(way)) refuse("(eps_smallest_real and the like) ask for another part of the spectrum");
  if (way == Way::in_a_region || way == Way::dense) return;
  ST st;
  PetscBool expected;
  check(EPSGetST(eps, &st), doing);
  check(STGetShift(st, &shift), doing);
  if (target != 0 || shift != 0) refuse("(eps_target, st_shift) shift K_ee");
  const char *type = way == Way::preconditioned ? STPRECOND : STSINVERT;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(st), type, &expected), doing);
  if (!expected) refuse("(st_type) take another transformation than " + std::string(type));
}

void solve(EPS eps, Inverse &inverse, const std::string &model_name) {
  const PetscErrorCode code = EPSSolve(eps);
  inverse.courier.rethrow();
  try {
    check(code, doing);
  } catch (const ComputeError &error) { // SLEPc's words, and those of block Lanczos
    if (std::string(error.what()).find("inner product is not well defined") == std::string::npos) throw;
    throw InputError(model_name + ": /M is not positive definite on the elastic dofs");
  }
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
  if (way_of(eps) == Way::in_a_region)
    return "while computing modes: only " + std::to_string(converged) + " of " + std::to_string(wanted) +
           " modes lie in the region that -modes_rg_interval_endpoints gives [rad^2/s^2], as far as SLEPc's " + type +
           " has converged (" + EPSConvergedReasons[reason] + "). Make it wider, or raise -modes_eps_max_it above " +
           std::to_string(most);
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
  Scale scale;
  MPI_Comm comm;
  UniqueEPS eps;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(K), &comm), doing);
  register_block_lanczos();
  check(EPSCreate(comm, eps.out()), doing);
  check(EPSSetOptionsPrefix(eps, "modes_"), doing);
  set_type(eps);
  set_defaults(eps, K, M, wanted, inverse, scale);
  set_start(eps, solver, K, M, names, wanted);
  check(EPSSetFromOptions(eps), "reading the options -modes_");
  refuse_contradictions(eps, wanted);

  solve(eps, inverse, model_name);
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
    check(EPSGetEigenvector(eps, order[j], shape, nullptr), doing);
    std::copy_n(static_cast<const double *>(ReadValues(shape)), names.size(), found.shapes.column(j));
    found.squares.push_back(values[order[j]]);
  }
  return found;
}

} // namespace dovetail
