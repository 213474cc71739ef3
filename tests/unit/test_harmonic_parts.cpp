// Parts of the harmonic system by themselves: groups of harmonics, numbers of all ranks, factors, and where the
// structure resonates.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "harmonic/gathering.hpp"
#include "modal/index_groups.hpp"
#include "modal/rough_factors.hpp"
#include "small_model.hpp"
#include "stuck/resonances.hpp"
#include "stuck/sector_frequencies.hpp"
#include "support/error.hpp"

using namespace dovetail;
using namespace dovetail::testing;

using Ints = std::vector<int>;
using Reals = std::vector<double>;

TEST(IndexGroups, hold_harmonics_of_one_nodal_diameter) {
  const std::vector<IndexGroup> four = groups_of({4, 1}, 9); // indices 0, 1, 2, -1, 0
  ASSERT_EQ(four.size(), 3u);
  const Ints places[] = {{0, 7, 8}, {1, 2, 5, 6}, {3, 4}}, partners[] = {{0, 2, 1}, {1, 0, 3, 2}, {1, 0}};
  const Reals turns[] = {{0, 1, -1}, {1, -1, -1, 1}, {1, -1}};
  for (int h = 0; h < 3; ++h) {
    EXPECT_EQ(four[h].index, h);
    EXPECT_EQ(four[h].complex, h > 0);
    EXPECT_FALSE(four[h].whole);
    EXPECT_EQ(four[h].coefficients, places[h]);
    EXPECT_EQ(four[h].partners, partners[h]);
    EXPECT_EQ(four[h].turns, turns[h]);
  }
  const std::vector<IndexGroup> six = groups_of({6, 2}, 3), none = groups_of({}, 5), whole = groups_of({6, 6}, 3);
  ASSERT_EQ(six.size(), 2u);
  EXPECT_EQ(six[1].index, 2);
  EXPECT_EQ(six[1].coefficients, (Ints{1, 2}));
  for (const auto &[groups, width] : {std::pair{&none, 5}, {&whole, 3}}) {
    ASSERT_EQ(groups->size(), 1u);
    EXPECT_TRUE((*groups)[0].whole && !(*groups)[0].complex);
    EXPECT_EQ((*groups)[0].columns(), width);
  }
}

TEST(IndexGroups, apply_complex_shapes_and_their_adjoints) { // (R + i I)(c - i s) and (R - i I)(c - i s)
  const double R = 3, I = 5, row[] = {0, 7, 11, 0, 0, 2, 13};
  const IndexGroup group = groups_of({4, 1}, 7)[1]; // harmonics 1 and, turning the other way, 3
  for (const int column : {0, 2}) {
    const double sign = column == 0 ? 1 : -1, c = row[group.coefficients[column]],
                 s = row[group.coefficients[column + 1]];
    EXPECT_EQ(R * group.real(column, row) + I * group.imaginary(column, row), R * c + sign * I * s);
    EXPECT_EQ(R * group.real(column + 1, row) + I * group.imaginary(column + 1, row), R * s - sign * I * c);
    EXPECT_EQ(group.joined(column, R * c, I * s), R * c - sign * I * s);
    EXPECT_EQ(group.joined(column + 1, R * s, I * c), R * s + sign * I * c);
  }
}

TEST(Gathering, brings_every_kind_in_the_order_of_the_results) {
  const ReducedModel model = small_reduced(PETSC_COMM_WORLD);
  const Layout layout(model, 1);
  const int width = layout.width;
  const auto vector_of = [&](bool with_last) {
    UniqueVec y;
    double *values;
    const PetscInt own = with_last ? layout.own_unknowns() : layout.own_coefficients();
    check(VecCreateMPI(layout.comm, own, PETSC_DETERMINE, y.out()), "");
    check(VecGetArray(y, &values), "");
    for (PetscInt d = 0; d < layout.own_dofs(); ++d)
      for (int i = 0; i < width; ++i) values[d * width + i] = 100.0 * layout.number(d) + i;
    if (with_last && layout.owns_omega()) values[layout.own_coefficients()] = -7;
    check(VecRestoreArray(y, &values), "");
    return y;
  };
  Gathering all(layout);
  const UniqueVec with = vector_of(true), without = vector_of(false);
  Reals numbers, of_points;
  for (PetscInt d = 0; d < layout.own_dofs(); ++d) numbers.push_back(layout.number(d));
  for (PetscInt p = layout.own_points.begin; p < layout.own_points.end; ++p)
    for (int i = 0; i < 2; ++i) of_points.push_back(10.0 * p + i);
  all.add(with), all.add_dofs(numbers), all.add_points(of_points, 2), all.add(without), all.bring();
  Reals coefficients, dofs;
  for (int d = 0; d < 11; ++d) {
    dofs.push_back(d);
    for (int i = 0; i < width; ++i) coefficients.push_back(100.0 * d + i);
  }
  Reals and_last = coefficients;
  and_last.push_back(-7);
  const bool first = layout.rank == 0;
  EXPECT_EQ(all.take(0), first ? and_last : Reals());
  EXPECT_EQ(all.take(1), first ? dofs : Reals());
  EXPECT_EQ(all.take(2), first ? (Reals{0, 1, 10, 11, 20, 21}) : Reals());
  EXPECT_EQ(all.take(3), first ? coefficients : Reals());
}

