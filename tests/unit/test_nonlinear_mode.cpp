// Nonlinear modes as equations: their derivative in every state of the contacts, and that energies balance.
#include <gtest/gtest.h>

#include "mode_equations.hpp"
#include "problems/mode_balance.hpp"
#include "small_system.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

Damping all_kinds() {
  Damping damping(0.05, 0.02, 0.03);
  damping.ratios = {{1, 0.01}}, damping.matrix = true, damping.of_parts = true;
  return damping;
}

} // namespace

TEST(NonlinearMode, derivative_in_every_contact_state) {
  double open = 0, slip = 0, stick = 0;
  for (const Damping &damping : {Damping(0.05), all_kinds()})
    for (const double alpha : {0.004, 0.06, 0.6}) {
      HarmonicSystem system = small_system(LinearForm::assembled, exactly, {}, damping);
      NonlinearMode mode(system);
      const std::array<double, 3> last{1.3, 0.07, std::log10(alpha)};
      const UniqueVec y = mode_vector(mode, alpha, 1, 3, last);
      mode.refer_to(mode_vector(mode, alpha, 1, 8, last));
      mode.evaluate(y);
      for (const Activity &did : system.activity()) open += did.open, slip += did.slip, stick += did.stick();
      EXPECT_LT(derivative_error(mode, y, mode_vector(mode, alpha, 1, 5, {0.4, -0.3, 0.2})), 3e-8) << alpha;
      EXPECT_LT(derivative_error(mode, y, mode_vector(mode, 0, 0, 5, {1, 0, 0})), 1e-8) << alpha;
      EXPECT_LT(derivative_error(mode, y, mode_vector(mode, 0, 0, 5, {0, 1, 0})), 1e-8) << alpha;
      EXPECT_LT(derivative_error(mode, y, mode_vector(mode, 0, 0, 5, {0, 0, 1})), 1e-8) << alpha;
    }
  double met[] = {open, slip, stick};
  MPI_Allreduce(MPI_IN_PLACE, met, 3, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  for (const double share : met) EXPECT_GT(share, 0.1);
}

TEST(NonlinearMode, derivative_of_other_laws) {
  for (const std::vector<Law> &laws : {std::vector<Law>{Law::bilateral, Law::unilateral, Law::coulomb},
                                       std::vector<Law>{Law::unilateral, Law::coulomb, Law::bilateral}})
    for (const double alpha : {0.02, 0.6}) {
      HarmonicSystem system = small_system(LinearForm::assembled, exactly, laws);
      NonlinearMode mode(system);
      const UniqueVec y = mode_vector(mode, alpha, 1, 3, {1.1, 0.02, std::log10(alpha)});
      mode.refer_to(y);
      EXPECT_LT(derivative_error(mode, y, mode_vector(mode, alpha, 1, 6, {0.4, -0.3, 0.2})), 3e-8) << alpha;
    }
}

TEST(NonlinearMode, length_and_phase_are_of_the_first_harmonic_with_the_mass) {
  HarmonicSystem system = small_system(LinearForm::assembled);
  NonlinearMode mode(system);
  const UniqueVec y = mode_vector(mode, 0, 1, 3, {1.1, 0.02, -1});
  mode.refer_to(y);
  EXPECT_NEAR(mode.along_reference(y), 1, 1e-12);
  const DenseModel dense = dense_model(system);
  const std::vector<double> q = all_coefficients(system.layout(), y);
  const int n = dense.dofs(), w = system.layout().width;
  double square = 0, cross = 0, own = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double m = dense.M[i * n + j], c = q[i * w + 1], s = q[i * w + 2];
      square += m * (c * q[j * w + 1] + s * q[j * w + 2]), cross += m * c * q[j * w + 2], own += m * c * q[j * w + 1];
    }
  UniqueVec f = mode.unknowns();
  mode.residual(y, f);
  const double *values;
  check(VecGetArrayRead(f, &values), "");
  if (system.layout().owns_omega()) {
    EXPECT_NEAR(values[system.layout().own_coefficients()], square - 1, 1e-12);
    EXPECT_NEAR(values[system.layout().own_coefficients() + 1], cross / std::sqrt(own), 1e-12);
  }
  check(VecRestoreArrayRead(f, &values), "");
}

// What the residual does along the velocity of any motion is what the energies do not balance by.
TEST(NonlinearMode, energies_are_the_work_of_the_residual) {
  for (const double alpha : {0.004, 0.06, 0.6}) {
    HarmonicSystem system = small_system(LinearForm::assembled, exactly, {}, all_kinds());
    NonlinearMode mode(system);
    const UniqueVec y = mode_vector(mode, alpha, 1, 3, {1.3, 0.07, std::log10(alpha)});
    const double work = work_of_residual(mode, y, alpha);
    const ModeBalance balance = balance_of(mode, mode.evaluate(y));
    EXPECT_NEAR(balance.error() * balance.unit, work, 1e-12 * std::abs(balance.unit)) << alpha;
    EXPECT_GE(balance.friction, -1e-15);
    EXPECT_GT(balance.structure, 0);
  }
}

// By products and FGMRES in the modes of the stuck structure, or by factors: the same matrix, and the same solution.
TEST(NonlinearMode, both_forms_have_one_jacobian) {
  for (const Damping &damping : {Damping(0.05), all_kinds()})
    for (const double alpha : {0.004, 0.06, 0.6}) {
      HarmonicSystem assembled = small_system(LinearForm::assembled, exactly, {}, damping),
                     modal = small_system(LinearForm::modal, exactly, {}, damping);
      NonlinearMode one(assembled), other(modal);
      const std::array<double, 3> last{1.1, 0.03, std::log10(alpha)};
      const UniqueVec y = mode_vector(one, alpha, 1, 3, last), r = mode_vector(one, 1, 1, 5, {0.4, -0.3, 0.2}),
                      plane = mode_vector(one, 0.2, 0.3, 11, {0.1, -0.2, 0.3});
      UniqueVec f = one.unknowns(), g = one.unknowns();
      const auto solved = [&](NonlinearMode &mode, Vec product, Vec x) {
        mode.refer_to(y);
        const auto J = mode.jacobian();
        UniqueKSP ksp;
        check(KSPCreate(PETSC_COMM_WORLD, ksp.out()), "");
        J->set_up(ksp);
        check(KSPSetTolerances(ksp, 1e-11, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "");
        J->begin(J->memory(), false);
        J->assemble(y, plane);
        check(MatMult(J->matrix(), r, product), "");
        check(KSPSolve(ksp, r, x), "");
        EXPECT_EQ(J->take_effort(0).inexact, 0);
      };
      UniqueVec x = one.unknowns(), z = one.unknowns();
      solved(one, f, x), solved(other, g, z);
      EXPECT_LT(relative_difference(g, f), 1e-12) << alpha;
      EXPECT_LT(relative_difference(z, x), 1e-8) << alpha;
    }
}
