#include "stability/wave_system.hpp"

#include <algorithm>
#include <cmath>

#include "modal/dampers.hpp"
#include "support/hash.hpp"
#include "support/mumps.hpp"

namespace dovetail {
namespace {

constexpr double shift = exponent_shift;
constexpr double further = 0.15;   // than the strip is wide: exponents that must be found
constexpr double tolerance = 1e-8; // relative, of 1 / (lambda / Omega - shift)
constexpr PetscInt first_wanted = 24;
constexpr const char *doing = "computing exponents of stability";

UniqueMat sparse(const Layout &layout, PetscInt own, PetscInt all, std::vector<PetscInt> &rows,
                 std::vector<PetscInt> &columns, const std::vector<double> &values) {
  UniqueMat A;
  check(MatCreate(layout.comm, A.out()), doing);
  check(MatSetSizes(A, own, own, all, all), doing);
  check(MatSetType(A, MATAIJ), doing);
  check(MatSetPreallocationCOO(A, rows.size(), rows.data(), columns.data()), doing);
  check(MatSetValuesCOO(A, values.data(), INSERT_VALUES), doing);
  return A;
}

} // namespace

WaveSystem::WaveSystem(const HarmonicSystem &system, Waves waves, double omega, const std::vector<double> &blocks,
                       const std::vector<ContactHistory::Hold> &holds)
    : system_(system), waves_(waves), width_(wave_coefficients(waves, system.harmonics())), omega_(omega),
      own_(system.layout().own_dofs() * width_),
      memory_(holds, waves, system.harmonics(), system.layout().own_modes.size() * width_) {
  const Layout &layout = system.layout();
  std::vector<PetscInt> k_rows, k_columns, rows, columns;
  std::vector<double> k_values, values;
  for (const Coupling &c : system.couplings()) {
    rows.push_back(c.row), columns.push_back(c.column), values.push_back(c.m);
    if (c.stiff) k_rows.push_back(c.row), k_columns.push_back(c.column), k_values.push_back(c.k);
  }
  stiffness_ = sparse(layout, layout.own_dofs(), layout.dofs(), k_rows, k_columns, k_values);
  mass_ = sparse(layout, layout.own_dofs(), layout.dofs(), rows, columns, values);
  check(MatCreateMAIJ(stiffness_, width_, stiffness_kron_.out()), doing);
  check(MatCreateMAIJ(mass_, width_, mass_kron_.out()), doing);
  check(VecCreateMPI(layout.comm, own_, PETSC_DETERMINE, p_.out()), doing);
  for (UniqueVec *v : {&stiff_, &heavy_, &right_}) check(VecDuplicate(p_, v->out()), doing);
  assemble(blocks);
  check(KSPCreate(layout.comm, ksp_.out()), doing);
  check(KSPSetOptionsPrefix(ksp_, "stability_"), doing);
  factor_by_lu(ksp_, shifted_);
  check(KSPSetFromOptions(ksp_), doing);
  const PetscInt size = 2 * own_ + memory_.size();
  check(MatCreateShell(layout.comm, size, size, PETSC_DETERMINE, PETSC_DETERMINE, this, inverse_.out()), doing);
  check(MatShellSetOperation(inverse_, MATOP_MULT, reinterpret_cast<void (*)()>(&WaveSystem::apply_inverse)), doing);
}

void WaveSystem::assemble(const std::vector<double> &blocks) {
  const Layout &layout = system_.layout();
  const double s = shift * omega_;
  const int w = width_;
  std::vector<PetscInt> rows, columns;
  std::vector<double> values;
  const auto add = [&](PetscInt i, PetscInt j, double value) {
    rows.push_back(i), columns.push_back(j), values.push_back(value);
  };
  const Damping damping = system_.damping();
  const double factor = system_.setting().damping; // of dampers
  for (const Coupling &c : system_.couplings()) {
    const PetscInt i = c.row * w, j = c.column * w;
    const double viscous = damping.viscous(c.k, c.m);
    for (int a = 0; a < w; ++a) {
      const double turn = wave_number(waves_, a) * omega_;
      add(i + a, j + a, c.k + s * viscous + (s * s - turn * turn) * c.m);
      if (!is_sine(waves_, a)) continue;
      const double cross = turn * (viscous + 2 * s * c.m);
      add(i + a - 1, j + a, cross), add(i + a, j + a - 1, -cross);
    }
  }
  for (const Dampers::Entry &c : system_.dampers() ? system_.dampers()->entries() : std::vector<Dampers::Entry>())
    for (int a = 0; a < w; ++a) {
      const PetscInt i = c.row * w + a, j = c.column * w + a;
      const double cross = wave_number(waves_, a) * omega_ * factor * c.viscous;
      add(i, j, s * factor * c.viscous);
      if (is_sine(waves_, a)) add(i - 1, j, cross), add(i, j - 1, -cross);
    }
  const double *next = blocks.data();
  for (PetscInt p = 0; p < layout.own_points.size(); ++p) {
    const PetscInt first = (layout.first_dof() + layout.own_modes.size() + 3 * p) * w;
    for (const BlockPlace place : block_places(system_.scaled().model.contact[p].law))
      for (int i = 0; i < w; ++i)
        for (int j = 0; j < w; ++j) add(first + place.row * w + i, first + place.column * w + j, *next++);
  }
  shifted_ = sparse(layout, own_, layout.dofs() * w, rows, columns, values);
}

// With lambda = (shift + t) Omega and Q = J + lambda D + lambda^2 M at t = 0, the problem linearised in (p, r = t p)
// has the eigenvalues 1 / t of (p, r) -> (-Q^-1 (Omega D p + Omega^2 M (2 shift p + r)), p). What sliders remember is
// carried along.
void WaveSystem::apply(const double *x, double *y) {
  const double *p = x, *r = x + own_, *c = r + own_;
  const Damping damping = system_.damping();
  const double squared = omega_ * omega_;
  const double *stiff, *heavy;
  double *right;
  check(VecPlaceArray(p_, p), doing);
  check(MatMult(stiffness_kron_, p_, stiff_), doing);
  check(MatMult(mass_kron_, p_, heavy_), doing);
  check(VecResetArray(p_), doing);
  check(VecPlaceArray(p_, r), doing);
  check(MatMult(mass_kron_, p_, right_), doing);
  check(VecResetArray(p_), doing);
  check(VecGetArrayRead(stiff_, &stiff), doing);
  check(VecGetArrayRead(heavy_, &heavy), doing);
  check(VecGetArray(right_, &right), doing);
  for (PetscInt i = 0; i < own_; ++i) {
    const int a = static_cast<int>(i % width_);
    const double turn = 2 * squared * wave_number(waves_, a); // M d/dtheta p: cosines of sines, sines of cosines
    const double across = wave_number(waves_, a) == 0 ? 0 : is_sine(waves_, a) ? -heavy[i - 1] : heavy[i + 1];
    right[i] =
        -omega_ * damping.viscous(stiff[i], heavy[i]) - turn * across - squared * (2 * shift * heavy[i] + right[i]);
  }
  if (const Dampers *dampers = system_.dampers(); dampers && dampers->is_viscous()) {
    std::vector<double> force(own_);
    dampers->viscous_force(p, width_, force.data());
    for (PetscInt i = 0; i < own_; ++i) right[i] -= omega_ * system_.setting().damping * force[i];
  }
  memory_.push(c, right);
  check(VecRestoreArray(right_, &right), doing);
  check(VecRestoreArrayRead(heavy_, &heavy), doing);
  check(VecRestoreArrayRead(stiff_, &stiff), doing);
  check(VecPlaceArray(p_, y), doing);
  check(KSPSolve(ksp_, right_, p_), doing);
  check(VecResetArray(p_), doing);
  std::copy_n(p, own_, y + own_);
  memory_.follow(c, y, y + 2 * own_);
}

PetscErrorCode WaveSystem::apply_inverse(Mat shell, Vec x, Vec y) {
  WaveSystem *self = nullptr;
  MatShellGetContext(shell, &self);
  return self->courier_.run([&] {
    const double *from;
    double *to;
    check(VecGetArrayRead(x, &from), doing);
    check(VecGetArray(y, &to), doing);
    self->apply(from, to);
    check(VecRestoreArray(y, &to), doing);
    check(VecRestoreArrayRead(x, &from), doing);
  });
}

WaveSystem::Exponents WaveSystem::near_zero(double strip) {
  Exponents out;
  const Layout &layout = system_.layout();
  KSPConvergedReason reason;
  check(KSPSetUp(ksp_), doing);
  check(VecSet(right_, 1), doing);
  check(KSPSolve(ksp_, right_, stiff_), doing);
  check(KSPGetConvergedReason(ksp_, &reason), doing);
  if (reason <= 0) return out;
  UniqueVec start; // noise, the same on any number of ranks
  double *values;
  check(MatCreateVecs(inverse_, start.out(), nullptr), doing);
  check(VecSet(start, 0), doing);
  check(VecGetArray(start, &values), doing);
  for (PetscInt d = 0; d < layout.own_dofs(); ++d)
    for (int i = 0; i < width_; ++i)
      for (int half = 0; half < 2; ++half) {
        const std::uint64_t name = 2 * (static_cast<std::uint64_t>(layout.number(d)) * width_ + i) + half;
        values[half * own_ + d * width_ + i] = 0.5 + static_cast<double>(mix(name + 1)) / 18446744073709551616.0;
      }
  check(VecRestoreArray(start, &values), doing);
  PetscInt all;
  check(VecGetSize(start, &all), doing);
  for (PetscInt wanted = std::min(first_wanted, all); !out.found; wanted = std::min(2 * wanted, all)) {
    UniqueEPS eps;
    check(EPSCreate(layout.comm, eps.out()), doing);
    check(EPSSetOptionsPrefix(eps, "stability_"), doing);
    check(EPSSetOperators(eps, inverse_, nullptr), doing);
    check(EPSSetProblemType(eps, EPS_NHEP), doing);
    check(EPSSetWhichEigenpairs(eps, EPS_LARGEST_MAGNITUDE), doing);
    check(EPSSetTolerances(eps, tolerance, PETSC_DEFAULT), doing);
    check(EPSSetDimensions(eps, wanted, std::min(all, 2 * wanted + 16), PETSC_DEFAULT), doing);
    Vec first = start;
    check(EPSSetInitialSpace(eps, 1, &first), doing);
    check(EPSSetFromOptions(eps), doing);
    const PetscErrorCode code = EPSSolve(eps);
    courier_.rethrow();
    check(code, doing);
    PetscInt converged = 0;
    check(EPSGetConverged(eps, &converged), doing);
    out.values.clear();
    double reach = 0;
    for (PetscInt i = 0; i < converged; ++i) {
      PetscScalar real, imaginary;
      check(EPSGetEigenvalue(eps, i, &real, &imaginary), doing);
      const std::complex<double> t = 1.0 / std::complex<double>(real, imaginary), s = shift + t;
      reach = std::max(reach, std::abs(t));
      if (std::abs(s.imag()) <= strip + 1e-6) out.values.push_back(s);
    }
    out.found = converged >= std::min(wanted, all) && (reach > strip + further || converged >= all);
    if (converged < wanted || wanted == all) break;
  }
  return out;
}

} // namespace dovetail
