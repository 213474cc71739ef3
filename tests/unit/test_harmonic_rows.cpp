// Rows and coefficients of the harmonic system: how they are dealt out, padded, and made of the reduced model.
#include <gtest/gtest.h>

#include <cmath>

#include "continuation/problem.hpp"
#include "harmonic/loose_body.hpp"
#include "small_system.hpp"
#include "stuck/joint_shapes.hpp"
#include "stuck/low_modes.hpp"
#include "stuck/own_rows.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

using Reals = std::vector<double>;
constexpr std::size_t n = 11;

UniqueVec numbered(const Layout &layout, double last) { // 100 dof + coefficient
  UniqueVec y;
  double *own;
  check(VecCreateMPI(layout.comm, layout.own_unknowns(), layout.unknowns(), y.out()), "");
  check(VecGetArray(y, &own), "");
  for (PetscInt d = 0; d < layout.own_dofs(); ++d)
    for (int i = 0; i < layout.width; ++i) own[d * layout.width + i] = 100.0 * layout.number(d) + i;
  if (layout.owns_omega()) own[layout.own_coefficients()] = last;
  check(VecRestoreArray(y, &own), "");
  return y;
}

// (own contact dofs) of springs that differ.
Reals some_springs(const ReducedModel &model) {
  Reals springs;
  for (PetscInt i = 0; i < model.own_contact_dofs(); ++i)
    springs.push_back(2 + wave(static_cast<int>(3 * model.own_points.begin + i), 3));
  return springs;
}

} // namespace

TEST(Coefficients, are_dropped_or_zero_where_harmonics_differ) {
  const ReducedModel model = small_reduced(PETSC_COMM_WORLD);
  for (const int from : {1, 3})
    for (const int to : {0, 1, 2, 4}) {
      const Layout old(model, from), now(model, to);
      const UniqueVec y = numbered(old, 7), z = numbered(now, 5), all_of_z = numbered(now, 5);
      const Reals given = all_coefficients(old, y);
      pad(old, y, now, z);
      set_coefficients(now, given, all_of_z);
      const Reals padded_ones = all_coefficients(now, z), set_ones = all_coefficients(now, all_of_z);
      ASSERT_EQ(given.size(), n * old.width);
      ASSERT_EQ(padded_ones.size(), n * now.width);
      for (std::size_t d = 0; d < n; ++d) {
        for (int i = 0; i < old.width; ++i) EXPECT_EQ(given[d * old.width + i], 100.0 * static_cast<double>(d) + i);
        for (int i = 0; i < now.width; ++i) {
          const double wanted = i < old.width ? 100.0 * static_cast<double>(d) + i : 0;
          EXPECT_EQ(padded_ones[d * now.width + i], wanted);
          EXPECT_EQ(set_ones[d * now.width + i], wanted);
        }
      }
      EXPECT_EQ(parameter_of(z), 7);
      EXPECT_EQ(parameter_of(all_of_z), 5); // is left alone
    }
}

TEST(OwnRows, of_modes_come_from_those_who_have_the_columns) {
  const ReducedModel model = small_reduced(PETSC_COMM_WORLD), whole = small_reduced(PETSC_COMM_SELF);
  const Layout layout(model, 1);
  const Slab<double> rows = rows_of_modes(model.mxa, layout);
  ASSERT_EQ(rows.rows(), static_cast<std::size_t>(layout.own_modes.size()));
  ASSERT_EQ(rows.columns(), 9u);
  for (PetscInt mode = layout.own_modes.begin; mode < layout.own_modes.end; ++mode)
    for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(rows.row(mode - layout.own_modes.begin)[i], whole.mxa[i * 2 + mode]);
}

TEST(StuckBasis, is_of_the_pencil_with_springs) {
  const ReducedModel model = small_reduced(PETSC_COMM_WORLD);
  const Layout layout(model, 1);
  const Reals springs = some_springs(model);
  Reals all(9);
  std::copy(springs.begin(), springs.end(), all.begin() + 3 * model.own_points.begin);
  MPI_Allreduce(MPI_IN_PLACE, all.data(), 9, MPI_DOUBLE, MPI_SUM, layout.comm);
  const auto [K, M] = SmallMatrices();
  const Pencil own = own_pencil(model, springs, layout);
  for (PetscInt d = 0; d < layout.own_dofs(); ++d)
    for (std::size_t j = 0; j < n; ++j) {
      const std::size_t i = layout.number(d);
      EXPECT_EQ(own.K[d * n + j], K[i * n + j] + (i == j && i > 1 ? all[i - 2] : 0));
      if (i > 1 || j < 2) EXPECT_EQ(own.M[d * n + j], M[i * n + j]); // modes have their diagonal only
    }
  const StuckBasis basis = stuck_basis(model, springs, layout);
  Reals shapes(n * n); // by rows, on every rank
  for (PetscInt d = 0; d < layout.own_dofs(); ++d)
    for (std::size_t j = 0; j < n; ++j) {
      shapes[layout.number(d) * n + j] = basis.exact.row(d)[j];
      EXPECT_EQ(basis.phi.row(d)[j], static_cast<float>(basis.exact.row(d)[j]));
    }
  MPI_Allreduce(MPI_IN_PLACE, shapes.data(), n * n, MPI_DOUBLE, MPI_SUM, layout.comm);
  const auto product = [&](const Reals &A, std::size_t a, std::size_t b) {
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) sum += shapes[i * n + a] * A[i * n + j] * shapes[j * n + b];
    return sum;
  };
  Reals stuck = K;
  for (std::size_t i = 2; i < n; ++i) stuck[i * (n + 1)] += all[i - 2];
  for (std::size_t a = 0; a < n; ++a) {
    if (a > 0) EXPECT_GE(basis.lambda[a], basis.lambda[a - 1]);
    EXPECT_NEAR(basis.damped[a], product(K, a, a), 1e-11);
    EXPECT_EQ(basis.rates[a], 0);
    EXPECT_EQ(basis.losses[a], 0);
    EXPECT_DOUBLE_EQ(rate_of(basis, {static_cast<int>(a) + 1, 0.03}), 0.06 * std::sqrt(basis.lambda[a]));
    for (std::size_t b = 0; b < n; ++b) {
      EXPECT_NEAR(product(M, a, b), a == b, 1e-12);
      EXPECT_NEAR(product(stuck, a, b), a == b ? basis.lambda[a] : 0, 1e-11);
    }
  }
  StuckBasis negative;
  negative.lambda = {-1e-9};
  EXPECT_EQ(rate_of(negative, {1, 0.03}), 0);
  EXPECT_TRUE(basis.dampers_are_diagonal());
}

