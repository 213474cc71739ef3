// Bodies held by their joint alone: found, held while contacts are open or slip all round, carried through.
#include <gtest/gtest.h>

#include <random>

#include "analyses/branch.hpp"
#include "one_mass.hpp"
#include "small_model.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr NewtonSettings tight{1e-10, 1e-11, 30};

// Pressed on by `load`; `held` springs in each direction.
HarmonicSystem pressed_mass(std::array<double, 3> held, double load, std::array<double, 3> force, double mu = 0.3) {
  return one_mass(held, {0, 0, -load}, force, {Law::coulomb, 20, {10, 10}, {mu, mu}, 0}, 0.05, 7);
}

double entry(Mat J, PetscInt i) { // on the diagonal, on every rank
  PetscInt first, last;
  double value = 0;
  check(MatGetOwnershipRange(J, &first, &last), "");
  if (first <= i && i < last) check(MatGetValues(J, 1, &i, 1, &i, &value), "");
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return value;
}

// So many points, each direction a body of its own: stiff within itself, and held by a spring to the ground. Without
// `within`, each point is a body.
ReducedModel bodies(PetscInt points, std::array<double, 3> held, std::array<double, 3> within) {
  ReducedModel model;
  model.comm = PETSC_COMM_WORLD, model.points = points;
  model.own_points = own_share(model.comm, points), model.own_modes = own_share(model.comm, 0);
  for (PetscInt i = 3 * model.own_points.begin; i < 3 * model.own_points.end; ++i)
    for (PetscInt j = 0; j < 3 * points; ++j)
      model.kxx.push_back(i % 3 != j % 3 ? 0
                                         : (i == j ? within[i % 3] : 0) -
                                               (within[i % 3] - held[i % 3]) / static_cast<double>(points));
  return model;
}

} // namespace

TEST(LooseBody, mean_stiffness_is_the_constant_part_of_the_derivative) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const std::vector<ContactPoint> points{{Law::coulomb, 5, {3, 4}, {0.2, 0.3}, 0},
                                         {Law::cone, 4, {2, 2}, {0.5, 0.5}, -0.1},
                                         {Law::unilateral, 6, {0, 0}, {0, 0}, 0.1},
                                         {Law::bilateral, 6, {0, 0}, {0, 0}, 0.1}};
  const std::vector<Standstill> rest(points.size());
  constexpr int H = 4, n = 2 * H + 1;
  for (const int samples : {exactly, 128}) {
    ContactForces forces(points, rest, H, samples);
    std::vector<double> X(points.size() * 3 * n), G(X.size()), blocks(9 * n * n);
    for (int motion = 0; motion < 30; ++motion) {
      for (double &x : X) x = 0.2 * normal(random);
      for (std::size_t p = 0; p < points.size(); ++p) X[(3 * p + 2) * n] = 0.6; // pressed, and it opens now and then
      forces.evaluate(X.data(), G.data());
      for (int p = 0; p < static_cast<int>(points.size()); ++p) {
        forces.write(p, blocks.data());
        const auto mean = forces.mean_stiffness(p);
        const auto &places = block_places(points[p].law);
        for (std::size_t b = 0; b < places.size(); ++b)
          if (places[b].row == places[b].column) EXPECT_NEAR(mean[places[b].row], blocks[b * n * n], 1e-12);
      }
    }
  }
}

TEST(LooseBody, finds_the_motions_that_only_the_joint_holds) {
  EXPECT_EQ(pressed_mass({1, 1, 1}, 5, {0, 0, 1}).loose_body().motions(), 0);
  EXPECT_EQ(pressed_mass({1, 1, 0}, 5, {0, 0, 1}).loose_body().motions(), 1);
  EXPECT_EQ(pressed_mass({0, 1, 0}, 5, {0, 0, 1}).loose_body().motions(), 2);
  EXPECT_EQ(small_preloaded(PETSC_COMM_WORLD).reduced.contact_dofs(), 9);
  EXPECT_EQ(HarmonicSystem(scaled(small_preloaded(PETSC_COMM_WORLD), 0.05, {}), 3, exactly, course({0, 1}))
                .loose_body()
                .motions(),
            0);
}

