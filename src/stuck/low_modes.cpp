#include "stuck/low_modes.hpp"

#include <slepc/private/epsimpl.h> // the values on the way

#include <algorithm>
#include <cmath>

#include "reduction/block_lanczos.hpp"
#include "stuck/dense_modes.hpp"
#include "stuck/pencil_matrices.hpp"
#include "stuck/stuck_basis.hpp"
#include "support/error.hpp"
#include "support/hash.hpp"
#include "support/shell.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "computing resonances";
constexpr PetscInt few = 300;               // dofs; LAPACK finds all of their modes in some hundredths of a second
constexpr double rigid = 1e-9;              // of the strain energy that the entries of a mode would meet one by one
constexpr double lanczos_tolerance = 1e-12; // residual relative to the value
constexpr double far = 30;       // times the last square sought: from there on a lower shift is worth factors
constexpr double nearest = 1e-9; // the least shift, relative to the first: K + shift M stays definite

// Stiffness of each own dof by itself, springs included.
std::vector<double> diagonal_of(const PencilRows &rows, const std::vector<double> &springs, const Layout &layout) {
  std::vector<double> diagonal(rows.kaa.begin() + layout.own_modes.begin, rows.kaa.begin() + layout.own_modes.end);
  for (std::size_t i = 0; i < springs.size(); ++i)
    diagonal.push_back(rows.kxx.row(i)[3 * layout.own_points.begin + i] + springs[i]);
  return diagonal;
}

// A motion without strain has nothing but round-off left.
void set_rigid_to_zero(const std::vector<double> &diagonal, const Layout &layout, LowModes &modes) {
  const std::size_t own = diagonal.size();
  std::vector<double> stiff(modes.squares.size());
  for (std::size_t j = 0; j < stiff.size(); ++j)
    for (std::size_t d = 0; d < own; ++d) stiff[j] += diagonal[d] * std::pow(modes.shapes[j * own + d], 2);
  MPI_Allreduce(MPI_IN_PLACE, stiff.data(), static_cast<int>(stiff.size()), MPI_DOUBLE, MPI_SUM, layout.comm);
  for (std::size_t j = 0; j < stiff.size(); ++j)
    if (modes.squares[j] <= rigid * stiff[j]) modes.squares[j] = 0;
}

// A square of about the first frequency, never below it while there is any stiffness: the least of all dofs' own.
double shift_of(const PencilRows &rows, const std::vector<double> &diagonal, const Layout &layout) {
  const std::size_t own_modes = layout.own_modes.size();
  double least = INFINITY;
  for (std::size_t d = 0; d < diagonal.size(); ++d) {
    const std::size_t i = d - own_modes;
    const double mass = d < own_modes ? 1 : rows.mxx.row(i)[3 * layout.own_points.begin + i];
    if (diagonal[d] > 0 && mass > 0) least = std::min(least, diagonal[d] / mass);
  }
  MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_DOUBLE, MPI_MIN, layout.comm);
  return std::isfinite(least) ? least : 1;
}

// Noise that is the same on any number of ranks.
void set_start(EPS eps, Mat A, const Layout &layout) {
  const PetscInt width = std::min(lanczos_block, layout.dofs());
  std::vector<UniqueVec> owned(width);
  std::vector<Vec> vectors;
  for (PetscInt j = 0; j < width; ++j) {
    check(MatCreateVecs(A, owned[j].out(), nullptr), doing);
    const Values values(owned[j]);
    for (PetscInt d = 0; d < layout.own_dofs(); ++d)
      values[d] = noise(first_seed + layout.number(d) * lanczos_block + j);
    vectors.push_back(owned[j]);
  }
  check(EPSSetInitialSpace(eps, width, vectors.data()), doing);
}

// Shift-and-invert about 0. False: K + shift M is not positive definite.
bool set_inverse(EPS eps, PencilMatrices &pencil) {
  ST st;
  KSP ksp;
  check(EPSGetST(eps, &st), doing);
  check(STSetType(st, STSINVERT), doing);
  check(STGetKSP(st, &ksp), doing);
  return pencil.set_inverse(ksp);
}

// Lanczos tells values apart that differ by more than a small part of the shift.
struct Shift {
  double square, least;
  bool lower = false; // what has been found allows another, and it is there already
};

