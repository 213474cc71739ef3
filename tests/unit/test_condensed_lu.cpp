// Direct solves with the modes eliminated first, against elimination written out here.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "small_model.hpp"
#include "support/condensed_lu.hpp"
#include "support/error.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr int width = 5, leading = 2 * width, size = leading + 7;
using Dense = std::vector<double>; // (size, size) by rows

bool coupled(int i, int j) { // mean with itself, cosine and sine of one harmonic with each other
  return i == j ||
         (i / width == j / width && i % width > 0 && j % width > 0 && (i % width - 1) / 2 == (j % width - 1) / 2);
}

Dense numbers(int seed) {
  Dense A(size * size);
  for (int i = 0; i < size; ++i)
    for (int j = 0; j < size; ++j)
      if (i >= leading || j >= leading || coupled(i, j)) A[i * size + j] = wave(seed, i * size + j);
  return A;
}

UniqueMat matrix_of(const Dense &A) {
  UniqueMat out;
  check(MatCreateSeqAIJ(PETSC_COMM_SELF, size, size, size, nullptr, out.out()), "");
  for (int i = 0; i < size; ++i)
    for (int j = 0; j < size; ++j)
      if (A[i * size + j] != 0) check(MatSetValue(out, i, j, A[i * size + j], INSERT_VALUES), "");
  check(MatAssemblyBegin(out, MAT_FINAL_ASSEMBLY), "");
  check(MatAssemblyEnd(out, MAT_FINAL_ASSEMBLY), "");
  return out;
}

double determinant(Dense A) {
  double value = 1;
  for (int k = 0; k < size; ++k) {
    int pivot = k;
    for (int i = k; i < size; ++i)
      if (std::abs(A[i * size + k]) > std::abs(A[pivot * size + k])) pivot = i;
    if (pivot != k) value = -value;
    for (int j = 0; j < size; ++j) std::swap(A[k * size + j], A[pivot * size + j]);
    value *= A[k * size + k];
    for (int i = k + 1; i < size; ++i)
      for (int j = size - 1; j >= k; --j) A[i * size + j] -= A[i * size + k] / A[k * size + k] * A[k * size + j];
  }
  return value;
}

} // namespace

TEST(CondensedLu, solves_and_knows_the_sign_of_the_determinant) {
  UniqueKSP ksp; // one for all, as in a run
  check(KSPCreate(PETSC_COMM_SELF, ksp.out()), "");
  int positive = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    const Dense A = numbers(seed);
    const UniqueMat J = matrix_of(A);
    if (seed == 1)
      factor_condensed(ksp, J, leading, width);
    else
      check(KSPSetOperators(ksp, J, J), "");
    ASSERT_TRUE(is_condensed(ksp));
    UniqueVec b, x, product;
    check(MatCreateVecs(J, x.out(), b.out()), "");
    check(VecDuplicate(b, product.out()), "");
    for (int i = 0; i < size; ++i) check(VecSetValue(b, i, wave(seed + 100, i), INSERT_VALUES), "");
    check(KSPSolve(ksp, b, x), "");
    check(MatMult(J, x, product), "");
    check(VecAXPY(product, -1, b), "");
    PetscReal wrong, large;
    check(VecNorm(product, NORM_INFINITY, &wrong), "");
    check(VecNorm(x, NORM_INFINITY, &large), "");
    EXPECT_LT(wrong, 1e-11 * (1 + large)) << seed;
    EXPECT_EQ(condensed_determinant_sign(ksp), determinant(A) > 0 ? 1 : -1) << seed;
    positive += determinant(A) > 0;
  }
  EXPECT_GT(positive, 4);
  EXPECT_LT(positive, 19);
}

TEST(CondensedLu, tells_singular_matrices_and_goes_on) {
  UniqueKSP ksp;
  check(KSPCreate(PETSC_COMM_SELF, ksp.out()), "");
  const Dense good = numbers(3);
  Dense mode = good, rest = good;
  for (int j = 0; j < size; ++j) mode[j] = 0;                                           // the first mode's mean
  for (int j = 0; j < size; ++j) rest[(size - 1) * size + j] = rest[j * size + 12] = 0; // rows and columns beyond
  bool first = true;
  for (const auto &[A, regular] : {std::pair{good, true}, {mode, false}, {good, true}, {rest, false}, {good, true}}) {
    const UniqueMat J = matrix_of(A);
    first ? factor_condensed(ksp, J, leading, width) : check(KSPSetOperators(ksp, J, J), "");
    first = false;
    UniqueVec b, x;
    check(MatCreateVecs(J, x.out(), b.out()), "");
    check(VecSet(b, 1), "");
    check(KSPSolve(ksp, b, x), "");
    KSPConvergedReason reason;
    check(KSPGetConvergedReason(ksp, &reason), "");
    EXPECT_EQ(reason > 0, regular);
    EXPECT_EQ(condensed_determinant_sign(ksp) != 0, regular);
  }
}
