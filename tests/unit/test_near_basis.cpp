// The basis that stands for all modes of a structure of many dofs: what is diagonal in it, and how far it is not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "small_model.hpp"
#include "stuck/low_modes.hpp"
#include "stuck/near_basis.hpp"
#include "support/error.hpp"

using namespace dovetail;
using dovetail::testing::grounded;

namespace {

constexpr int modes = 7, points = 60, contact = 3 * points, dofs = modes + contact;
constexpr double spring = 1.5;

// Symmetric, made of products of far and near numbers.
double wave(int i, int j) {
  return std::sin(0.37 * (std::min(i, j) + 1) * (std::max(i, j) + 2)) / (1 + std::abs(i - j));
}
double stiffness(int i, int j) { // but for springs
  if (i < modes || j < modes) return i == j ? 1 + i : 0;
  return (i == j ? 3 + 0.1 * i * i : 0) + 0.4 * wave(i, j);
}
double mass(int i, int j) {
  if (i < modes && j < modes) return i == j;
  return (i == j ? 2 : 0) + 0.1 * wave(i, j);
}

ReducedModel model() {
  ReducedModel made;
  made.comm = PETSC_COMM_WORLD, made.file = "made-up.h5";
  made.modes = modes, made.points = points;
  made.own_modes = own_share(made.comm, modes), made.own_points = own_share(made.comm, points);
  for (int j = 0; j < modes; ++j) made.kaa.push_back(stiffness(j, j));
  for (int i = modes + 3 * made.own_points.begin; i < modes + 3 * made.own_points.end; ++i) {
    for (int j = 0; j < modes; ++j) made.mxa.push_back(mass(i, j));
    for (int j = modes; j < dofs; ++j) made.kxx.push_back(stiffness(i, j)), made.mxx.push_back(mass(i, j));
  }
  return made;
}

std::optional<StuckBasis> basis_of(const ReducedModel &model, double reach = 0) {
  return near_basis(model, std::vector<double>(model.own_contact_dofs(), spring), Layout(model, 1), reach);
}

// Phi by number, (dofs, dofs), on every rank.
std::vector<double> whole(const StuckBasis &basis, const Layout &layout) {
  std::vector<double> all(dofs * dofs);
  basis.each_part(0, [&](const double *rows, std::size_t stride, std::size_t first, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
      std::copy_n(rows + i * stride, dofs, &all[layout.number(static_cast<PetscInt>(first + i)) * dofs]);
  });
  MPI_Allreduce(MPI_IN_PLACE, all.data(), dofs * dofs, MPI_DOUBLE, MPI_SUM, layout.comm);
  return all;
}

// Phi^T A Phi
template <class Entry> std::vector<double> projected(const std::vector<double> &phi, const Entry &entry) {
  std::vector<double> half(dofs * dofs), made(dofs * dofs);
  for (int i = 0; i < dofs; ++i)
    for (int j = 0; j < dofs; ++j)
      if (const double a = entry(i, j); a != 0)
        for (int k = 0; k < dofs; ++k) half[i * dofs + k] += a * phi[j * dofs + k];
  for (int i = 0; i < dofs; ++i)
    for (int j = 0; j < dofs; ++j)
      for (int k = 0; k < dofs; ++k) made[j * dofs + k] += phi[i * dofs + j] * half[i * dofs + k];
  return made;
}

} // namespace

