// Relative displacements as unknowns of a sector: what they mean, and that every matrix and load goes with them.
#include <gtest/gtest.h>

#include "reduction/sector_change.hpp"
#include "some_sector.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr PetscInt dofs = 52;
using Node = CyclicSector::Node;

// With a node that stands on a face of its own sector, one of whose nodes is held in two directions.
CyclicSector with_a_face_within() {
  CyclicSector sector = sector_of(6);
  CyclicSector::Contact point;
  point.a = {44, 45, 46}, point.axes = about(2, 0.3);
  point.face = {{{47, 48, 49}, 0.25}, {{50, -1, -1}, 0.75}};
  sector.contacts.push_back(point);
  return sector;
}

UniqueVec some_vector(Mat A, int seed) {
  UniqueVec v;
  PetscInt begin, end;
  check(MatCreateVecs(A, v.out(), nullptr), "test");
  check(VecGetOwnershipRange(v, &begin, &end), "test");
  for (PetscInt i = begin; i < end; ++i) check(VecSetValue(v, i, scattered(i, seed), INSERT_VALUES), "test");
  check(VecAssemblyBegin(v), "test"), check(VecAssemblyEnd(v), "test");
  return v;
}

UniqueVec product(Mat A, Vec v) {
  UniqueVec out;
  check(MatCreateVecs(A, nullptr, out.out()), "test");
  check(MatMult(A, v, out), "test");
  return out;
}

double dot(Vec a, Vec b) {
  double sum;
  check(VecDot(a, b, &sum), "test");
  return sum;
}

std::vector<double> on_all(Vec v) {
  UniqueScatter scatter;
  UniqueVec all;
  const double *values;
  check(VecScatterCreateToAll(v, scatter.out(), all.out()), "test");
  check(VecScatterBegin(scatter, v, all, INSERT_VALUES, SCATTER_FORWARD), "test");
  check(VecScatterEnd(scatter, v, all, INSERT_VALUES, SCATTER_FORWARD), "test");
  check(VecGetArrayRead(all, &values), "test");
  const std::vector<double> copy(values, values + dofs);
  check(VecRestoreArrayRead(all, &values), "test");
  return copy;
}

} // namespace

TEST(SectorChange, unknowns_are_displacements_relative_to_what_is_opposite_in_this_sector) {
  const CyclicSector sector = with_a_face_within();
  FullModel model = scattered_model(PETSC_COMM_WORLD, dofs, 1);
  model.cyclic = sector;
  change_within_sector(model, true, {});
  const UniqueVec by = some_vector(model.K, 7), motion = product(model.change, by);
  const std::vector<double> q = on_all(by), u = on_all(motion);
  std::vector<char> same(dofs, 1);
  for (const CyclicSector::Contact &point : sector.contacts) {
    if (point.next) continue;
    const Node &x = point.has_a() ? point.a : point.b;
    for (int j = 0; j < 3; ++j) {
      double relative = 0;
      for (int d = 0; d < 3; ++d) {
        double apart = (point.has_a() ? u[point.a[d]] : 0) - (point.has_b() ? u[point.b[d]] : 0);
        for (const CyclicSector::Weighted &part : point.face)
          if (part.node[d] >= 0) apart -= part.weight * u[part.node[d]];
        relative += point.axes[3 * j + d] * apart;
      }
      EXPECT_NEAR(relative, q[x[j]], 1e-14);
      same[x[j]] = 0;
      if (!point.is_pair()) continue;
      EXPECT_NEAR(u[point.a[j]] + u[point.b[j]], q[point.b[j]], 1e-14);
      same[point.b[j]] = 0;
    }
  }
  for (PetscInt dof = 0; dof < dofs; ++dof)
    if (same[dof]) EXPECT_EQ(u[dof], q[dof]) << dof;
}

TEST(SectorChange, energies_and_work_stay_what_they_were) {
  const FullModel before = scattered_model(PETSC_COMM_WORLD, dofs, 2);
  FullModel model = scattered_model(PETSC_COMM_WORLD, dofs, 2);
  model.cyclic = with_a_face_within();
  change_within_sector(model, true, {});
  const UniqueVec q = some_vector(model.K, 7), other = some_vector(model.K, 8), u = product(model.change, q),
                  other_u = product(model.change, other);
  for (const auto &[now, then] : {std::pair(&model.K, &before.K), {&model.M, &before.M}}) {
    EXPECT_NEAR(dot(other, product(*now, q)), dot(other_u, product(*then, u)), 1e-10);
    PetscBool known, symmetric;
    check(MatIsSymmetricKnown(*now, &known, &symmetric), "test");
    EXPECT_TRUE(known && symmetric);
  }
  for (int j = 0; j < 2; ++j) EXPECT_NEAR(dot(model.forces[j].values, q), dot(before.forces[j].values, u), 1e-12);
  EXPECT_NEAR(dot(model.preload, q), dot(before.preload, u), 1e-12);
}

TEST(SectorChange, points_within_the_sector_then_have_one_node_in_their_own_axes) {
  const CyclicSector sector = with_a_face_within(), now = changed(sector);
  ASSERT_EQ(now.contacts.size(), sector.contacts.size());
  EXPECT_EQ(now.faces.size(), sector.faces.size());
  for (std::size_t i = 0; i < now.contacts.size(); ++i) {
    const CyclicSector::Contact &old = sector.contacts[i], &point = now.contacts[i];
    EXPECT_EQ(point.next, old.next);
    EXPECT_EQ(point.a, old.next || old.has_a() ? old.a : old.b);
    EXPECT_EQ(point.b, old.next ? old.b : (Node{-1, -1, -1}));
    EXPECT_EQ(point.face.size(), old.next ? old.face.size() : 0);
    EXPECT_EQ(point.axes, old.next ? old.axes : (CyclicSector::Matrix{1, 0, 0, 0, 1, 0, 0, 0, 1}));
  }
}

TEST(SectorChange, the_motion_of_all_dofs_or_of_those_wished_for_is_kept) {
  const Range own = own_share(PETSC_COMM_WORLD, dofs);
  for (const std::vector<PetscInt> &wished : {std::vector<PetscInt>{}, {0, 5, 27, 51}}) {
    FullModel model = scattered_model(PETSC_COMM_WORLD, dofs, 1);
    model.cyclic = sector_of(6);
    change_within_sector(model, wished.empty(), wished);
    std::vector<PetscInt> wanted;
    for (PetscInt dof = own.begin; dof < own.end; ++dof)
      if (wished.empty() || std::find(wished.begin(), wished.end(), dof) != wished.end()) wanted.push_back(dof);
    EXPECT_EQ(model.moved, wanted);
    EXPECT_TRUE(model.cyclic.contacts[0].axes == (CyclicSector::Matrix{1, 0, 0, 0, 1, 0, 0, 0, 1}));
  }
}
