// The modal form of a sector against the assembled one: every engine order, all ways to solve, on as many ranks as the
// test runs with.
#include <gtest/gtest.h>

#include <cmath>

#include "small_sector.hpp"
#include "stuck/joint_shapes.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr LinearForm forms[] = {LinearForm::assembled, LinearForm::modal};
const std::vector<Law> mixed = {Law::cone, Law::bilateral, Law::unilateral};

HarmonicSystem sector_as(LinearForm form, int engine_order, const std::vector<Law> &laws = {}) {
  return sector_system(engine_order, exactly, laws, 0.05, {}, true, form);
}

struct Solver {
  HarmonicSystem &system;
  UniqueMat J = system.matrix();
  UniqueKSP ksp;

  explicit Solver(HarmonicSystem &of) : system(of) {
    check(KSPCreate(PETSC_COMM_WORLD, ksp.out()), "");
    system.set_up(ksp, J);
  }
  UniqueVec solve(Vec y, Vec border, Vec r, double accuracy) {
    UniqueVec x = system.unknowns();
    system.jacobian(y, border, J);
    check(KSPSetOperators(ksp, J, J), "");
    check(KSPSetTolerances(ksp, accuracy, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "");
    check(KSPSolve(ksp, r, x), "");
    return x;
  }
};

} // namespace

TEST(SectorModal, residual_and_jacobian_are_those_of_the_assembled_form) {
  for (const auto &laws : {std::vector<Law>{}, mixed})
    for (const int engine_order : {0, 1, -1, 2, 3, 5, 6}) {
      HarmonicSystem assembled = sector_as(forms[0], engine_order, laws),
                     modal = sector_as(forms[1], engine_order, laws);
      const UniqueMat A = assembled.matrix(), B = modal.matrix();
      for (const double size : {0.004, 0.06, 0.6}) { // from all stuck to all opening
        const UniqueVec y = vector_of(modal, size, 3, 0.8), v = vector_of(modal, 1, 5, 0.7),
                        border = vector_of(modal, 1, 7, 0.2);
        UniqueVec f = modal.unknowns(), g = modal.unknowns();
        assembled.residual(y, f), modal.residual(y, g);
        EXPECT_LT(relative_difference(g, f), 1e-14) << engine_order << " " << size;
        assembled.jacobian(y, border, A), modal.jacobian(y, border, B);
        check(MatMult(A, v, f), "");
        check(MatMult(B, v, g), "");
        EXPECT_LT(relative_difference(g, f), 1e-13) << engine_order << " " << size;
      }
    }
}

// By factors of the contacts; in the modes by the diagonal alone; among few motions; among all there are, where no
// iteration is left to do. And the sign of the determinant.
TEST(SectorModal, solves_with_the_jacobian) {
  struct Way {
    const char *factored, *lowest;
    int iterations; // at most, where it counts
  };
  for (const auto &[factored, lowest, iterations] :
       {Way{"4000", "0", 0}, {"0", "0", 0}, {"0", "3", 0}, {"0", "1000", 8}})
    for (const int engine_order : {1, -1, 2}) {
      const Option most("-hb_factors_most", factored), modes("-hb_modal_lowest", lowest);
      HarmonicSystem assembled = sector_as(forms[0], engine_order), modal = sector_as(forms[1], engine_order);
      for (const double size : {0.004, 0.06, 0.6}) {
        Solver one(assembled), other(modal);
        const UniqueVec y = vector_of(modal, size, 3, 0.8), border = vector_of(modal, 1, 7, 0.2),
                        r = vector_of(modal, 1, 9, 0.4);
        const UniqueVec x = one.solve(y, border, r, 1e-10), rough = other.solve(y, border, r, 1e-3);
        EXPECT_LT(relative_difference(rough, x), 0.05) << lowest << " " << engine_order << " " << size;
        const UniqueVec precise = other.solve(y, border, r, 1e-10);
        EXPECT_LT(relative_difference(precise, x), 1e-8) << lowest << " " << engine_order << " " << size;
        const int sign = modal.determinant_sign(other.ksp);
        if (*factored != '0') EXPECT_EQ(sign, assembled.determinant_sign(one.ksp)) << engine_order << " " << size;
        const int taken = modal.take_effort(other.J, 1).iterations;
        if (iterations > 0 && alone()) EXPECT_LE(taken, iterations) << engine_order << " " << size;
      }
    }
}

TEST(SectorModal, more_and_fewer_harmonics_have_indices_of_their_own) {
  HarmonicSystem assembled = sector_as(forms[0], 1), modal = sector_as(forms[1], 1);
  for (const int other : {1, 2, 9}) {
    HarmonicSystem a(assembled, other, exactly), b(modal, other, exactly);
    const UniqueVec y = vector_of(a, 0.3, 5, 1.1);
    UniqueVec f = a.unknowns(), g = a.unknowns();
    a.residual(y, f), b.residual(y, g);
    EXPECT_LT(relative_difference(g, f), 1e-14) << other;
  }
}

// Shapes are orthonormal in the energy of the stuck structure, orthogonal in that of the springs, and the first ones
// hold what the largest eigenvalues of the springs' energy are.
TEST(SectorModal, joint_shapes_of_a_complex_basis) {
  const ReducedModel model = small_sector();
  const Layout layout(model, 1);
  const std::vector<double> springs(model.own_contact_dofs(), 3.0);
  const std::vector<StuckBasis> bases = stuck_bases(model, {&model.indices[0], &model.indices[2]}, springs, layout);
  for (const StuckBasis &basis : bases) {
    const std::size_t n = layout.dofs(), count = basis.shapes.size() / (2 * n), own_modes = layout.own_modes.size();
    ASSERT_GT(count, 2u);
    const auto shape = [&](std::size_t k, std::size_t j) {
      return Complex(basis.shapes[k * 2 * n + j], basis.shapes[k * 2 * n + n + j]);
    };
    std::vector<Complex> at_contacts(count * springs.size());
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t d = 0; d < springs.size(); ++d)
        for (std::size_t j = 0; j < n; ++j) {
          const double *row = basis.exact.row(own_modes + d);
          at_contacts[k * springs.size() + d] += Complex(row[j], row[n + j]) * shape(k, j);
        }
    double last = 1;
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t i = 0; i < count; ++i) {
        Complex strained = 0, held = 0;
        for (std::size_t j = 0; j < n; ++j) strained += basis.lambda[j] * std::conj(shape(i, j)) * shape(k, j);
        for (std::size_t d = 0; d < springs.size(); ++d)
          held += 3.0 * std::conj(at_contacts[i * springs.size() + d]) * at_contacts[k * springs.size() + d];
        double sums[] = {held.real(), held.imag()};
        MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
        EXPECT_LT(std::abs(strained - (i == k ? 1.0 : 0.0)), 1e-10);
        if (i != k) EXPECT_LT(std::hypot(sums[0], sums[1]), 1e-6);
        if (i != k) continue;
        EXPECT_GT(sums[0], 0.1);
        EXPECT_LE(sums[0], last + 1e-9);
        last = sums[0];
      }
  }
}