namespace {

// Points of which each direction is a body of its own, held by a spring to the ground.
ReducedModel bodies(PetscInt points, std::array<double, 3> held) {
  ReducedModel model;
  model.comm = PETSC_COMM_WORLD, model.points = points;
  model.own_points = own_share(model.comm, points), model.own_modes = own_share(model.comm, 0);
  for (PetscInt i = 3 * model.own_points.begin; i < 3 * model.own_points.end; ++i)
    for (PetscInt j = 0; j < 3 * points; ++j) {
      model.kxx.push_back(i % 3 != j % 3 ? 0 : (i == j) - (1 - held[i % 3]) / static_cast<double>(points));
      model.mxx.push_back(i == j);
    }
  return model;
}

} // namespace

TEST(LooseBodies, are_rigid_up_to_a_billionth_and_adrift_up_to_a_millionth) {
  for (const double held : {0.9e-9, 1.1e-9}) {
    const ReducedModel model = bodies(4, {held, 1, 1});
    EXPECT_EQ(LooseBody(model, Layout(model, 0)).motions(), held < 1e-9);
  }
  const ReducedModel model = bodies(4, {0, 0, 1});
  const LooseBody loose(model, Layout(model, 0));
  ASSERT_EQ(loose.motions(), 2);
  const auto each = [&](double t1, double t2, double normal) {
    Reals out;
    for (PetscInt i = 0; i < model.own_contact_dofs(); ++i) out.push_back(i % 3 == 0 ? t1 : i % 3 == 1 ? t2 : normal);
    return out;
  };
  const Reals springs = each(2, 100, 1e9); // the stiffest of what holds them counts: 100
  EXPECT_TRUE(loose.adrift(each(0.99e-4, 1, 0), springs));
  EXPECT_FALSE(loose.adrift(each(1.01e-4, 1, 0), springs));
  EXPECT_TRUE(loose.adrift(each(1, 0.99e-4, 0), springs));
  EXPECT_FALSE(loose.adrift(each(1, 1.01e-4, 0), springs));
  Reals held = loose.held(each(3, 5, 7), springs);
  ASSERT_EQ(held.size(), 8u);
  MPI_Allreduce(MPI_IN_PLACE, held.data(), 8, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  EXPECT_NEAR(held[0] + held[3], 3 + 5, 1e-9); // traces and determinants of both
  EXPECT_NEAR(held[0] * held[3] - held[1] * held[2], 15, 1e-9);
  EXPECT_NEAR(held[4] + held[7], 102, 1e-9);
  EXPECT_NEAR(held[4] * held[7] - held[5] * held[6], 200, 1e-8);
}

TEST(ManyJointShapes, are_two_dozen_at_most) {
  const ReducedModel model = bodies(20, {1, 1, 1}); // no body is tied to another: the joint has half of all energies
  const Layout layout(model, 0);
  const StuckBasis basis = stuck_basis(model, Reals(model.own_contact_dofs(), 1), layout);
  EXPECT_EQ(basis.shapes.size(), 60u * 24);
  const StuckBasis soft = stuck_basis(model, Reals(model.own_contact_dofs(), 0.1), layout); // 1 / 11 of it
  EXPECT_TRUE(soft.shapes.empty());
  const StuckBasis enough = stuck_basis(model, Reals(model.own_contact_dofs(), 0.12), layout);
  EXPECT_EQ(enough.shapes.size(), 60u * 24);
  const ReducedModel few = bodies(3, {1, 1, 1});
  EXPECT_EQ(stuck_basis(few, Reals(few.own_contact_dofs(), 1), Layout(few, 0)).shapes.size(), 9u * 9);
}

TEST(RigidLowModes, are_up_to_a_billionth_of_their_dofs_own_stiffness) {
  for (const double held : {0.7e-9, 0.9e-9}) {
    const ReducedModel model = bodies(5, {held, 1, 1}); // of a dof itself 0.8
    const Layout layout(model, 0);
    const Reals none(model.own_contact_dofs());
    for (const auto way : {low_modes_by_lapack, low_modes_by_lanczos}) {
      const auto low = way(model, none, layout, 3);
      ASSERT_TRUE(low);
      EXPECT_NEAR(low->squares[0], held < 0.8e-9 ? 0 : held, 1e-12);
    }
  }
}