TEST(RoughFactors, solve_both_ways_and_know_the_sign) {
  std::vector<float> A = {0, 2, 1, 3, 1, 0, 1, 1, 5}; // by columns; the determinant is -28
  RoughFactors factors;
  EXPECT_EQ(factors.size(), 0);
  EXPECT_EQ(factors.sign(), 0);
  ASSERT_TRUE(factors.factor(A));
  EXPECT_EQ(factors.size(), 3);
  EXPECT_EQ(factors.sign(), -1);
  float x[] = {9, 7, 16}, t[] = {7, 5, 18};
  factors.solve(x), factors.solve(t, true);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(x[i], i + 1, 1e-5);
    EXPECT_NEAR(t[i], i + 1, 1e-5);
  }
  std::swap_ranges(A.begin(), A.begin() + 3, A.begin() + 3);
  EXPECT_TRUE(factors.factor(A));
  EXPECT_EQ(factors.sign(), 1);
  EXPECT_FALSE(factors.factor(std::vector<float>(4, 1.0f)));
  EXPECT_EQ(factors.sign(), 0);
  EXPECT_FALSE(factors.factor({NAN}));
  EXPECT_TRUE(factors.factor({-2}));
  EXPECT_EQ(factors.sign(), -1);
  EXPECT_TRUE(factors.factor({})); // of nothing it is 1
  EXPECT_EQ(factors.sign(), 1);
}

TEST(SectorFrequencies, of_held_contacts_are_those_of_the_modes) {
  ReducedModel model = small_reduced(PETSC_COMM_WORLD);
  model.indices.resize(2);
  model.indices[0].kaa = {9, 16}, model.indices[1].kaa = {25};
  EXPECT_EQ(held_frequencies(model), (SectorFrequencies{{1, 2}, {3, 4}, {5}}));
}

// Every dof moves by itself, on springs of its own and, but for an open point, of its contact.
TEST(SectorFrequencies, of_stuck_contacts_are_those_of_each_nodal_diameter) {
  PreloadedModel model = small_preloaded(PETSC_COMM_WORLD);
  ReducedModel &reduced = model.reduced;
  reduced.sectors = 4, reduced.indices.resize(2);
  reduced.kaa = {10, 40}, reduced.indices[0].kaa = {11, 41}, reduced.indices[1].kaa = {12, 42};
  const auto ground = [](int i, int h) { return 1 + 0.1 * i + h; };
  const auto fill = [&](auto &of, int h) {
    const int own = 3 * static_cast<int>(model.contact.size());
    of.kxx.assign(9 * own, 0), of.mxx.assign(9 * own, 0), of.mxa.assign(2 * own, 0);
    for (int d = 0; d < own; ++d) {
      const int i = 3 * reduced.own_points.begin + d;
      of.kxx[9 * d + i] = ground(i, h), of.mxx[9 * d + i] = 2;
    }
  };
  fill(reduced, 0), fill(reduced.indices[0], 1), fill(reduced.indices[1], 2);
  for (std::size_t p = 0; p < model.contact.size(); ++p) {
    model.contact[p].kt = {20, 30}, model.contact[p].kn = 50;
    model.standstill[p].force[2] = reduced.own_points.begin + p == 1 ? 0 : 5;
  }
  SectorFrequencies wanted;
  for (int h = 0; h < 3; ++h) {
    wanted.push_back({std::sqrt(10.0 + h), std::sqrt(40.0 + h)});
    for (int i = 0; i < 9; ++i)
      wanted[h].push_back(std::sqrt((ground(i, h) + (i / 3 == 1 ? 0 : Reals{20, 30, 50}[i % 3])) / 2));
    std::sort(wanted[h].begin(), wanted[h].end());
  }
  for (const PetscInt count : {4, 20}) {
    const SectorFrequencies found = stuck_frequencies(model, count);
    ASSERT_EQ(found.size(), wanted.size());
    for (std::size_t h = 0; h < found.size(); ++h) {
      ASSERT_EQ(found[h].size(), count == 4 ? 4u : 11u);
      for (std::size_t j = 0; j < found[h].size(); ++j) EXPECT_NEAR(found[h][j], wanted[h][j], 1e-12) << h << " " << j;
    }
  }
}

