// Linear solves of the modal form: what they leave of the equations is what was asked, in the norm that they are judged
// in, and is told where it is not.
#include <gtest/gtest.h>
#include <petscsys.h>
// needs the one above
#include <petscblaslapack.h>

#include <cmath>

#include "contact/fourier.hpp"
#include "small_system.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr double omega = 1.3, usual = 1e-4;

// Norm of energy of all equations but the last: the root of r^T (K + K_t + k^2 Om^2 M)^-1 r, summed over coefficients.
double energy(const HarmonicSystem &system, const DenseModel &model, Vec r) {
  const std::vector<double> forces = all_coefficients(system.layout(), r);
  PetscBLASInt n = model.dofs(), one = 1, info;
  const int width = system.layout().width;
  double sum = 0;
  for (int i = 0; i < width; ++i) {
    std::vector<double> A(model.K), x(n);
    const double w = (i + 1) / 2 * omega;
    for (std::size_t j = 0; j < A.size(); ++j) A[j] += w * w * model.M[j];
    for (int p = 0; p < model.points; ++p) {
      const auto springs = stuck_springs(model.contact[p]);
      for (int d = 0; d < 3; ++d) {
        const std::size_t dof = model.modes + 3 * p + d;
        A[dof * n + dof] += springs[d];
      }
    }
    for (int d = 0; d < n; ++d) x[d] = forces[static_cast<std::size_t>(d) * width + i];
    const std::vector<double> force = x;
    LAPACKpotrf_("U", &n, A.data(), &n, &info);
    EXPECT_EQ(info, 0);
    LAPACKpotrs_("U", &n, &one, A.data(), &n, x.data(), &n, &info);
    for (int d = 0; d < n; ++d) sum += force[d] * x[d];
  }
  return std::sqrt(sum);
}

struct Solve {
  double left; // of the equations, relative, in the norm of energy or in the plain one
  int inexact; // solves, as they are counted
};

// One solve at a motion of that size with contacts `stiffness` times as stiff as the small model's; of a right side as
// Newton's method has it, the residual there.
Solve solved(double size, double stiffness, bool by_energy, double asked = 0.5, int harmonics = 20) {
  PreloadedModel preloaded = small_preloaded(PETSC_COMM_WORLD);
  for (ContactPoint &point : preloaded.contact) {
    point.kn *= stiffness;
    for (double &kt : point.kt) kt *= stiffness;
  }
  const HarmonicSystem few(scaled(std::move(preloaded), 0.05, {}), 3, exactly, course({0.2, 1.0, 0.3}),
                           LinearForm::modal);
  HarmonicSystem system(few, harmonics, exactly);
  const DenseModel model = dense_model(system);
  const UniqueVec y = vector_of(system, size, 3, omega), border = vector_of(system, 1, 7, 0.2);
  UniqueVec r = system.unknowns(), x = system.unknowns(), left = system.unknowns();
  const UniqueMat J = system.matrix();
  UniqueKSP ksp;
  check(KSPCreate(PETSC_COMM_WORLD, ksp.out()), "");
  system.set_up(ksp, J);
  system.residual(y, r);
  system.jacobian(y, border, J);
  check(KSPSetOperators(ksp, J, J), "");
  check(KSPSetTolerances(ksp, asked, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "");
  check(KSPSolve(ksp, r, x), "");
  check(MatMult(J, x, left), "");
  check(VecAYPX(left, -1, r), "");
  const double part = by_energy ? energy(system, model, left) / energy(system, model, r) : norm(left) / norm(r);
  return {part, system.take_effort(J, 1).inexact};
}

} // namespace

TEST(LinearSolves, leave_what_was_asked_in_the_norm_of_energy) { // preconditioned on the left, up to a thousand times
  const Option modes_only("-hb_factors_most", "0");
  for (const double stiffness : {1.0, 1e3, 1e6})
    for (const double size : {0.05, 1.0, 4.0}) { // all stuck; slip; slip and lift-off
      const Solve one = solved(size, stiffness, true);
      if (one.inexact == 0) EXPECT_LT(one.left, 2 * usual) << size << " " << stiffness;
      EXPECT_EQ(one.inexact > 0, one.left > 2 * usual) << size << " " << stiffness << " " << one.left;
    }
}

TEST(LinearSolves, with_factors_leave_what_was_asked_in_the_norm_of_newtons_residual) {
  const Option factors_only("-hb_modal_ksp_max_it", "1");
  for (const double stiffness : {1.0, 1e3, 1e6})
    for (const double size : {0.05, 1.0, 4.0}) {
      const Solve one = solved(size, stiffness, false);
      EXPECT_LE(one.left, usual) << size << " " << stiffness;
      EXPECT_EQ(one.inexact, 0) << size << " " << stiffness;
    }
}

TEST(LinearSolves, what_single_precision_leaves_is_solved_for_again) {
  const Option modes_only("-hb_factors_most", "0");
  for (const double size : {0.05, 1.0, 4.0}) {
    const Solve one = solved(size, 1, false, 1e-10);
    EXPECT_LE(one.left, 1e-10) << size;
    EXPECT_EQ(one.inexact, 0) << size;
  }
}

TEST(LinearSolves, in_a_basis_that_is_nearly_of_modes_leave_what_was_asked) {
  const Option near("-hb_modal_many", "0");
  for (const double asked : {1e-4, 1e-10})
    for (const double size : {0.05, 1.0, 4.0}) {
      const Solve one = solved(size, 1, false, asked, 1);
      EXPECT_LE(one.left, asked) << size;
      EXPECT_EQ(one.inexact, 0) << size;
    }
}

TEST(LinearSolves, that_leave_more_are_counted) {
  const Option modes_only("-hb_factors_most", "0"), few("-hb_modal_ksp_max_it", "2");
  const Solve one = solved(4, 1e3, true);
  EXPECT_GT(one.left, 2 * usual);
  EXPECT_EQ(one.inexact, 1);
}
