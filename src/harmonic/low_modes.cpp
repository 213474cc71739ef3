#include "harmonic/low_modes.hpp"

#include <slepc/private/epsimpl.h> // the values on the way

#include <algorithm>
#include <cmath>
#include <numeric>

#include "harmonic/dense_modes.hpp"
#include "harmonic/stuck_basis.hpp"
#include "reduction/block_lanczos.hpp"
#include "support/dense_inverse.hpp"
#include "support/error.hpp"
#include "support/hash.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "computing resonances";
constexpr PetscInt few = 300;               // dofs; LAPACK finds all of their modes in some hundredths of a second
constexpr double rigid = 1e-9;              // of the strain energy that the entries of a mode would meet one by one
constexpr double lanczos_tolerance = 1e-12; // residual relative to the value
constexpr double far = 30;       // times the last square sought: from there on a lower shift is worth factors
constexpr double nearest = 1e-9; // the least shift, relative to the first: K + shift M stays definite

double noise(std::uint64_t seed) { // in [-1, 1), the same for the same seed
  return static_cast<double>(mix(seed + 0x9e3779b97f4a7c15u) >> 11) * 0x1p-52 - 1;
}

// Stiffness of each own dof by itself, springs included.
std::vector<double> diagonal_of(const ReducedModel &model, const std::vector<double> &springs, const Layout &layout) {
  std::vector<double> diagonal(model.kaa.begin() + layout.own_modes.begin, model.kaa.begin() + layout.own_modes.end);
  for (std::size_t i = 0; i < springs.size(); ++i)
    diagonal.push_back(model.kxx[i * model.contact_dofs() + 3 * layout.own_points.begin + i] + springs[i]);
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
double shift_of(const ReducedModel &model, const std::vector<double> &diagonal, const Layout &layout) {
  const std::size_t own_modes = layout.own_modes.size(), nc = model.contact_dofs();
  double least = INFINITY;
  for (std::size_t d = 0; d < diagonal.size(); ++d) {
    const std::size_t i = d - own_modes;
    const double mass = d < own_modes ? 1 : model.mxx[i * nc + 3 * layout.own_points.begin + i];
    if (diagonal[d] > 0 && mass > 0) least = std::min(least, diagonal[d] / mass);
  }
  MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_DOUBLE, MPI_MIN, layout.comm);
  return std::isfinite(least) ? least : 1;
}

// K + shift M and M, whole, by the rows of the harmonic system.
struct Operators {
  UniqueMat A, M;
};

Operators operators(const ReducedModel &model, const std::vector<double> &springs, double shift, const Layout &layout) {
  const PetscInt own = layout.own_dofs(), n = layout.dofs(), na = layout.modes, nc = 3 * layout.points;
  std::vector<PetscInt> columns(nc);
  for (PetscInt j = 0; j < nc; ++j) columns[j] = layout.contact_row(j);
  Operators made;
  for (UniqueMat *matrix : {&made.A, &made.M}) {
    const bool mass = matrix == &made.M;
    check(MatCreateDense(layout.comm, own, own, n, n, nullptr, matrix->out()), doing);
    const auto put = [&](PetscInt row, PetscInt column, double value) {
      check(MatSetValue(*matrix, row, column, value, INSERT_VALUES), doing);
    };
    for (PetscInt j = layout.own_modes.begin; j < layout.own_modes.end; ++j)
      put(layout.mode_row(j), layout.mode_row(j), mass ? 1 : model.kaa[j] + shift);
    std::vector<double> line(nc);
    for (PetscInt i = 0; i < 3 * layout.own_points.size(); ++i) {
      const PetscInt dof = 3 * layout.own_points.begin + i, row = layout.contact_row(dof);
      const double *m = &model.mxx[std::size_t(i) * nc], *k = &model.kxx[std::size_t(i) * nc];
      for (PetscInt j = 0; j < nc; ++j) line[j] = mass ? m[j] : k[j] + shift * m[j];
      if (!mass) line[dof] += springs[i];
      check(MatSetValues(*matrix, 1, &row, nc, columns.data(), line.data(), INSERT_VALUES), doing);
      for (PetscInt j = 0; j < na; ++j) {
        const double value = (mass ? 1 : shift) * model.mxa[std::size_t(i) * na + j];
        put(row, layout.mode_row(j), value), put(layout.mode_row(j), row, value);
      }
    }
    check(MatAssemblyBegin(*matrix, MAT_FINAL_ASSEMBLY), doing);
    check(MatAssemblyEnd(*matrix, MAT_FINAL_ASSEMBLY), doing);
    check(MatSetOption(*matrix, MAT_SPD, PETSC_TRUE), doing);
  }
  return made;
}

// Noise that is the same on any number of ranks.
void set_start(EPS eps, Mat A, const Layout &layout) {
  const PetscInt width = std::min(lanczos_block, layout.dofs());
  std::vector<UniqueVec> owned(width);
  std::vector<Vec> vectors;
  for (PetscInt j = 0; j < width; ++j) {
    double *values;
    check(MatCreateVecs(A, owned[j].out(), nullptr), doing);
    check(VecGetArrayWrite(owned[j], &values), doing);
    for (PetscInt d = 0; d < layout.own_dofs(); ++d) values[d] = noise(layout.number(d) * lanczos_block + j);
    check(VecRestoreArrayWrite(owned[j], &values), doing);
    vectors.push_back(owned[j]);
  }
  check(EPSSetInitialSpace(eps, width, vectors.data()), doing);
}