// 510 points: as many dofs as a joint of blades has. The last body has little to hold it, but that is no rigid motion.
TEST(LooseBody, finds_rigid_motions_of_many_points) {
  const ReducedModel model = bodies(510, {0, 0, 1e-7}, {1, 2, 3});
  const LooseBody loose(model, Layout(model, 0));
  ASSERT_EQ(loose.motions(), 2);
  const std::vector<double> springs(model.own_contact_dofs(), 1);
  std::vector<double> across = springs; // holds the first of them, not the second
  for (std::size_t i = 1; i < across.size(); i += 3) across[i] = 0;
  EXPECT_FALSE(loose.adrift(springs, springs));
  EXPECT_TRUE(loose.adrift(across, springs));
}

TEST(LooseBody, finds_rigid_motions_in_any_unit_of_stiffness) {
  for (const double unit : {1e-9, 1e9}) {
    const ReducedModel model = bodies(30, {0, 0, 1e-7 * unit}, {unit, 2 * unit, 3 * unit});
    EXPECT_EQ(LooseBody(model, Layout(model, 0)).motions(), 2) << unit;
  }
}

TEST(LooseBody, finds_as_many_motions_as_there_are) { // more than it looks for at first
  const ReducedModel model = bodies(30, {0, 1, 1}, {0, 1, 1});
  EXPECT_EQ(LooseBody(model, Layout(model, 0)).motions(), 30);
  const ReducedModel free = bodies(4, {0, 0, 0}, {0, 0, 0});
  EXPECT_EQ(LooseBody(free, Layout(free, 0)).motions(), 12);
}

// One that nothing holds, the stiffest, and others a hundred times as stiff as a rigid one may be.
TEST(LooseBody, rigid_motions_have_a_hundred_millionth_of_others) {
  ReducedModel model = grounded(30, [](int i) { return i == 0 ? 0 : i == 1 ? 1 : 1e-7; });
  const LooseBody loose(model, Layout(model, 0));
  ASSERT_EQ(loose.motions(), 1);
  std::vector<double> elsewhere(model.own_contact_dofs(), 1);
  if (model.own_points.begin == 0 && !elsewhere.empty()) elsewhere[0] = 0;
  std::vector<double> sums = loose.held(elsewhere, std::vector<double>(elsewhere.size(), 1));
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  EXPECT_NEAR(sums[1], 1, 1e-12);
  EXPECT_LT(std::sqrt(sums[0]), 1e-7);
}

TEST(LooseBody, holds_the_mean_only_while_nothing_else_does) {
  for (const double held : {0.0, 1.0}) {
    HarmonicSystem system = pressed_mass({1, 1, held}, 5, {0, 0, 1});
    const Layout &layout = system.layout();
    UniqueVec y = system.unknowns(), border = system.unknowns();
    UniqueMat J = system.matrix();
    const PetscInt mean = layout.contact_row(2) * layout.width;
    system.jacobian(y, border, J); // closed and stuck
    EXPECT_FALSE(system.adrift());
    EXPECT_DOUBLE_EQ(entry(J, mean), held + 20);
    if (layout.own_points.size() == 1) check(VecSetValue(y, mean, -10, INSERT_VALUES), "");
    check(VecAssemblyBegin(y), ""), check(VecAssemblyEnd(y), "");
    system.jacobian(y, border, J); // open all round
    EXPECT_EQ(system.adrift(), held == 0);
    EXPECT_DOUBLE_EQ(entry(J, mean), held == 0 ? 5 : 1);
  }
}

