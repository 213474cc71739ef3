// The lowest modes by both ways: the same, also where many are equal or rigid, on any number of ranks.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "norms.hpp"
#include "reduction/block_lanczos.hpp"
#include "small_model.hpp"
#include "stuck/low_modes.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr int modes = 3, points = 40, contact = 3 * points;

// A row of equal masses joined by springs, free at both ends; in t1, t2 and n the same.
ReducedModel free_row(int length = points) {
  ReducedModel model;
  model.comm = PETSC_COMM_WORLD;
  model.modes = modes, model.points = length;
  model.own_modes = own_share(model.comm, modes), model.own_points = own_share(model.comm, length);
  model.kaa = {1e6, 2e6, 3e6};
  for (int i = 3 * model.own_points.begin; i < 3 * model.own_points.end; ++i) {
    for (int j = 0; j < modes; ++j) model.mxa.push_back(1e-3 * wave(i, j));
    for (int j = 0; j < 3 * length; ++j) {
      const int p = i / 3, neighbours = (p > 0) + (p < length - 1);
      model.kxx.push_back(i == j ? 1e3 * neighbours : i - j == 3 || j - i == 3 ? -1e3 : 0);
      model.mxx.push_back(i == j ? 0.5 : 0);
    }
  }
  model.loads[0].fa.assign(modes, 0.0), model.loads[0].fx.assign(model.own_contact_dofs(), 0.0);
  model.r.assign(model.own_contact_dofs(), 0.0);
  return model;
}

// v_a^T M v_b
double product(const LowModes &low, const ReducedModel &model, const Layout &layout, int a, int b) {
  const std::size_t own = layout.own_dofs(), n = layout.dofs(), own_modes = layout.own_modes.size();
  std::vector<double> both(2 * n); // on every rank
  for (std::size_t d = 0; d < own; ++d) {
    both[layout.number(d)] = low.shapes[a * own + d];
    both[n + layout.number(d)] = low.shapes[b * own + d];
  }
  MPI_Allreduce(MPI_IN_PLACE, both.data(), static_cast<int>(2 * n), MPI_DOUBLE, MPI_SUM, layout.comm);
  const double *u = both.data(), *v = u + n;
  double sum = 0;
  for (std::size_t d = 0; d < own_modes; ++d) sum += u[layout.number(d)] * v[layout.number(d)];
  for (std::size_t i = 0; i < own - own_modes; ++i) {
    const PetscInt number = layout.number(own_modes + i);
    for (int j = 0; j < contact; ++j) sum += u[number] * model.mxx[i * contact + j] * v[modes + j];
    for (int j = 0; j < modes; ++j) sum += model.mxa[i * modes + j] * (u[number] * v[j] + u[j] * v[number]);
  }
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, layout.comm);
  return sum;
}

using Way = std::optional<LowModes> (*)(const PencilRows &, const std::vector<double> &, const Layout &, PetscInt);

} // namespace

TEST(LowModes, of_a_free_row_are_three_times_those_of_a_chain) {
  ReducedModel model = free_row();
  std::fill(model.mxa.begin(), model.mxa.end(), 0.0);
  const Layout layout(model, 0);
  const std::vector<double> none(model.own_contact_dofs());
  for (const Way way : {low_modes_by_lapack, low_modes_by_lanczos}) {
    const auto low = way(model, none, layout, 12);
    ASSERT_TRUE(low);
    ASSERT_EQ(low->squares.size(), 12u);
    for (int j = 0; j < 12; ++j) {
      const double wanted = 4 * 1e3 / 0.5 * std::pow(std::sin(M_PI * (j / 3) / (2 * points)), 2);
      EXPECT_NEAR(low->squares[j], wanted, 1e-9 * 1e3) << j;
      if (j < 3) EXPECT_EQ(low->squares[j], 0);
      if (j >= 3) EXPECT_GT(low->squares[j], 0);
    }
  }
}

TEST(LowModes, both_ways_agree_and_are_orthonormal_in_any_unit_of_stiffness) {
  for (const double unit : {1.0, 1e-24}) {
    ReducedModel model = free_row();
    const Layout layout(model, 0);
    std::vector<double> springs(model.own_contact_dofs());
    for (std::size_t i = 0; i < springs.size(); ++i) springs[i] = 10 + wave(int(3 * layout.own_points.begin + i), 9);
    for (std::vector<double> *stiff : {&model.kaa, &model.kxx, &springs})
      for (double &value : *stiff) value *= unit;
    const auto one = low_modes_by_lapack(model, springs, layout, 10),
               other = low_modes_by_lanczos(model, springs, layout, 10);
    ASSERT_TRUE(one && other);
    for (int j = 0; j < 10; ++j) EXPECT_NEAR(other->squares[j], one->squares[j], 1e-10 * one->squares[j]) << j;
    for (const auto *low : {&*one, &*other})
      for (int a = 0; a < 10; ++a)
        for (int b = 0; b <= a; ++b) EXPECT_NEAR(product(*low, model, layout, a, b), a == b, 1e-9) << a << " " << b;
  }
}

