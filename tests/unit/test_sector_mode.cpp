// Nonlinear modes of a cyclic sector, travelling waves: their derivative in every state of the contacts, phase and
// length with a complex mass, and that energies balance. On any number of ranks.
#include "mode_equations.hpp"
#include "problems/mode_balance.hpp"
#include "small_sector.hpp"
#include "stuck/sector_modes.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

Damping proportional() { return {0.03, 0.02, 0.04}; }

UniqueVec point_of(const NonlinearMode &mode, double alpha, int seed, double zeta) {
  return mode_vector(mode, alpha, 1, seed, {1.3, zeta, std::log10(alpha)});
}

} // namespace

TEST(SectorMode, derivative_in_every_contact_state) {
  double open = 0, slip = 0, stick = 0;
  for (const int engine_order : {1, -2, 3, 6})
    for (const double alpha : {0.004, 0.06, 0.6}) {
      HarmonicSystem system = sector_system(engine_order, exactly, {}, proportional());
      NonlinearMode mode(system);
      const UniqueVec y = point_of(mode, alpha, 3, 0.07);
      mode.refer_to(point_of(mode, alpha, 8, 0.07));
      mode.evaluate(y);
      for (const Activity &did : system.activity()) open += did.open, slip += did.slip, stick += did.stick();
      EXPECT_LT(derivative_error(mode, y, mode_vector(mode, alpha, 1, 5, {0.4, -0.3, 0.2})), 3e-8) << alpha;
      for (const std::array<double, 3> &one : {std::array<double, 3>{1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
        EXPECT_LT(derivative_error(mode, y, mode_vector(mode, 0, 0, 5, one)), 1e-8) << alpha;
    }
  double met[] = {open, slip, stick};
  MPI_Allreduce(MPI_IN_PLACE, met, 3, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  for (const double share : met) EXPECT_GT(share, 0.1);
}

TEST(SectorMode, another_instant_to_count_from_changes_the_phase_alone) {
  HarmonicSystem system = sector_system(2, exactly, {}, proportional());
  NonlinearMode mode(system);
  const double alpha = 0.004, turn = 0.4; // all points stick
  const UniqueVec y = point_of(mode, alpha, 3, 0.07);
  mode.refer_to(y);
  EXPECT_NEAR(mode.along_reference(y), 1, 1e-12);
  const Layout &layout = system.layout();
  UniqueVec z = mode.unknowns(), f = mode.unknowns(), g = mode.unknowns();
  const auto turned = [&](Vec from, Vec to) { // harmonic k by k times the angle
    const double *c;
    double *out;
    check(VecCopy(from, to), "");
    check(VecGetArrayRead(from, &c), "");
    check(VecGetArray(to, &out), "");
    for (PetscInt d = 0; d < layout.own_dofs(); ++d)
      for (int k = 1; k <= layout.width / 2; ++k) {
        const PetscInt a = d * layout.width + cosine(k), b = d * layout.width + sine(k);
        out[a] = c[a] * std::cos(k * turn) - c[b] * std::sin(k * turn);
        out[b] = c[a] * std::sin(k * turn) + c[b] * std::cos(k * turn);
      }
    check(VecRestoreArray(to, &out), "");
    check(VecRestoreArrayRead(from, &c), "");
  };
  turned(y, z);
  EXPECT_NEAR(mode.along_reference(z), std::cos(turn), 1e-12);
  mode.residual(y, f), mode.residual(z, g);
  UniqueVec h = mode.unknowns();
  turned(f, h);
  if (layout.owns_omega()) {
    const double *one, *other;
    check(VecGetArrayRead(h, &one), "");
    check(VecGetArrayRead(g, &other), "");
    const PetscInt rows = layout.own_coefficients();
    EXPECT_NEAR(one[rows], other[rows], 1e-12);                                     // the length is the same,
    EXPECT_NEAR(one[rows + 1], 0, 1e-12);                                           // and the phase was right before,
    EXPECT_NEAR(other[rows + 1], std::sin(turn) * std::sqrt(1 + one[rows]), 1e-12); // not after it
    check(VecRestoreArrayRead(g, &other), "");
    check(VecRestoreArrayRead(h, &one), "");
    for (Vec v : {Vec(h), Vec(g)}) check(VecSetValue(v, layout.unknowns(), 0, INSERT_VALUES), "");
  }
  for (Vec v : {Vec(h), Vec(g)}) check(VecAssemblyBegin(v), ""), check(VecAssemblyEnd(v), "");
  EXPECT_LT(relative_difference(g, h), 1e-12);
}

// By products and FGMRES in the modes of the stuck structure, or by factors: the same matrix, and the same solution.
TEST(SectorMode, both_forms_have_one_jacobian) {
  for (const int engine_order : {1, -2})
    for (const double alpha : {0.004, 0.06, 0.6}) {
      HarmonicSystem assembled = sector_system(engine_order, exactly, {}, proportional()),
                     modal = sector_system(engine_order, exactly, {}, proportional(), {}, true, LinearForm::modal);
      NonlinearMode one(assembled), other(modal);
      const UniqueVec y = point_of(one, alpha, 3, 0.03), r = mode_vector(one, 1, 1, 5, {0.4, -0.3, 0.2}),
                      plane = mode_vector(one, 0.2, 0.3, 11, {0.1, -0.2, 0.3});
      UniqueVec f = one.unknowns(), g = one.unknowns(), x = one.unknowns(), z = one.unknowns();
      const auto solved = [&](NonlinearMode &mode, Vec product, Vec answer) {
        mode.refer_to(y);
        const auto J = mode.jacobian();
        UniqueKSP ksp;
        check(KSPCreate(PETSC_COMM_WORLD, ksp.out()), "");
        J->set_up(ksp);
        check(KSPSetTolerances(ksp, 1e-11, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "");
        J->begin(J->memory(), false);
        J->assemble(y, plane);
        check(MatMult(J->matrix(), r, product), "");
        check(KSPSolve(ksp, r, answer), "");
        EXPECT_EQ(J->take_effort(0).inexact, 0);
      };
      solved(one, f, x), solved(other, g, z);
      EXPECT_LT(relative_difference(g, f), 1e-12) << alpha;
      EXPECT_LT(relative_difference(z, x), 1e-8) << alpha;
    }
}

TEST(SectorMode, energies_are_the_work_of_the_residual) {
  for (const int engine_order : {1, -2})
    for (const double alpha : {0.004, 0.06, 0.6}) {
      HarmonicSystem system = sector_system(engine_order, exactly, {}, proportional());
      NonlinearMode mode(system);
      const UniqueVec y = point_of(mode, alpha, 3, 0.07);
      const double work = work_of_residual(mode, y, alpha);
      const ModeBalance balance = balance_of(mode, mode.evaluate(y));
      EXPECT_NEAR(balance.error() * balance.unit, work, 1e-12 * std::abs(balance.unit)) << alpha;
      EXPECT_GT(balance.structure, 0);
    }
}

TEST(SectorMode, a_load_of_another_nodal_diameter_does_no_work) { // harmonic 1 of the load has been taken away
  ReducedModel model = small_sector();
  std::vector<ContactPoint> contact = small_contact(model);
  std::string note;
  const std::vector<double> zero(model.own_contact_dofs(), 0.0);
  ScaledModel made = scaled(contact_preload(std::move(model), std::move(contact), zero, note), 0.05, {});
  made.engine_order = 1;
  for (const auto &[series, works] : {std::pair(std::vector<double>{0, 1}, true), {{0, 0, 0, 1}, false}}) {
    HarmonicSystem system(made, harmonics, exactly, course(series));
    NonlinearMode mode(system);
    const UniqueVec y = point_of(mode, 0.06, 3, 0.07);
    EXPECT_EQ(std::isfinite(balance_of(mode, mode.evaluate(y)).load), works);
  }
}

TEST(SectorMode, modes_of_an_index_solve_its_equations) { // and those of -h are conjugate
  const ReducedModel model = small_sector();
  const std::vector<double> springs(model.own_contact_dofs(), 2.5);
  const int n = 11;
  for (const int h : {0, 1, 2, -2, 3}) {
    const SectorModes modes = sector_modes(model, h, springs, 4);
    const HermitianPencil of = pencil(model, std::abs(h), springs, 0);
    int rank;
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
    if (rank > 0) continue;
    const auto turned = [&](Complex value) { return h < 0 ? std::conj(value) : value; };
    for (int j = 0; j < 4; ++j) {
      double size = 0;
      Complex length = 0;
      for (int i = 0; i < n; ++i) {
        Complex stiff = 0, heavy = 0;
        for (int k = 0; k < n; ++k)
          stiff += turned(of.K(i, k)) * modes.shapes(k, j), heavy += turned(of.M(i, k)) * modes.shapes(k, j);
        size = std::max(size, std::abs(stiff - modes.squares[j] * heavy));
        length += std::conj(modes.shapes(i, j)) * heavy;
      }
      EXPECT_LT(size, 1e-11) << h;
      EXPECT_NEAR(std::abs(length - 1.0), 0, 1e-12) << h;
    }
  }
}
