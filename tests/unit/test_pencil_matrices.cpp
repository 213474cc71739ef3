// K_s + shift M and M as PETSc's matrices, and the solves with the former, against dense products. On any number of
// ranks.
#include <gtest/gtest.h>

#include "norms.hpp"
#include "small_model.hpp"
#include "stuck/pencil_matrices.hpp"
#include "support/shell.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

using Reals = std::vector<double>;
constexpr int n = 11;
constexpr double shift = 0.7;

double spring(int contact_dof) { return 2 + wave(contact_dof, 3); }

struct Scene {
  ReducedModel model = small_reduced(PETSC_COMM_WORLD);
  Layout layout{model, 0};
  PencilMatrices pencil{model, springs(), shift, layout};
  Reals stiff, heavy; // (n, n)

  Scene() {
    const SmallMatrices whole;
    heavy = stiff = whole.M;
    for (double &value : stiff) value *= shift;
    for (std::size_t i = 0; i < stiff.size(); ++i) stiff[i] += whole.K[i];
    for (int i = 2; i < n; ++i) stiff[i * (n + 1)] += spring(i - 2);
  }
  Reals springs() const {
    Reals out;
    for (PetscInt i = 0; i < model.own_contact_dofs(); ++i)
      out.push_back(spring(static_cast<int>(3 * model.own_points.begin + i)));
    return out;
  }
  /// Own part of A times waves, or of waves alone.
  Reals wanted(const Reals *A, int column) const {
    Reals out;
    for (PetscInt d = 0; d < layout.own_dofs(); ++d) {
      const int number = static_cast<int>(layout.number(d));
      double sum = A ? 0 : wave(number, column);
      for (int j = 0; j < n && A; ++j) sum += (*A)[number * n + j] * wave(j, column);
      out.push_back(sum);
    }
    return out;
  }
  UniqueVec vector(const Reals &own) const {
    UniqueVec v;
    check(MatCreateVecs(pencil.mass(), v.out(), nullptr), "");
    std::copy(own.begin(), own.end(), Values(v) + 0);
    return v;
  }
  /// Columns that lie further apart than they are long.
  UniqueMat block(const Reals *A, Reals &kept, int columns) const {
    const PetscInt own = layout.own_dofs(), stride = own + 2;
    kept.assign(stride * columns, 9);
    for (int c = 0; c < columns; ++c) {
      const Reals values = wanted(A, c);
      std::copy(values.begin(), values.end(), kept.begin() + c * stride);
    }
    UniqueMat X;
    check(MatCreate(layout.comm, X.out()), "");
    check(MatSetSizes(X, own, PETSC_DECIDE, n, columns), "");
    check(MatSetType(X, MATDENSE), "");
    check(MatDenseSetLDA(X, stride), "");
    check(MatSeqDenseSetPreallocation(X, kept.data()), "");
    check(MatMPIDenseSetPreallocation(X, kept.data()), "");
    check(MatAssemblyBegin(X, MAT_FINAL_ASSEMBLY), ""), check(MatAssemblyEnd(X, MAT_FINAL_ASSEMBLY), "");
    return X;
  }
};

void expect_near(const double *found, const Reals &wanted) {
  for (std::size_t i = 0; i < wanted.size(); ++i) EXPECT_NEAR(found[i], wanted[i], 1e-12) << i;
}

} // namespace

TEST(PencilMatrices, rows_are_those_of_the_contacts_and_diagonals_of_the_modes) {
  Scene scene;
  for (const int again : {0, 1}) // also backwards
    for (PetscInt i = 0; i < scene.layout.own_dofs(); ++i) {
      const PetscInt d = again ? scene.layout.own_dofs() - 1 - i : i, number = scene.layout.number(d);
      const double *row = scene.pencil.row(d);
      for (int j = 0; j < n; ++j)
        EXPECT_NEAR(row[j], number < 2 && j != number ? 0 : scene.stiff[number * n + j], 1e-14) << number << " " << j;
    }
}