// The first shift, a point's stiffness over its mass, is 1e5 times the lowest square here.
TEST(LowModes, of_a_long_row_take_few_steps) {
  constexpr int many = 300;
  ReducedModel model = free_row(many);
  std::fill(model.mxa.begin(), model.mxa.end(), 0.0);
  const Layout layout(model, 0);
  PetscLogDouble before, after;
  PetscGetFlops(&before);
  const auto low = low_modes_by_lanczos(model, std::vector<double>(model.own_contact_dofs(), 0.01), layout, 10);
  PetscGetFlops(&after);
  const double step = 2.0 * layout.dofs() * layout.dofs() * lanczos_block; // M times a block
  if (alone()) {
    EXPECT_LT((after - before) / step, 300);
  } // 1000 with the first shift; MUMPS counts otherwise
  ASSERT_TRUE(low);
  for (int j = 0; j < 10; ++j) {
    const double wanted = (0.01 + 4 * 1e3 * std::pow(std::sin(M_PI * (j / 3) / (2 * many)), 2)) / 0.5;
    EXPECT_NEAR(low->squares[j], wanted, 1e-8 * wanted) << j;
  }
}

TEST(LowModes, all_of_them_where_more_are_asked_for) {
  const ReducedModel model = small_reduced(PETSC_COMM_WORLD);
  const Layout layout(model, 0);
  const std::vector<double> none(model.own_contact_dofs());
  const auto one = low_modes_by_lapack(model, none, layout, 80), other = low_modes_by_lanczos(model, none, layout, 80);
  ASSERT_TRUE(one && other);
  ASSERT_EQ(one->squares.size(), 11u);
  ASSERT_EQ(other->squares.size(), 11u);
  for (int j = 0; j < 11; ++j) EXPECT_NEAR(other->squares[j], one->squares[j], 1e-9 * one->squares[j]) << j;
}

// Nothing at all is stiff; or the modes of the reduction alone are, in whatever unit.
TEST(LowModes, are_rigid_where_contacts_have_no_stiffness) {
  for (const double unit : {0.0, 1.0, 1e-24, 1e24}) {
    ReducedModel model = small_reduced(PETSC_COMM_WORLD);
    std::fill(model.kxx.begin(), model.kxx.end(), 0.0), std::fill(model.mxa.begin(), model.mxa.end(), 0.0);
    for (double &square : model.kaa) square *= unit;
    const Layout layout(model, 0);
    const std::vector<double> none(model.own_contact_dofs());
    for (const Way way : {low_modes_by_lapack, low_modes_by_lanczos}) {
      const auto low = way(model, none, layout, 11);
      ASSERT_TRUE(low);
      for (int j = 0; j < 11; ++j)
        EXPECT_NEAR(low->squares[j], unit * (j < 9 ? 0 : j == 9 ? 1 : 4), unit > 0 ? 1e-9 * unit : 1e-14) << j;
    }
  }
}

TEST(LowModes, many_are_by_lanczos_and_few_by_lapack) { // the same to the last bit
  for (const int length : {99, 100}) {
    ReducedModel model = free_row(length);
    const Layout layout(model, 0);
    const std::vector<double> springs(model.own_contact_dofs(), 1.0);
    const auto found = low_modes(model, springs, layout, 4),
               wanted = (length == 99 ? low_modes_by_lapack : low_modes_by_lanczos)(model, springs, layout, 4),
               other = (length == 99 ? low_modes_by_lanczos : low_modes_by_lapack)(model, springs, layout, 4);
    ASSERT_TRUE(found && wanted && other);
    EXPECT_EQ(found->shapes, wanted->shapes);
    if (!found->shapes.empty()) EXPECT_NE(found->shapes, other->shapes);
  }
}

// So small that K + shift M is positive definite all the same.
TEST(LowModes, a_little_negative_mass_has_none) {
  ReducedModel model = free_row();
  for (std::size_t i = 0; i < std::size_t(model.own_contact_dofs()); ++i)
    if (3 * model.own_points.begin + i == 50) model.mxx[i * contact + 50] = -1e-3;
  const Layout layout(model, 0);
  const std::vector<double> springs(model.own_contact_dofs(), 1e4);
  for (const Way way : {low_modes_by_lapack, low_modes_by_lanczos}) EXPECT_FALSE(way(model, springs, layout, 10));
}

TEST(LowModes, negative_mass_has_none) {
  ReducedModel model = free_row();
  for (std::size_t i = 0; i < std::size_t(model.own_contact_dofs()); ++i)
    model.mxx[i * contact + 3 * model.own_points.begin + i] *= 3 * model.own_points.begin + i == 50 ? -1 : 1;
  const Layout layout(model, 0);
  const std::vector<double> springs(model.own_contact_dofs(), 1e4);
  for (const Way way : {low_modes_by_lapack, low_modes_by_lanczos}) EXPECT_FALSE(way(model, springs, layout, 10));
}
