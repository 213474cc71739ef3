#include "reduction/elastic_modes.hpp"

#include <algorithm>
#include <cmath>

#include "support/error.hpp"

namespace dovetail {
namespace {

// The sign of an eigenvector is arbitrary. Its largest entry is made positive; of entries that symmetry makes equal,
// the first counts, so that round-off cannot choose differently on another number of ranks.
void fix_sign(MPI_Comm comm, Vec v) {
  PetscReal largest;
  check(VecNorm(v, NORM_INFINITY, &largest), "fixing a mode's sign");
  PetscInt begin, end;
  check(VecGetOwnershipRange(v, &begin, &end), "fixing a mode's sign");
  const double *values;
  check(VecGetArrayRead(v, &values), "fixing a mode's sign");
  const double *found =
      std::find_if(values, values + (end - begin), [&](double x) { return std::abs(x) > (1 - 1e-6) * largest; });
  double sign = found != values + (end - begin) && *found < 0 ? -1.0 : 1.0;
  int rank, size;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  int first = found != values + (end - begin) ? rank : size;
  check(VecRestoreArrayRead(v, &values), "fixing a mode's sign");
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, comm);
  MPI_Bcast(&sign, 1, MPI_DOUBLE, std::min(first, size - 1), comm);
  if (sign < 0) check(VecScale(v, -1), "fixing a mode's sign");
}

// w^2 of a unit mode against the stiffness its entries would meet one by one: a motion without strain has nothing but
// round-off left. Even a slender blade of a million dofs stays above 1e-11.
bool is_rigid(Mat K, Vec shape, double square) {
  UniqueVec diagonal, weighted;
  double scale;
  check(VecDuplicate(shape, diagonal.out()), "testing for rigid motion");
  check(VecDuplicate(shape, weighted.out()), "testing for rigid motion");
  check(MatGetDiagonal(K, diagonal), "testing for rigid motion");
  check(VecPointwiseMult(weighted, shape, diagonal), "testing for rigid motion");
  check(VecDot(weighted, shape, &scale), "testing for rigid motion");
  return std::abs(square) < 1e-12 * scale;
}

} // namespace

ElasticModes elastic_modes(const ClampedSolver &solver, Mat K, Mat M, PetscInt count, const std::string &model_name) {
  MPI_Comm comm;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(K), &comm), "computing modes");
  UniqueEPS eps;
  check(EPSCreate(comm, eps.out()), "computing modes");
  check(EPSSetOptionsPrefix(eps, "kee_"), "computing modes");
  check(EPSSetOperators(eps, K, M), "computing modes");
  check(EPSSetProblemType(eps, EPS_GHEP), "computing modes");
  check(EPSSetTarget(eps, 0), "computing modes");
  check(EPSSetWhichEigenpairs(eps, EPS_TARGET_MAGNITUDE), "computing modes");
  check(EPSSetDimensions(eps, std::max<PetscInt>(count, 1), PETSC_DEFAULT, PETSC_DEFAULT), "computing modes");
  check(EPSSetTolerances(eps, 1e-12, 1000),
        "computing modes"); // shapes then agree between rank counts to 1e-9 and better
  ST st;
  check(EPSGetST(eps, &st), "computing modes");
  check(STSetType(st, STSINVERT), "computing modes");
  check(STSetShift(st, 0), "computing modes");
  check(STSetKSP(st, solver.ksp()), "computing modes"); // K_ee itself at shift 0: no second factorisation
  check(EPSSetFromOptions(eps), "computing modes");
  if (const PetscErrorCode code = EPSSolve(eps)) {
    try {
      check(code, "computing modes");
    } catch (const ComputeError &error) {
      if (std::string(error.what()).find("indefinite matrix") != std::string::npos)
        throw InputError(model_name + ": /M is not positive definite on the elastic dofs");
      throw ComputeError(std::string(error.what()) + "; is M positive definite on the elastic dofs?");
    }
  }
  PetscInt converged = 0;
  check(EPSGetConverged(eps, &converged), "computing modes");
  if (converged < count)
    throw ComputeError(
        "while computing modes: only " + std::to_string(converged) + " of " + std::to_string(count) +
        " fixed-interface modes converged; ask for fewer in reduction.modes, or widen the search with -kee_eps_ncv");
  ElasticModes modes;
  for (PetscInt j = 0; j < std::max<PetscInt>(count, 1); ++j) {
    UniqueVec shape;
    double square, error, scale;
    check(MatCreateVecs(K, shape.out(), nullptr), "computing modes");
    check(EPSGetEigenpair(eps, j, &square, nullptr, shape, nullptr), "computing modes");
    check(EPSComputeError(eps, j, EPS_ERROR_BACKWARD, &error), "computing modes");
    UniqueVec Mv;
    check(VecDuplicate(shape, Mv.out()), "computing modes");
    check(MatMult(M, shape, Mv), "computing modes");
    check(VecDot(Mv, shape, &scale), "computing modes");
    if (!(scale > 0))
      throw InputError(model_name + ": /M is not positive definite on the elastic dofs (mode " + std::to_string(j + 1) +
                       " has no mass)");
    check(VecScale(shape, 1 / std::sqrt(scale)), "computing modes");
    if (!(square > 0) || is_rigid(K, shape, square))
      throw InputError(model_name + ": a rigid-body motion is left in K_ee: with the contact dofs held, mode " +
                       std::to_string(j + 1) + " has no stiffness (w^2 = " + std::to_string(square) +
                       "). Constraints are missing, or a part is not connected.");
    if (error > 1e-8)
      throw ComputeError("while computing modes: mode " + std::to_string(j + 1) + " has a backward error of " +
                         std::to_string(error));
    if (j == count) break; // no mode was asked for: this one was only computed for the test above
    fix_sign(comm, shape);
    modes.squares.push_back(square);
    modes.shapes.push_back(std::move(shape));
  }
  return modes;
}

} // namespace dovetail