// Shift-and-invert about 0 with factors of A: LAPACK's, or `spread` of several ranks.
void set_inverse(EPS eps, Mat A, std::optional<DenseInverse> &spread) {
  ST st;
  KSP ksp;
  PC pc;
  int size;
  MPI_Comm_size(PetscObjectComm(reinterpret_cast<PetscObject>(eps)), &size);
  check(EPSGetST(eps, &st), doing);
  check(STSetType(st, STSINVERT), doing);
  check(STGetKSP(st, &ksp), doing);
  if (size > 1) return spread.emplace(A).set_up(ksp, A);
  check(KSPSetType(ksp, KSPPREONLY), doing);
  check(KSPGetPC(ksp, &pc), doing);
  check(PCSetType(pc, PCCHOLESKY), doing);
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

bool solved(EPS eps, std::optional<DenseInverse> &spread) { // false if M is not positive definite
  try {
    const PetscErrorCode code = EPSSolve(eps);
    if (spread) spread->rethrow();
    check(code, doing);
  } catch (const ComputeError &error) {
    if (std::string(error.what()).find("inner product is not well defined") == std::string::npos) throw;
    return false;
  }
  return true;
}

} // namespace

std::optional<LowModes> low_modes_by_lapack(const ReducedModel &model, const std::vector<double> &springs,
                                            const Layout &layout, PetscInt count) {
  const std::size_t n = layout.dofs(), own = layout.own_dofs(), found = std::min<std::size_t>(count, n);
  auto [phi, M] = own_pencil(model, springs, layout);
  LowModes modes{dense_modes_on_one_rank(layout, phi, M), std::vector<double>(found * own)};
  if (modes.squares.empty()) return {};
  modes.squares.resize(found);
  for (std::size_t j = 0; j < found; ++j)
    for (std::size_t d = 0; d < own; ++d) modes.shapes[j * own + d] = phi[d * n + j];
  set_rigid_to_zero(diagonal_of(model, springs, layout), layout, modes);
  return modes;
}

std::optional<LowModes> low_modes_by_lanczos(const ReducedModel &model, const std::vector<double> &springs,
                                             const Layout &layout, PetscInt count) {
  const std::vector<double> diagonal = diagonal_of(model, springs, layout);
  const double first = shift_of(model, diagonal, layout);
  const PetscInt wanted = std::min(count, layout.dofs());
  Shift shift{first, nearest * first};
  Operators pencil;
  std::optional<DenseInverse> spread;
  UniqueEPS eps;
  register_block_lanczos();
  do {
    shift.lower = false;
    pencil = operators(model, springs, shift.square, layout);
    check(EPSCreate(layout.comm, eps.out()), doing);
    check(EPSSetOperators(eps, pencil.A, pencil.M), doing);
    check(EPSSetProblemType(eps, EPS_GHEP), doing);
    check(EPSSetType(eps, block_lanczos), doing);
    check(EPSSetDimensions(eps, wanted, PETSC_DEFAULT, PETSC_DEFAULT), doing);
    check(EPSSetTolerances(eps, lanczos_tolerance, PETSC_DEFAULT), doing);
    check(EPSSetWhichEigenpairs(eps, EPS_TARGET_MAGNITUDE), doing);
    check(EPSSetStoppingTestFunction(eps, stop_if_far, &shift, nullptr), doing);
    set_inverse(eps, pencil.A, spread);
    set_start(eps, pencil.A, layout);
    if (!solved(eps, spread)) return {};
  } while (shift.lower);
  PetscInt converged;
  check(EPSGetConverged(eps, &converged), doing);
  if (converged < wanted)
    throw ComputeError("while computing resonances: only " + std::to_string(converged) + " of " +
                       std::to_string(wanted) + " modes converged");
  std::vector<double> values(converged);
  for (PetscInt j = 0; j < converged; ++j) check(EPSGetEigenvalue(eps, j, &values[j], nullptr), doing);
  std::vector<PetscInt> order(converged);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](PetscInt a, PetscInt b) { return values[a] < values[b]; });
  LowModes modes;
  UniqueVec shape;
  check(MatCreateVecs(pencil.A, shape.out(), nullptr), doing);
  for (PetscInt j = 0; j < wanted; ++j) {
    const double *v;
    modes.squares.push_back(values[order[j]] - shift.square);
    check(EPSGetEigenvector(eps, order[j], shape, nullptr), doing);
    check(VecGetArrayRead(shape, &v), doing);
    modes.shapes.insert(modes.shapes.end(), v, v + diagonal.size());
    check(VecRestoreArrayRead(shape, &v), doing);
  }
  set_rigid_to_zero(diagonal, layout, modes);
  return modes;
}

std::optional<LowModes> low_modes(const ReducedModel &model, const std::vector<double> &springs, const Layout &layout,
                                  PetscInt count) {
  return layout.dofs() <= few ? low_modes_by_lapack(model, springs, layout, count)
                              : low_modes_by_lanczos(model, springs, layout, count);
}

} // namespace dovetail
