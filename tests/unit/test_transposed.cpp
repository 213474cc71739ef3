// The transposed Jacobian: u . J v = J^T u . v, and solves with it, in both forms of plain structures and of sectors.
#include <gtest/gtest.h>

#include "continuation/problem.hpp"
#include "small_sector.hpp"
#include "small_system.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

const std::vector<std::vector<Law>> laws = {{Law::coulomb, Law::coulomb, Law::coulomb},
                                            {Law::unilateral, Law::cone, Law::bilateral}};

double dot(Vec a, Vec b) {
  double value;
  check(VecDot(a, b, &value), "");
  return value;
}

// Largest misses of the product and of a solve, at motions that stick, slip and open.
std::pair<double, double> misses(HarmonicSystem &system, const std::vector<double> &sizes) {
  const UniqueMat J = system.matrix(), T = system.matrix(true);
  UniqueKSP ksp;
  check(KSPCreate(PETSC_COMM_WORLD, ksp.out()), "");
  system.set_up(ksp, T);
  check(KSPSetTolerances(ksp, 1e-10, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "");
  UniqueVec Jv = system.unknowns(), Tu = system.unknowns(), x = system.unknowns();
  std::pair<double, double> worst{0, 0};
  for (const double size : sizes) {
    const UniqueVec y = vector_of(system, size, 3, 1.3), v = vector_of(system, 1, 5, 0.7),
                    u = vector_of(system, 1, 9, 0.4), border = vector_of(system, 1, 7, 0.2);
    system.jacobian(y, border, J), system.transposed_jacobian(y, border, T);
    check(MatMult(J, v, Jv), "");
    check(MatMult(T, u, Tu), "");
    worst.first = std::max(worst.first, std::abs(dot(u, Jv) - dot(Tu, v)) / (norm(Jv) * norm(u)));
    check(KSPSetOperators(ksp, T, T), "");
    check(KSPSolve(ksp, u, x), "");
    check(MatMult(T, x, Tu), "");
    worst.second = std::max(worst.second, relative_difference(Tu, u));
  }
  return worst;
}

// The derivative of the transposed product, along a motion and along the frequency, against differences of it.
double miss_of_second_derivatives(HarmonicSystem &system, double size) {
  constexpr double step = 1e-6;
  const UniqueMat T = system.matrix(true);
  const UniqueVec y = vector_of(system, size, 3, 1.3), along = vector_of(system, 1, 5, 0),
                  u = vector_of(system, 1, 9, 0), fixed = vector_of(system, 0, 1, 1);
  UniqueVec at = system.unknowns(), product = system.unknowns(), expected = system.unknowns(),
            found = system.unknowns();
  const auto add = [&](double motion, double frequency, double weight) {
    check(VecWAXPY(at, motion, along, y), "");
    set_parameter(at, 1.3 + frequency);
    system.transposed_jacobian(at, fixed, T);
    check(MatMult(T, u, product), "");
    check(VecAXPY(expected, weight, product), "");
  };
  for (const double side : {1.0, -1.0}) {
    add(side * step, 0, side / (2 * step));
    add(0, side * 0.1, side / 0.2);
  }
  system.differentiate_twice(y, along, step, u, found);
  return relative_difference(found, expected);
}

Damping every_kind() {
  Damping damping(0.05, 0.01, 0.1);
  damping.ratios = {{1, 0.03}, {2, 0.01}};
  damping.matrix = damping.contact = damping.of_parts = true;
  return damping;
}

} // namespace

TEST(Transposed, products_and_solves) {
  for (const LinearForm form : {LinearForm::assembled, LinearForm::modal})
    for (const auto &law : laws)
      for (const Damping &damping : {Damping(0.05), every_kind()}) {
        HarmonicSystem system = small_system(form, 64, law, damping);
        const auto [product, solve] = misses(system, {0.05, 1.0, 4.0});
        EXPECT_LT(product, 1e-14);
        EXPECT_LT(solve, 1e-9);
      }
}

TEST(Transposed, by_factors_and_by_iterations_with_few_motions_factored) {
  for (const auto &[factors, motions] : {std::pair{"4000", "0"}, {"0", "0"}, {"0", "4"}}) {
    const Option most("-hb_factors_most", factors), lowest("-hb_modal_lowest", motions);
    HarmonicSystem system = small_system(LinearForm::modal, exactly);
    EXPECT_LT(misses(system, {0.05, 1.0, 4.0}).second, 1e-9) << factors << motions;
  }
}

TEST(Transposed, of_sectors) {
  for (const LinearForm form : {LinearForm::assembled, LinearForm::modal}) {
    HarmonicSystem system = sector_system(1, exactly, laws[0], 0.05, {}, true, form);
    const auto [product, solve] = misses(system, {0.004, 0.06, 0.6});
    EXPECT_LT(product, 1e-14);
    EXPECT_LT(solve, 1e-9);
  }
}

TEST(Transposed, second_derivatives) {
  for (const double size : {0.05, 1.0, 4.0})
    for (const LinearForm form : {LinearForm::assembled, LinearForm::modal})
      for (const auto &law : laws)
        for (const Damping &damping : {Damping(0.05), every_kind()}) {
          HarmonicSystem system = small_system(form, 64, law, damping);
          EXPECT_LT(miss_of_second_derivatives(system, size), 1e-8) << size;
        }
  for (const LinearForm form : {LinearForm::assembled, LinearForm::modal})
    for (const double size : {0.004, 0.06, 0.6}) {
      HarmonicSystem system = sector_system(1, exactly, laws[0], 0.05, {}, true, form);
      EXPECT_LT(miss_of_second_derivatives(system, size), 1e-8) << size;
    }
}