TEST(PencilMatrices, products_are_those_of_dense_ones) {
  Scene scene;
  for (const bool stiff : {true, false}) {
    const Mat A = stiff ? scene.pencil.stiffness() : scene.pencil.mass();
    const Reals &dense = stiff ? scene.stiff : scene.heavy;
    const UniqueVec x = scene.vector(scene.wanted(nullptr, 5));
    UniqueVec y = scene.vector(Reals(scene.layout.own_dofs(), 7));
    check(MatMult(A, x, y), "");
    expect_near(ReadValues(y), scene.wanted(&dense, 5));
    for (const int columns : {1, 3}) {
      Reals from, to;
      const UniqueMat X = scene.block(nullptr, from, columns), Y = scene.block(nullptr, to, columns);
      scene.pencil.multiply_block(A, X, Y);
      for (int c = 0; c < columns; ++c) expect_near(&to[c * (scene.layout.own_dofs() + 2)], scene.wanted(&dense, c));
      UniqueMat product; // as PETSc asks for it
      check(MatMatMult(A, X, MAT_INITIAL_MATRIX, PETSC_DEFAULT, product.out()), "");
      check(MatAXPY(product, -1, Y, SAME_NONZERO_PATTERN), "");
      PetscReal off;
      check(MatNorm(product, NORM_FROBENIUS, &off), "");
      EXPECT_LT(off, 1e-13);
    }
  }
}

TEST(PencilMatrices, solves_undo_products) {
  Scene scene;
  UniqueKSP ksp;
  check(KSPCreate(scene.layout.comm, ksp.out()), "");
  ASSERT_TRUE(scene.pencil.set_inverse(ksp));
  const UniqueVec b = scene.vector(scene.wanted(&scene.stiff, 5));
  UniqueVec x = scene.vector(Reals(scene.layout.own_dofs(), 7));
  check(KSPSolve(ksp, b, x), "");
  expect_near(ReadValues(x), scene.wanted(nullptr, 5));
  Reals from, to;
  const UniqueMat B = scene.block(&scene.stiff, from, 3), X = scene.block(&scene.stiff, to, 3);
  scene.pencil.solve_block(B, X);
  for (int c = 0; c < 3; ++c) expect_near(&to[c * (scene.layout.own_dofs() + 2)], scene.wanted(nullptr, c));
  check(KSPMatSolve(ksp, B, X), "");
  for (int c = 0; c < 3; ++c) expect_near(&to[c * (scene.layout.own_dofs() + 2)], scene.wanted(nullptr, c));
}

TEST(PencilMatrices, without_modes_and_not_positive) {
  const ReducedModel model = grounded(3, [](int i) { return 1.0 + i; });
  const Layout layout(model, 0);
  const Reals springs(model.own_contact_dofs(), 0.5);
  PencilMatrices pencil(model, springs, 2, layout);
  UniqueVec x, y;
  check(MatCreateVecs(pencil.mass(), x.out(), y.out()), "");
  for (PetscInt d = 0; d < layout.own_dofs(); ++d) (Values(x) + 0)[d] = wave(static_cast<int>(layout.number(d)), 1);
  for (const bool stiff : {true, false}) {
    check(MatMult(stiff ? pencil.stiffness() : pencil.mass(), x, y), "");
    for (PetscInt d = 0; d < layout.own_dofs(); ++d) {
      const int number = static_cast<int>(layout.number(d));
      EXPECT_NEAR((ReadValues(y) + 0)[d], (stiff ? number + 3.5 : 1) * wave(number, 1), 1e-14);
    }
  }
  UniqueKSP ksp;
  check(KSPCreate(layout.comm, ksp.out()), "");
  EXPECT_TRUE(pencil.set_inverse(ksp));
  PencilMatrices soft(model, springs, -2, layout); // the first is 1 + 0.5 - 2
  EXPECT_FALSE(soft.set_inverse(ksp));
}
