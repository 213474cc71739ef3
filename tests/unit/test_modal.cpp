// The modal form of the harmonic system against the assembled one, on as many ranks as the test runs with.
#include <gtest/gtest.h>

#include <cmath>

#include "problems/response_curve.hpp"
#include "small_system.hpp"

using namespace dovetail;
using namespace dovetail::testing;

constexpr int harmonics = 3;

TEST(Modal, residual_and_jacobian_are_those_of_the_assembled_form) {
  for (const auto &laws : {std::vector<Law>{}, {Law::unilateral, Law::cone, Law::bilateral}})
    for (const double size : {0.05, 1.0, 4.0}) { // all stuck; slip; slip and lift-off
      const auto [residual, jacobian] = forms_differ(64, laws, 0.05, size);
      EXPECT_LT(residual, 1e-14);
      EXPECT_LT(jacobian, 1e-13) << size;
    }
}

namespace {

// All stuck; slip; slip and lift-off.
std::vector<double> sizes() { return alone() ? std::vector<double>{0.05, 1.0, 4.0} : std::vector<double>{4.0}; }

struct Misses {
  double rough, precise;
  int iterations; // of both solves
};

// Solves with J at a motion of that size, then at other ones: as well as Newton's method needs, how far x is from what
// it should be; and to `accuracy`, how far J x is from r.
std::vector<Misses> misses(double size, int harmonics, double accuracy = 1e-10, const std::vector<Law> &laws = {}) {
  const HarmonicSystem like = small_system(LinearForm::modal, exactly, laws);
  HarmonicSystem system(like, harmonics, exactly);
  const UniqueVec border = vector_of(system, 1, 7, 0.2), r = vector_of(system, 1, 9, 0.4);
  UniqueVec x = system.unknowns(), rough = system.unknowns(), product = system.unknowns();
  const UniqueMat J = system.matrix();
  UniqueKSP ksp;
  check(KSPCreate(PETSC_COMM_WORLD, ksp.out()), "");
  system.set_up(ksp, J);
  std::vector<Misses> found;
  for (const double more : {1.0, 1.003, 1.01, 1.1, 3.0}) { // with the factors of the first, as long as they do
    const UniqueVec y = vector_of(system, more * size, 3, 1.3);
    system.jacobian(y, border, J);
    check(KSPSetOperators(ksp, J, J), "");
    check(KSPSetTolerances(ksp, 0.5, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "");
    check(KSPSolve(ksp, r, rough), "");
    check(KSPSetTolerances(ksp, accuracy, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "");
    check(KSPSolve(ksp, r, x), "");
    check(MatMult(J, x, product), "");
    found.push_back(
        {relative_difference(rough, x), relative_difference(product, r), system.take_effort(J, 1).iterations});
    EXPECT_GT(found.back().iterations, 1);
    EXPECT_EQ(system.take_effort(J, 1).iterations, 0); // told once
  }
  return found;
}

} // namespace

// All ways; with 40 harmonics the factors, of 729 unknowns, are rough ones. Ranks have whole vectors, or shares of
// them.
TEST(Modal, solves_with_the_jacobian) {
  for (const auto &[factors, modes, whole] : {std::tuple{true, "0", "1000"},
                                              {false, "0", "1000"},
                                              {false, "4", "1000"},
                                              {false, "0", "0"},
                                              {false, "4", "0"}}) {
    const Option most("-hb_factors_most", factors ? "4000" : "0"), lowest("-hb_modal_lowest", modes),
        unknowns("-hb_modal_whole", whole);
    for (const double size : sizes())
      for (const int H : {harmonics, 40})
        for (const Misses &miss : misses(size, H)) {
          EXPECT_LT(miss.rough, 1e-3) << size << " " << H << " " << factors << " " << modes;
          EXPECT_LT(miss.precise, factors ? 1e-8 : 1e-10) << size << " " << H << " " << factors << " " << modes;
        }
  }
}

TEST(Modal, factors_of_all_points_need_no_iteration) { EXPECT_LT(misses(4, harmonics, 1e-8).front().precise, 1e-11); }

TEST(Modal, one_jacobian_alone_is_not_factored) { // 63 unknowns: else they are, in double precision
  HarmonicSystem system = small_system(LinearForm::modal, exactly);
  const UniqueVec y = vector_of(system, 4, 3, 1.3), border = vector_of(system, 1, 7, 0.2),
                  r = vector_of(system, 1, 9, 0.4);
  UniqueVec x = system.unknowns(), product = system.unknowns();
  const UniqueMat J = system.matrix();
  UniqueKSP ksp;
  check(KSPCreate(PETSC_COMM_WORLD, ksp.out()), "");
  system.set_up(ksp, J);
  check(KSPSetTolerances(ksp, 0.2, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "");
  double missed[2];
  for (const bool one : {false, true}) {
    system.begin_solves(J, 1, one);
    system.jacobian(y, border, J);
    check(KSPSetOperators(ksp, J, J), "");
    check(KSPSolve(ksp, r, x), "");
    check(MatMult(J, x, product), "");
    missed[one] = relative_difference(product, r);
  }
  EXPECT_LT(missed[false], 1e-11);
  EXPECT_GT(missed[true], 1e-9);
  EXPECT_LT(missed[true], 0.5);
}

// One Jacobian on which GMRES failed must not have a hundred factored, where iterations are few as a rule.
TEST(Modal, a_failure_is_forgotten_where_few_motions_help) {
  for (const char *modes : {"0", "4"}) {
    const Option lowest("-hb_modal_lowest", modes);
    HarmonicSystem system({small_system(LinearForm::modal, exactly), 40, exactly});
    const UniqueVec y = vector_of(system, 4, 3, 1.3), border = vector_of(system, 1, 7, 0.2),
                    r = vector_of(system, 1, 9, 0.4);
    UniqueVec x = system.unknowns();
    const UniqueMat J = system.matrix();
    UniqueKSP ksp;
    check(KSPCreate(PETSC_COMM_WORLD, ksp.out()), "");
    system.set_up(ksp, J);
    system.begin_solves(J, 1e6);
    system.jacobian(y, border, J);
    check(KSPSetOperators(ksp, J, J), "");
    check(KSPSolve(ksp, r, x), "");
    if (modes[0] == '0')
      EXPECT_GT(system.solver_memory(J), 1e5);
    else
      EXPECT_LT(system.solver_memory(J), 1e4);
  }
}

TEST(Modal, directions_without_friction_are_not_factored) { // 243 unknowns of 729: few enough for double precision
  const Law n = Law::unilateral;
  const Option none("-hb_modal_ksp_max_it", "1"); // in the modes
  EXPECT_LT(misses(4, 40, 1e-8, {n, n, n}).front().precise, 1e-11);
}

TEST(Modal, solves_where_laws_differ) {
  for (const double size : sizes())
    for (const Misses &miss : misses(size, 10, 1e-10, {Law::unilateral, Law::coulomb, Law::bilateral}))
      EXPECT_LT(miss.precise, 1e-8) << size;
}

// With every mode among the lowest ones the preconditioner is the Jacobian's inverse, in single precision: two rounds
// of refinement, of an iteration or two each, where the diagonal alone takes dozens. On several ranks the first one
// owns a part of the modes only, and the solution is as good.
TEST(Modal, lowest_modes_are_solved_with_exactly) {
  const Option most("-hb_factors_most", "0");
  for (const double size : sizes()) {
    const Option all("-hb_modal_lowest", "1000");
    const Misses miss = misses(size, harmonics).front();
    EXPECT_LT(miss.precise, 1e-8) << size;
    if (!alone()) continue;
    EXPECT_LE(miss.iterations, 8) << size;
    const Option none("-hb_modal_lowest", "0");
    EXPECT_GT(misses(size, harmonics).front().iterations, 2 * miss.iterations) << size;
  }
}

TEST(Modal, newton_and_tangent) {
  SolveCounts counts;
  HarmonicSystem assembled = small_system(LinearForm::assembled), modal = small_system(LinearForm::modal);
  ResponseCurve one(assembled, {1e-10, 1e-10, 30}, 1, true, counts), other(modal, {1e-10, 1e-10, 30}, 1, true, counts);
  CurvePoint s = one.point(), t = other.point();
  ASSERT_TRUE(one.solve_at(0.9, s));
  ASSERT_TRUE(other.solve_at(0.9, t));
  EXPECT_LT(relative_difference(t.y, s.y), 1e-8);
  EXPECT_LT(relative_difference(t.t, s.t), 1e-4);
  EXPECT_NE(s.sign, 0);
}

TEST(Modal, sign_of_the_determinant_is_that_of_the_assembled_form) { // from GMRES, new and old factors
  const HarmonicSystem like[] = {small_system(LinearForm::assembled), small_system(LinearForm::modal)};
  for (const auto &[H, modes] : {std::pair{3, "0"}, {40, "0"}, {40, "4"}}) { // 40: in single, where new in double
    const Option lowest("-hb_modal_lowest", modes);
    HarmonicSystem systems[] = {{like[0], H, exactly}, {like[1], H, exactly}};
    const UniqueMat J[] = {systems[0].matrix(), systems[1].matrix()};
    UniqueKSP ksp[2];
    for (int i = 0; i < 2; ++i) {
      check(KSPCreate(PETSC_COMM_WORLD, ksp[i].out()), "");
      systems[i].set_up(ksp[i], J[i]);
      check(KSPSetTolerances(ksp[i], 1e-6, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "");
    }
    int sum = 0, count = 0;
    for (int seed = 0; seed < 40; seed += alone() && H == 3 ? 1 : 4, ++count) { // stuck, slip, open; any border
      int signs[2];
      for (int i = 0; i < 2; ++i) {
        const UniqueVec y = vector_of(systems[i], 0.05 * std::pow(1.1, seed), seed, 1.3),
                        border = vector_of(systems[i], 1, seed / 2 + 7, 0.2), r = vector_of(systems[i], 1, 9, 0.4);
        UniqueVec x = systems[i].unknowns();
        systems[i].jacobian(y, border, J[i]);
        check(KSPSetOperators(ksp[i], J[i], J[i]), "");
        check(KSPSolve(ksp[i], r, x), "");
        signs[i] = systems[i].determinant_sign(ksp[i]);
      }
      EXPECT_EQ(signs[1], signs[0]) << seed;
      sum += signs[0];
    }
    EXPECT_LT(std::abs(sum), count == 40 ? 30 : count); // both signs are met
  }
}

TEST(Modal, other_harmonics_and_the_matrices) {
  const HarmonicSystem assembled = small_system(LinearForm::assembled), modal = small_system(LinearForm::modal);
  HarmonicSystem more(modal, 5, exactly), other(assembled, 5, exactly);
  const UniqueVec y = vector_of(more, 1, 3, 1.3);
  UniqueVec f = more.unknowns(), g = more.unknowns();
  other.residual(y, f), more.residual(y, g);
  EXPECT_LT(relative_difference(g, f), 1e-14);
  const DenseModel a = dense_model(assembled), b = dense_model(modal);
  EXPECT_EQ(a.K, b.K);
  EXPECT_EQ(a.M, b.M);
}
