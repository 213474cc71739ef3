// Matrices dealt out over a grid of ranks, and their factors, against LAPACK on one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/block_cyclic.hpp"
#include "support/dense.hpp"
#include "support/hash.hpp"
#include "support/partition.hpp"

using namespace dovetail;

namespace {

double number(int i, int j) { return static_cast<double>(mix(1000003u * i + j + 1) >> 11) * 0x1p-52 - 1; }

std::vector<std::vector<int>> shares(int n) { // the last rank first
  int size;
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  std::vector<std::vector<int>> rows(size);
  for (int r = 0; r < size; ++r)
    for (PetscInt i = share_of(n, r, size).begin; i < share_of(n, r, size).end; ++i)
      rows[size - 1 - r].push_back(static_cast<int>(i));
  return rows;
}

std::vector<int> own(const std::vector<std::vector<int>> &rows) {
  int rank;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  return rows[rank];
}

} // namespace

TEST(BlockCyclic, returns_the_rows_it_was_given) {
  for (const int n : {1, 65, 3000}) { // of the last, more than travel at a time
    const auto rows = shares(n);
    const std::vector<int> mine = own(rows);
    const BlockCyclic grid(PETSC_COMM_WORLD, n, rows);
    std::vector<double> line(n);
    const auto local = grid.take(BlockCyclic::Part::whole, [&](std::size_t i) {
      for (int j = 0; j < n; ++j) line[j] = mine[i] + 1e4 * j;
      return line.data();
    });
    const std::vector<double> back = grid.give(local);
    ASSERT_EQ(back.size(), mine.size() * n);
    int wrong = 0;
    for (std::size_t i = 0; i < mine.size(); ++i)
      for (int j = 0; j < n; ++j) wrong += back[i * n + j] != mine[i] + 1e4 * j;
    EXPECT_EQ(wrong, 0) << n;
  }
}

TEST(BlockCyclic, factors_solve_as_those_of_one_rank_do) {
  for (const int n : {3, 64, 200, 201}) {
    const auto rows = shares(n);
    const std::vector<int> mine = own(rows);
    const BlockCyclic grid(PETSC_COMM_WORLD, n, rows, n % 2); // the ranks in a row, or not
    Dense A(n, n);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) A(i, j) = number(i, j) + (i == n - 1 - j ? 5 : 0); // wants rows exchanged
    SpreadFactors factors(grid);
    std::vector<double> line(n), b(2 * n), one;
    ASSERT_TRUE(factors.factor([&](std::size_t i) {
      for (int j = 0; j < n; ++j) line[j] = A(mine[i], j);
      return line.data();
    }));
    for (int i = 0; i < 2 * n; ++i) b[i] = number(i, n);
    one = b;
    std::vector<double> alone(b.begin(), b.begin() + n);
    factors.solve(b.data(), 2);
    factors.solve(alone.data());
    Factors lapack;
    ASSERT_TRUE(lapack.factor(A));
    lapack.solve(one.data()), lapack.solve(one.data() + n);
    for (int i = 0; i < 2 * n; ++i) EXPECT_NEAR(b[i], one[i], 1e-12) << n << " " << i;
    for (int i = 0; i < n; ++i) EXPECT_NEAR(alone[i], one[i], 1e-12) << n << " " << i;
  }
}

TEST(BlockCyclic, a_singular_matrix_is_told_on_all_ranks) {
  constexpr int n = 130;
  const auto rows = shares(n);
  const std::vector<int> mine = own(rows);
  const BlockCyclic grid(PETSC_COMM_WORLD, n, rows);
  std::vector<double> line(n);
  EXPECT_FALSE(SpreadFactors(grid).factor([&](std::size_t i) {
    std::fill(line.begin(), line.end(), 0.0);
    if (mine[i] != 70) line[mine[i]] = 1;
    return line.data();
  }));
}
