// All modes of a dense pencil, on one rank and on all: they solve it, and they are the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "stuck/dense_modes.hpp"
#include "support/error.hpp"

using namespace dovetail;

namespace {

constexpr int modes = 7, points = 60; // dofs in three blocks of spread_modes.cpp

Layout layout() {
  ReducedModel model;
  model.comm = PETSC_COMM_WORLD;
  model.modes = modes, model.points = points;
  model.own_modes = own_share(model.comm, modes), model.own_points = own_share(model.comm, points);
  return Layout(model, 1);
}

// Symmetric, made of products of far and near numbers.
double wave(int i, int j) {
  return std::sin(0.37 * (std::min(i, j) + 1) * (std::max(i, j) + 2)) / (1 + std::abs(i - j));
}
double stiffness(int i, int j) {
  if (i < modes || j < modes) return i == j ? 1 + i : 0;
  return (i == j ? 3 + 0.1 * i : 0) + 0.4 * wave(i, j);
}
double mass(int i, int j) {
  if (i < modes && j < modes) return i == j;
  return (i == j ? 2 : 0) + 0.1 * wave(i, j);
}

struct Rows {
  std::vector<double> K, M;
};

Rows own_rows(const Layout &layout) { // with nothing but the diagonals in the rows of modes
  Rows rows;
  for (PetscInt d = 0; d < layout.own_dofs(); ++d)
    for (PetscInt i = layout.number(d), j = 0; j < layout.dofs(); ++j) {
      rows.K.push_back(i >= modes && j < modes ? 0 : stiffness(i, j));
      rows.M.push_back(i < modes && j != i ? 0 : mass(i, j));
    }
  return rows;
}

// All rows, in the order of their numbers, on every rank.
std::vector<double> whole(const Layout &layout, const std::vector<double> &own) {
  const std::size_t n = layout.dofs();
  std::vector<double> all(n * n);
  for (PetscInt d = 0; d < layout.own_dofs(); ++d) std::copy_n(&own[d * n], n, &all[layout.number(d) * n]);
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(n * n), MPI_DOUBLE, MPI_SUM, layout.comm);
  return all;
}

using Solver = std::vector<double> (*)(const Layout &, std::vector<double> &, std::vector<double> &);

} // namespace

TEST(DenseModes, solve_the_pencil) {
  const Layout dofs = layout();
  const int n = dofs.dofs();
  for (const Solver solver : {dense_modes_on_one_rank, dense_modes_on_all_ranks}) {
    Rows rows = own_rows(dofs);
    const std::vector<double> lambda = solver(dofs, rows.K, rows.M), phi = whole(dofs, rows.K);
    EXPECT_TRUE(rows.M.empty());
    EXPECT_TRUE(std::is_sorted(lambda.begin(), lambda.end()));
    EXPECT_GT(lambda.front(), 0);
    double unsolved = 0, skew = 0;
    for (int a = 0; a < n; ++a) {
      std::vector<double> Kphi(n), Mphi(n);
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) Kphi[i] += stiffness(i, j) * phi[j * n + a], Mphi[i] += mass(i, j) * phi[j * n + a];
      for (int i = 0; i < n; ++i) unsolved = std::max(unsolved, std::abs(Kphi[i] - lambda[a] * Mphi[i]));
      for (int b = 0; b < n; ++b) {
        double product = 0;
        for (int i = 0; i < n; ++i) product += phi[i * n + b] * Mphi[i];
        skew = std::max(skew, std::abs(product - (a == b)));
      }
    }
    EXPECT_LT(unsolved, 1e-12 * lambda.back());
    EXPECT_LT(skew, 1e-12);
  }
}

TEST(DenseModes, negative_mass_has_none) {
  const Layout dofs = layout();
  for (const Solver solver : {dense_modes_on_one_rank, dense_modes_on_all_ranks}) {
    Rows rows = own_rows(dofs);
    for (PetscInt d = 0; d < dofs.own_dofs(); ++d)
      if (dofs.number(d) == modes + 100) rows.M[d * dofs.dofs() + modes + 100] = -1;
    EXPECT_TRUE(solver(dofs, rows.K, rows.M).empty());
    EXPECT_TRUE(rows.K.empty() && rows.M.empty());
  }
}

TEST(DenseModes, of_more_than_can_be_counted_are_refused) { // before any memory is asked for
  Layout dofs = layout();
  dofs.points = 4000000;
  std::vector<double> K, M;
  EXPECT_THROW(dense_modes_on_one_rank(dofs, K, M), ComputeError);
}