TEST(NearBasis, makes_the_stiffness_diagonal_and_the_mass_of_the_lowest_modes) {
  const ReducedModel given = model();
  const Layout layout(given, 1);
  const auto basis = basis_of(given);
  ASSERT_TRUE(basis && basis->near);
  EXPECT_EQ(basis->exact.rows(), 0u);
  EXPECT_EQ(basis->springs, std::vector<double>(given.own_contact_dofs(), spring));
  ASSERT_EQ(basis->lambda.size(), std::size_t(dofs));
  constexpr int lowest = dofs / 4;
  const auto known = low_modes_by_lapack(given, basis->springs, layout, lowest + 1);
  const std::vector<double> &lambda = basis->lambda, phi = whole(*basis, layout);
  for (int j = 0; j < dofs; ++j) {
    const double wanted = j < lowest ? known->squares[j] : 2 * known->squares[lowest];
    EXPECT_NEAR(lambda[j], wanted, 1e-9 * wanted) << j;
  }
  const auto K = projected(phi, [](int i, int j) { return stiffness(i, j) + (i == j && i >= modes ? spring : 0); });
  const auto M = projected(phi, [](int i, int j) { return mass(i, j); });
  double stiff = 0, heavy = 0, least = INFINITY, most = 0, beside = 0;
  for (int i = 0; i < dofs; ++i)
    for (int j = 0; j < dofs; ++j) {
      const double m = M[i * dofs + j];
      stiff = std::max(stiff, std::abs(K[i * dofs + j] / std::sqrt(lambda[i] * lambda[j]) - (i == j)));
      if (std::min(i, j) < lowest)
        heavy = std::max(heavy, std::abs(m - (i == j)));
      else if (i == j)
        least = std::min(least, m), most = std::max(most, m);
      else
        beside = std::max(beside, std::abs(m));
    }
  EXPECT_LT(stiff, 1e-5);
  EXPECT_LT(heavy, 1e-5);
  EXPECT_GT(least, 0); // of the rest, between nothing and twice what it is taken for
  EXPECT_LT(most, 2 + 1e-5);
  EXPECT_LT(beside, 1 + 1e-5);
  EXPECT_GT(beside, 1e-3); // else it were of modes
}

TEST(NearBasis, has_modes_to_four_times_the_highest_frequency) {
  const ReducedModel given = model();
  const auto known =
      low_modes_by_lapack(given, std::vector<double>(given.own_contact_dofs(), spring), Layout(given, 1), dofs);
  const double last = std::sqrt(known->squares[dofs / 4]);
  EXPECT_NEAR(basis_of(given, 0.99 * last / 4)->lambda.back(), 2 * known->squares[dofs / 4], 1e-8);
  EXPECT_NEAR(basis_of(given, 1.01 * last / 4)->lambda.back(), 2 * known->squares[dofs / 4 * 2], 1e-8);
}

TEST(NearBasis, is_none_of_a_stiffness_that_is_not_positive) {
  ReducedModel given = model();
  for (PetscInt i = 0; i < given.own_contact_dofs(); ++i)
    if (3 * given.own_points.begin + i == 5) given.kxx[i * contact + 5] = -2;
  EXPECT_FALSE(basis_of(given));
}

TEST(NearBasis, wants_a_mass_that_is_positive) {
  ReducedModel given = model();
  for (double &value : given.mxx) value = -value;
  EXPECT_THROW(basis_of(given), InputError);
}

// On a diagonal structure of which its rows are more than are turned at a time.
TEST(NearBasis, is_orthonormal_in_the_stiffness_of_many_dofs) {
  constexpr int n = 540;
  const ReducedModel given = grounded(n / 3, [](int i) { return 1.0 + 0.01 * i * i; });
  const Layout layout(given, 1);
  const auto basis = near_basis(given, std::vector<double>(given.own_contact_dofs(), spring), layout, 0);
  ASSERT_TRUE(basis);
  std::vector<double> K(n * n);
  for (PetscInt d = 0; d < layout.own_dofs(); ++d) {
    const double stiff = 1 + 0.01 * std::pow(layout.number(d), 2) + spring;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) K[i * n + j] += stiff * basis->phi.row(d)[i] * basis->phi.row(d)[j];
  }
  MPI_Allreduce(MPI_IN_PLACE, K.data(), n * n, MPI_DOUBLE, MPI_SUM, layout.comm);
  double off = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      off = std::max(off, std::abs(K[i * n + j] / std::sqrt(basis->lambda[i] * basis->lambda[j]) - (i == j)));
  EXPECT_LT(off, 1e-4);
  EXPECT_NEAR(basis->lambda[7], 1 + 0.49 + spring, 1e-9);
  EXPECT_NEAR(basis->lambda[500], 2 * (1 + 36 + spring), 1e-8); // the first beyond 60 modes
}

TEST(NearBasis, is_none_where_single_precision_has_no_such_numbers) {
  for (const double unit : {1e-60, 1e-100}) {
    const ReducedModel given = grounded(20, [&](int i) { return unit * (1.0 + i); });
    const auto basis = near_basis(given, std::vector<double>(given.own_contact_dofs()), Layout(given, 1), 0);
    EXPECT_EQ(basis.has_value(), unit == 1e-60);
  }
}

TEST(NearBasis, is_none_of_few_dofs) {
  const ReducedModel given = grounded(1, [](int i) { return 1.0 + i; });
  EXPECT_FALSE(near_basis(given, std::vector<double>(given.own_contact_dofs()), Layout(given, 1), 0));
}
