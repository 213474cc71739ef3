#pragma once
// A made-up cyclic sector with every kind of contact point and of face, and a model of it without structure else.
#include <cmath>

#include "model/full_model.hpp"
#include "support/error.hpp"
#include "support/hash.hpp"
#include "support/partition.hpp"

namespace dovetail::testing {

inline CyclicSector::Matrix about(int axis, double angle) {
  CyclicSector::Matrix R{};
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  R[4 * axis] = 1, R[4 * a] = R[4 * b] = std::cos(angle), R[3 * a + b] = -std::sin(angle), R[3 * b + a] = -R[3 * a + b];
  return R;
}

/// Pairs within the sector and with the next one, nodes on a face, on the ground, and faces of six and of two dofs: of
/// dofs 0 to 43.
inline CyclicSector sector_of(int sectors) {
  CyclicSector sector;
  sector.sectors = sectors, sector.turn = about(2, 2 * M_PI / sectors);
  std::vector<CyclicSector::Contact> &points = sector.contacts;
  points.resize(6);
  for (CyclicSector::Contact &point : points) point.axes = about(0, 0.4);
  points[0].a = {0, 1, 2}, points[0].b = {3, 4, 5};
  points[1].a = {6, 7, 8}, points[1].b = {9, 10, 11}, points[1].next = true;
  points[2].a = {12, 13, 14}, points[2].face = {{{15, 16, 17}, 0.25}, {{18, -1, -1}, 0.75}}, points[2].next = true;
  points[3].a = {21, 22, 23};
  points[4].b = {24, 25, 26}, points[4].axes = about(1, 0.7);
  points[5].a = {41, 42, 43}, points[5].axes = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  sector.faces = {{{27, 28, 29, 30, 31, 32}, {33, 34, 35, 36, 37, 38}, {0, 1, 2, 3, 4, 5}},
                  {{39, 40}, {19, 20}, {0, 1}}};
  return sector;
}

inline double scattered(int i, int j) { // in [-1, 1], no two alike
  return static_cast<double>(mix(1000 * static_cast<std::uint64_t>(i + 1) + j) >> 11) * 0x1p-52 - 1;
}
inline double stiffness_of(int i, int j) {
  return (i == j ? 25.0 + i : 0.0) + 2 * scattered(std::min(i, j), std::max(i, j));
}
inline double mass_of(int i, int j) {
  return (i == j ? 1.0 : 0.0) + 0.06 * scattered(std::min(i, j), 500 + std::max(i, j));
}

/// Every dof coupled with every other. Rows in even shares on any number of ranks.
inline FullModel scattered_model(MPI_Comm comm, PetscInt dofs, int loads) {
  FullModel model;
  model.comm = comm, model.dofs = dofs;
  model.file = "scattered", model.units = "mm-N-s";
  const Range own = own_share(comm, dofs);
  for (UniqueMat *A : {&model.K, &model.M}) {
    check(MatCreateAIJ(comm, own.size(), own.size(), dofs, dofs, dofs, nullptr, dofs, nullptr, A->out()), "test");
    for (PetscInt i = own.begin; i < own.end; ++i)
      for (PetscInt j = 0; j < dofs; ++j)
        check(MatSetValue(*A, i, j, A == &model.K ? stiffness_of(i, j) : mass_of(i, j), INSERT_VALUES), "test");
    check(MatAssemblyBegin(*A, MAT_FINAL_ASSEMBLY), "test");
    check(MatAssemblyEnd(*A, MAT_FINAL_ASSEMBLY), "test");
    check(MatSetOption(*A, MAT_SYMMETRIC, PETSC_TRUE), "test");
  }
  const auto filled = [&](int seed) {
    UniqueVec v;
    check(MatCreateVecs(model.K, v.out(), nullptr), "test");
    for (PetscInt i = own.begin; i < own.end; ++i) check(VecSetValue(v, i, scattered(i, seed), INSERT_VALUES), "test");
    check(VecAssemblyBegin(v), "test"), check(VecAssemblyEnd(v), "test");
    return v;
  };
  model.preload = filled(900);
  for (int j = 0; j < loads; ++j) model.forces.push_back({"load " + std::to_string(j), filled(901 + j)});
  return model;
}

} // namespace dovetail::testing