// Three points that nothing but the joint holds along the normal; the first is closed, the others are open.
TEST(LooseBody, holds_those_points_that_are_open_by_a_quarter_of_their_springs) {
  ReducedModel model = grounded(3, [](int i) { return i % 3 == 2 ? 0.0 : 2.0 + i; });
  model.loads[0].fx.assign(model.own_contact_dofs(), 0);
  const std::size_t points = model.own_points.size();
  const Law laws[] = {Law::coulomb, Law::cone, Law::unilateral};
  std::vector<ContactPoint> contact;
  for (PetscInt p = model.own_points.begin; p < model.own_points.end; ++p) {
    const double k = 10.0 * static_cast<double>(p + 1), kt = laws[p] == Law::unilateral ? 0 : 1;
    contact.push_back({laws[p], k, {kt * (k + 1), kt * (k + 2)}, {0.5, 0.5}, 0});
  }
  HarmonicSystem system(scaled({std::move(model), contact, std::vector<Standstill>(points)}, 0.05, {}), 2, exactly,
                        course({0, 1}));
  const Layout &layout = system.layout();
  ASSERT_EQ(system.loose_body().motions(), 3);
  UniqueVec y = system.unknowns();
  const UniqueVec border = system.unknowns();
  for (PetscInt p = layout.own_points.begin; p < layout.own_points.end; ++p)
    check(VecSetValue(y, layout.contact_row(3 * p + 2) * layout.width, p == 0 ? 1 : -1, INSERT_VALUES), "");
  check(VecAssemblyBegin(y), ""), check(VecAssemblyEnd(y), "");
  const UniqueMat J = system.matrix(), T = system.matrix(true);
  for (const bool evaluated : {false, true}) {
    UniqueVec f = system.unknowns();
    if (evaluated) system.residual(y, f);
    system.jacobian(y, border, J), system.transposed_jacobian(y, border, T);
    EXPECT_TRUE(system.adrift());
    for (int i = 0; i < 9; ++i) {
      const double k = 10 * (i / 3 + 1), spring = i % 3 == 2 ? k : i / 3 == 2 ? 0 : k + 1 + i % 3;
      const double wanted = (i % 3 == 2 ? 0 : 2 + i) + (i < 3 ? spring : spring / 4);
      EXPECT_DOUBLE_EQ(entry(J, layout.contact_row(i) * layout.width), wanted) << i;
      EXPECT_DOUBLE_EQ(entry(T, layout.contact_row(i) * layout.width), wanted) << i;
    }
  }
}

// It bounces: the mass leaves the joint for a part of every period.
TEST(LooseBody, is_followed_through_lift_off) {
  HarmonicSystem system = pressed_mass({1, 1, 0}, 5, {0, 0, 4});
  UniqueVec y = system.unknowns();
  double open = 0;
  const BranchObserver observer{[&](const BranchPoint &point) {
                                  for (const Activity &did : point.activity) open = std::max(open, did.open);
                                },
                                [](const BranchEvent &) {},
                                {},
                                {}};
  BranchSettings settings;
  settings.from = 8, settings.to = 1, settings.step = 0.05, settings.max_points = 2000;
  const auto summary = follow_branch(system, tight, settings, y, observer);
  MPI_Allreduce(MPI_IN_PLACE, &open, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  EXPECT_EQ(summary.end, BranchSummary::End::arrived) << summary.why;
  EXPECT_EQ(summary.counts.leaps, 0);
  EXPECT_GT(open, 0.3);
}

// Gross slip all round: nothing holds the mean, but no mean force pushes either.
TEST(LooseBody, is_followed_through_gross_slip) {
  HarmonicSystem system = pressed_mass({0, 1, 1}, 5, {3, 0, 0}, 0.1);
  UniqueVec y = system.unknowns();
  BranchSettings settings;
  settings.from = 0.5, settings.to = 3, settings.step = 0.05, settings.max_points = 2000;
  const auto summary =
      follow_branch(system, tight, settings, y, {[](const BranchPoint &) {}, [](const BranchEvent &) {}, {}, {}});
  EXPECT_EQ(summary.end, BranchSummary::End::arrived) << summary.why;
}

// A steady push beyond what friction holds while it slips: it walks, there is no periodic motion, and that is said.
TEST(LooseBody, that_walks_is_explained) {
  HarmonicSystem system =
      one_mass({0, 1, 1}, {-0.3, 0, -5}, {8, 0, 0}, {Law::coulomb, 20, {10, 10}, {0.1, 0.1}, 0}, 0.05, 7);
  UniqueVec y = system.unknowns();
  BranchSettings settings;
  settings.from = settings.to = 0.6, settings.max_points = 1;
  const auto summary =
      follow_branch(system, tight, settings, y, {[](const BranchPoint &) {}, [](const BranchEvent &) {}, {}, {}});
  EXPECT_EQ(summary.end, BranchSummary::End::no_start);
  EXPECT_NE(summary.why.find("walks"), std::string::npos) << summary.why;
}
