// Which way the modal form solves, and what it counts of that.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "small_system.hpp"
#include "stuck/slab.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr double n = 11, c = 9; // dofs, of contacts

// Operations, as ContactFactors and ModalKrylov count them, where all points move.
struct Work {
  double w, size = c * w;
  double factors() const { return size * size * size + 100 * size * size + 6 * w * c * c * n + 4e5; }
  double solve() const { return 12 * size * size + 8 * n * w * (c + n) + 1e5 + 8 * c * (n + c) * w + 2e5; }
  double in_modes() const {
    const double entries = size * padded<float>(static_cast<int>(w));
    return c * n * 4 * w + 60 * n * w + 3e5 + (entries > 3e5 ? 40 : 15) * entries; // that fit a cache or not
  }
};

// With a ratio there are no windows, and damping is diagonal in the modes.
Damping with_ratio() {
  Damping damping(0.02, 0.03);
  damping.ratios = {{1, 0.01}};
  return damping;
}

struct Scene {
  explicit Scene(int harmonics)
      : system(small_system(LinearForm::modal, exactly, {}, with_ratio()), harmonics, exactly), J(system.matrix()) {
    check(KSPCreate(PETSC_COMM_WORLD, ksp.out()), "");
    system.set_up(ksp, J);
  }
  struct Found {
    double work;
    int iterations, inexact;
  };
  void move(double size, double side = 1) {
    system.jacobian(vector_of(system, size, 3, 1.3), vector_of(system, side, 7, side * 0.2), J);
    check(KSPSetOperators(ksp, J, J), "");
  }
  Found solve(double accuracy) {
    const UniqueVec r = vector_of(system, 1, 9, 0.4);
    UniqueVec x = system.unknowns();
    check(KSPSetTolerances(ksp, accuracy, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "");
    check(KSPSolve(ksp, r, x), "");
    const double work = system.take_solver_work(J);
    const LinearEffort effort = system.take_effort(J, 1);
    EXPECT_EQ(system.take_solver_work(J), 0);
    return {work, effort.iterations, effort.inexact};
  }

  HarmonicSystem system;
  UniqueMat J;
  UniqueKSP ksp;
};

} // namespace

TEST(ModalSolver, what_it_has_learned_is_iterations_and_whether_all_points_are_taken) {
  Scene scene(3);
  EXPECT_EQ(scene.system.solver_memory(scene.J), 10);
  for (const double memory : {7.0, -12.0, 0.0, -0.5}) {
    scene.system.begin_solves(scene.J, memory);
    EXPECT_EQ(scene.system.solver_memory(scene.J), memory);
    EXPECT_EQ(std::signbit(scene.system.solver_memory(scene.J)), memory < 0);
  }
}

// Few unknowns are factored whatever they do, and once for several Jacobians.
TEST(ModalSolver, factors_few_unknowns_and_counts_what_that_takes) {
  Scene scene(3);
  const Work work{7};
  scene.system.begin_solves(scene.J, 5);
  scene.move(4);
  const Scene::Found first = scene.solve(0.5);
  EXPECT_EQ(first.iterations, 1);
  EXPECT_DOUBLE_EQ(first.work, work.factors() + work.solve());
  EXPECT_DOUBLE_EQ(scene.system.solver_memory(scene.J), 5 * 0.95);
  const Scene::Found more = scene.solve(1e-8); // as good as that without an iteration
  EXPECT_EQ(more.iterations, 1);
  EXPECT_DOUBLE_EQ(more.work, work.solve());
  const Scene::Found precise = scene.solve(1e-11);
  EXPECT_GE(precise.iterations, 1);
  EXPECT_DOUBLE_EQ(precise.work, precise.iterations * work.solve());
  scene.move(4.01);
  const Scene::Found next = scene.solve(0.5);
  EXPECT_GT(next.iterations, 1);
  EXPECT_DOUBLE_EQ(next.work, next.iterations * work.solve());
  EXPECT_DOUBLE_EQ(scene.system.solver_memory(scene.J), 5 * 0.95 * 0.95);
  EXPECT_EQ(first.inexact + more.inexact + precise.inexact + next.inexact, 0);
  scene.system.begin_solves(scene.J, 5); // forgets the factors
  scene.move(4);
  EXPECT_DOUBLE_EQ(scene.solve(0.5).work, work.factors() + work.solve());
}