PetscErrorCode stop_if_far(EPS eps, PetscInt steps, PetscInt most, PetscInt good, PetscInt wanted,
                           EPSConvergedReason *reason, void *context) {
  Shift &shift = *static_cast<Shift *>(context);
  PetscFunctionBegin;
  PetscCall(EPSStoppingBasic(eps, steps, most, good, wanted, reason, nullptr));
  const double value = eps->eigr[wanted - 1]; // of a Ritz pair: the square is not below the true one
  if (*reason != EPS_CONVERGED_ITERATING || value <= 0) PetscFunctionReturn(0);
  const double last = std::max(1 / value - shift.square, shift.least);
  if (last * far < shift.square) shift.square = last, shift.lower = true, *reason = EPS_CONVERGED_USER;
  PetscFunctionReturn(0);
}

bool solved(EPS eps, PencilMatrices &pencil) { // false if M is not positive definite
  try {
    const PetscErrorCode code = EPSSolve(eps);
    pencil.rethrow();
    check(code, doing);
  } catch (const ComputeError &error) {
    if (std::string(error.what()).find("inner product is not well defined") == std::string::npos) throw;
    return false;
  }
  return true;
}

} // namespace

std::optional<LowModes> low_modes_by_lapack(const PencilRows &rows, const std::vector<double> &springs,
                                            const Layout &layout, PetscInt count) {
  const std::size_t n = layout.dofs(), own = layout.own_dofs(), found = std::min<std::size_t>(count, n);
  auto [phi, M] = own_pencil(rows, springs, layout);
  LowModes modes{dense_modes_on_one_rank(layout, phi, M), std::vector<double>(found * own)};
  if (modes.squares.empty()) return {};
  modes.squares.resize(found);
  for (std::size_t j = 0; j < found; ++j)
    for (std::size_t d = 0; d < own; ++d) modes.shapes[j * own + d] = phi[d * n + j];
  set_rigid_to_zero(diagonal_of(rows, springs, layout), layout, modes);
  return modes;
}

std::optional<LowModes> low_modes_by_lanczos(const PencilRows &rows, const std::vector<double> &springs,
                                             const Layout &layout, PetscInt count) {
  const std::vector<double> diagonal = diagonal_of(rows, springs, layout);
  const double first = shift_of(rows, diagonal, layout);
  const PetscInt wanted = std::min(count, layout.dofs());
  Shift shift{first, nearest * first};
  std::optional<PencilMatrices> pencil;
  UniqueEPS eps;
  register_block_lanczos();
  do {
    shift.lower = false;
    pencil.reset(); // first, for its memory
    pencil.emplace(rows, springs, shift.square, layout);
    check(EPSCreate(layout.comm, eps.out()), doing);
    check(EPSSetOperators(eps, pencil->stiffness(), pencil->mass()), doing);
    check(EPSSetProblemType(eps, EPS_GHEP), doing);
    check(EPSSetType(eps, block_lanczos), doing);
    check(EPSSetDimensions(eps, wanted, PETSC_DEFAULT, PETSC_DEFAULT), doing);
    check(EPSSetTolerances(eps, lanczos_tolerance, PETSC_DEFAULT), doing);
    check(EPSSetStoppingTestFunction(eps, stop_if_far, &shift, nullptr), doing);
    if (!set_inverse(eps, *pencil)) return {};
    set_start(eps, pencil->stiffness(), layout);
    if (!solved(eps, *pencil)) return {};
  } while (shift.lower);
  PetscInt converged;
  check(EPSGetConverged(eps, &converged), doing);
  if (converged < wanted)
    throw ComputeError("while computing resonances: only " + std::to_string(converged) + " of " +
                       std::to_string(wanted) + " modes converged");
  LowModes modes;
  UniqueVec shape;
  check(MatCreateVecs(pencil->stiffness(), shape.out(), nullptr), doing);
  for (PetscInt j = 0; j < wanted; ++j) { // block Lanczos has those next to 0 first
    double value;
    check(EPSGetEigenpair(eps, j, &value, nullptr, shape, nullptr), doing);
    const ReadValues v(shape);
    modes.squares.push_back(value - shift.square);
    modes.shapes.insert(modes.shapes.end(), v + 0, v + diagonal.size());
  }
  set_rigid_to_zero(diagonal, layout, modes);
  return modes;
}

std::optional<LowModes> low_modes(const PencilRows &rows, const std::vector<double> &springs, const Layout &layout,
                                  PetscInt count) {
  return layout.dofs() <= few ? low_modes_by_lapack(rows, springs, layout, count)
                              : low_modes_by_lanczos(rows, springs, layout, count);
}

} // namespace dovetail