TEST(Resonances, harmonics_that_drive_are_those_of_any_load) {
  EXPECT_EQ(driving_harmonics({{"a", {0.5, 0, 0, 0, 2, 0, 0}, ""}, {"b", {0, 1, 1}, ""}, {"c", {9}, ""}}),
            (Ints{1, 2}));
  EXPECT_TRUE(driving_harmonics({{"a", {}, ""}}).empty());
}

TEST(Resonances, springs_are_those_of_closed_points) {
  PreloadedModel model = small_preloaded(PETSC_COMM_WORLD);
  const Reals stuck = closed_springs(model);
  ASSERT_EQ(stuck.size(), 3 * model.contact.size());
  for (std::size_t p = 0; p < model.contact.size(); ++p) {
    for (int d = 0; d < 3; ++d) EXPECT_EQ(stuck[3 * p + d], d == 2 ? model.contact[p].kn : model.contact[p].kt[d]);
    model.standstill[p].force[2] = 0;
  }
  EXPECT_EQ(closed_springs(model), Reals(stuck.size(), 0.0));
  for (ContactPoint &point : model.contact) point.law = Law::bilateral; // that is never open
  for (std::size_t p = 0; p < model.contact.size(); ++p)
    EXPECT_EQ(closed_springs(model)[3 * p + 2], model.contact[p].kn);
}

TEST(Resonances, rise_with_springs_and_meet_the_sweep) {
  PreloadedModel model = small_preloaded(PETSC_COMM_WORLD);
  Case study;
  study.loads = course({0.2, 1.0, 0.3, 0, 0.1});
  study.omega_from = 2, study.omega_to = 0.9;
  const Resonances found = resonances(model, study);
  ASSERT_TRUE(found.known);
  EXPECT_EQ(found.points, 3);
  EXPECT_EQ(found.may_lift, 3);
  EXPECT_EQ(found.closed, 3);
  EXPECT_TRUE(found.all_stuck.omega.empty()); // no ratios
  double clamping = 0;
  for (const Standstill &at : model.standstill) clamping += at.force[2];
  MPI_Allreduce(MPI_IN_PLACE, &clamping, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  EXPECT_NEAR(found.clamping, clamping, 1e-12 * clamping);
  EXPECT_EQ(found.sliding.force, 0); // nothing is held by the joint alone
  EXPECT_FALSE(found.sliding.without_bound());
  for (std::size_t j = 0; j < found.stuck.omega.size(); ++j) {
    const double omega = found.stuck.omega[j];
    EXPECT_LE(found.open.omega[j], found.slipping.omega[j] * (1 + 1e-12)); // of modes that the springs leave alone
    EXPECT_LE(found.slipping.omega[j], omega * (1 + 1e-12));
    const bool first = omega >= 0.9 && omega <= 2, second = omega >= 1.8 && omega <= 4;
    EXPECT_EQ(found.stuck.in_sweep[j], first ? 1 : second ? 2 : 0) << omega;
    EXPECT_EQ(found.driven[j], (Ints{1, 2}));
  }
  EXPECT_LT(found.open.omega.back(), found.slipping.omega.back());
  EXPECT_LT(found.slipping.omega.back(), found.stuck.omega.back());
  study.omega_to = 100; // beyond all of them
  const Resonances all = resonances(model, study);
  EXPECT_EQ(all.stuck.omega.size(), 11u);
  EXPECT_EQ(all.reach, INFINITY);
  study.omega_to = 0.9;
  study.damping.ratios = {{1, 0.01}};
  for (Standstill &at : model.standstill) at.force[2] = 0;
  const Resonances loose = resonances(model, study);
  EXPECT_EQ(loose.closed, 0);
  EXPECT_EQ(loose.stuck.omega, loose.open.omega);
  ASSERT_EQ(loose.all_stuck.omega.size(), loose.stuck.omega.size());
  for (std::size_t j = 0; j < loose.all_stuck.omega.size(); ++j)
    EXPECT_NEAR(loose.all_stuck.omega[j], found.stuck.omega[j], 1e-9);
}