TEST(ModalSolver, counts_iterations_in_the_modes_and_remembers_them) {
  const Option none("-hb_factors_most", "0");
  for (const int H : {3, 20, 92}) {
    Scene scene(H);
    const Work work{2.0 * H + 1};
    scene.system.begin_solves(scene.J, 5);
    scene.move(4);
    const Scene::Found rough = scene.solve(0.5);
    EXPECT_GT(rough.iterations, 2);
    EXPECT_NEAR(rough.work, rough.iterations * work.in_modes(), 1e-6 * rough.work);
    EXPECT_EQ(scene.system.solver_memory(scene.J), rough.iterations);
    const Scene::Found precise = scene.solve(1e-10);
    EXPECT_GT(precise.iterations, rough.iterations);
    EXPECT_EQ(scene.system.solver_memory(scene.J), rough.iterations + precise.iterations);
    scene.move(4.5);
    const Scene::Found next = scene.solve(0.5);
    EXPECT_EQ(scene.system.solver_memory(scene.J), next.iterations);
  }
}

// Factors that serve two Jacobians, or one alone, are made where iterations are expected to take longer.
TEST(ModalSolver, goes_the_way_that_is_expected_to_be_shorter) {
  const Work work{41};
  for (const bool for_one : {false, true}) {
    const double as_long = (work.factors() / (for_one ? 1 : 2) + work.solve()) / work.in_modes();
    for (const double times : {0.98, 1.02}) {
      Scene scene(20);
      scene.system.begin_solves(scene.J, times * as_long, for_one);
      scene.move(4);
      const Scene::Found found = scene.solve(0.5);
      if (times > 1)
        EXPECT_NEAR(found.work, work.factors() + found.iterations * work.solve(), 1e-9 * found.work);
      else
        EXPECT_NEAR(found.work, found.iterations * work.in_modes(), 1e-9 * found.work);
      EXPECT_NEAR(scene.system.solver_memory(scene.J), times > 1 ? 0.95 * times * as_long : found.iterations, 1e-6);
    }
  }
}

// Then factors are made, once as many iterations have been tried as these are worth.
TEST(ModalSolver, turns_to_factors_where_iterations_do_not_end) {
  const Option few("-hb_modal_ksp_max_it", "3");
  Scene scene(20);
  const Work work{41};
  scene.system.begin_solves(scene.J, 1);
  scene.move(4);
  const Scene::Found found = scene.solve(0.5);
  const double by_factors = found.work - work.factors() - 3 * work.in_modes();
  EXPECT_NEAR(by_factors, (found.iterations - 3) * work.solve(), 1e-9 * found.work);
  EXPECT_EQ(found.inexact, 0);
  EXPECT_EQ(scene.system.solver_memory(scene.J), 1 << 20); // so it does at once for the next
  scene.move(4.01);
  EXPECT_NEAR(scene.system.solver_memory(scene.J), 1 << 20, 0);
  const Scene::Found next = scene.solve(0.5);
  EXPECT_NEAR(next.work, next.iterations * work.solve(), 1e-9 * next.work);
}

// The motion is what iterations have come to.
TEST(ModalSolver, tells_where_iterations_do_not_end_and_factors_may_not_be_made) {
  const Option few("-hb_modal_ksp_max_it", "3"), none("-hb_factors_most", "0");
  Scene scene(20);
  scene.move(4);
  const Scene::Found found = scene.solve(0.5);
  EXPECT_EQ(found.inexact, 1);
  EXPECT_NEAR(found.work, 3 * Work{41}.in_modes(), 1e-9 * found.work);
}

// By old factors and iterations; where that is new, by new factors, which then serve the solves.
TEST(ModalSolver, a_sign_that_changes_is_confirmed_by_factors) {
  for (const double side : {1.0, -1.0}) {
    Scene scene(3);
    scene.system.begin_solves(scene.J, 5);
    scene.move(4);
    scene.solve(0.5);
    const int sign = scene.system.determinant_sign(scene.ksp);
    EXPECT_NE(sign, 0);
    scene.move(4.01, side);
    EXPECT_GT(scene.solve(0.5).iterations, 1);
    EXPECT_EQ(scene.system.determinant_sign(scene.ksp), side * sign);
    EXPECT_EQ(scene.solve(1e-8).iterations == 1, side < 0);
  }
}

// Of several rounds of refinement the first, which meets most eigenvalues, tells the sign.
TEST(ModalSolver, signs_of_accurate_solves_are_those_of_the_assembled_form) {
  HarmonicSystem assembled(small_system(LinearForm::assembled, exactly, {}, with_ratio()), 20, exactly);
  const UniqueMat A = assembled.matrix();
  int signs = 0;
  for (int seed = 0; seed < 12; ++seed) {
    const double size = 0.5 * (seed + 1);
    Scene scene(20);
    scene.system.begin_solves(scene.J, 1);
    const UniqueVec y = vector_of(scene.system, size, 3, 1.3), border = vector_of(scene.system, 1, seed / 2 + 7, 0.2);
    scene.system.jacobian(y, border, scene.J), assembled.jacobian(y, border, A);
    check(KSPSetOperators(scene.ksp, scene.J, scene.J), "");
    scene.solve(1e-10);
    UniqueKSP direct;
    check(KSPCreate(PETSC_COMM_WORLD, direct.out()), "");
    assembled.set_up(direct, A);
    check(KSPSetUp(direct), "");
    EXPECT_EQ(scene.system.determinant_sign(scene.ksp), assembled.determinant_sign(direct)) << seed;
    signs += assembled.determinant_sign(direct);
  }
  EXPECT_LT(std::abs(signs), 12);
}

// Factors of another Jacobian are tried for as many iterations as half of what new ones take, two at least. Where they
// were in vain, the next Jacobian is factored at once.
TEST(ModalSolver, gives_up_old_factors_that_do_not_help) {
  for (const int H : {3, 20}) {
    Scene scene(H);
    const Work work{2.0 * H + 1};
    const int tried = std::max(2, static_cast<int>(work.factors() / work.solve() / 2));
    scene.system.begin_solves(scene.J, 1e6);
    scene.move(4);
    scene.solve(0.5);
    scene.move(0.6, -1);
    const Scene::Found found = scene.solve(1e-9);
    EXPECT_GT(found.iterations, tried);
    EXPECT_LT(found.iterations, tried + 6);
    EXPECT_NEAR(found.work, work.factors() + found.iterations * work.solve(), 1e-9 * found.work) << H;
    EXPECT_EQ(found.inexact, 0);
    scene.move(0.601, -1);
    const Scene::Found next = scene.solve(0.5);
    EXPECT_NEAR(next.work, work.factors() + next.iterations * work.solve(), 1e-9 * next.work) << H;
    EXPECT_LT(next.iterations, 4);
  }
}

TEST(ModalSolver, old_factors_serve_as_long_as_they_are_worth_it) {
  for (const int H : {20, 50}) {
    Scene scene(H);
    const Work work{2.0 * H + 1};
    scene.system.begin_solves(scene.J, 1e6);
    scene.move(4);
    scene.solve(0.5);
    scene.move(5);
    const Scene::Found found = scene.solve(1e-6);
    EXPECT_GT(found.iterations, 2);
    EXPECT_NEAR(found.work, found.iterations * work.solve(), 1e-9 * found.work) << H;
  }
}
