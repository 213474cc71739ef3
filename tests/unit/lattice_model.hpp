#pragma once
// A made-up full model: a bar of masses on a regular grid, joined to their neighbours by springs without symmetry and
// clamped at one end, contact points on the other. Rows in even shares on any number of ranks.
#include <cmath>
#include <vector>

#include "model/full_model.hpp"
#include "support/error.hpp"
#include "support/partition.hpp"

namespace dovetail::testing {

/// (length x width x width) nodes of 3 dofs, the first `points` nodes of the last layer in contact.
inline FullModel lattice_model(MPI_Comm comm, int length, int width, int points) {
  FullModel model;
  model.comm = comm;
  model.file = "lattice";
  const int nodes = length * width * width;
  model.dofs = 3 * nodes;
  const Range own = own_share(comm, model.dofs);
  for (UniqueMat *A : {&model.K, &model.M}) {
    check(MatCreate(comm, A->out()), "lattice");
    check(MatSetSizes(*A, own.size(), own.size(), model.dofs, model.dofs), "lattice");
    check(MatSetType(*A, MATAIJ), "lattice");
    check(MatSetUp(*A), "lattice");
    check(MatSetOption(*A, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE), "lattice");
  }
  const auto add = [&](Mat A, int i, int j, double value) {
    if (i >= own.begin && i < own.end) check(MatSetValue(A, i, j, value, ADD_VALUES), "lattice");
  };
  const auto number = [&](int a, int b, int c) { return (a * width + b) * width + c; };
  const auto spring = [&](int p, int q, double k) { // q < 0: to ground
    for (int d = 0; d < 3; ++d)
      for (int e = 0; e < 3; ++e) {
        const double s = k * (d == e ? 1.0 + 0.3 * d : 0.2), m = d == e ? 1e-3 * (1 + 0.1 * std::sin(p)) : 0.0;
        for (const auto &[i, j, sign] :
             {std::tuple{p, p, 1}, std::tuple{p, q, -1}, std::tuple{q, p, -1}, std::tuple{q, q, 1}})
          if (i >= 0 && j >= 0)
            add(model.K, 3 * i + d, 3 * j + e, sign * s), add(model.M, 3 * i + d, 3 * j + e, i == j ? m : 0.25 * m);
      }
  };
  for (int a = 0; a < length; ++a)
    for (int b = 0; b < width; ++b)
      for (int c = 0; c < width; ++c) {
        const int p = number(a, b, c);
        const double k = 1e3 * (1.5 + std::sin(1 + 2.1 * p));
        spring(p, a == 0 ? -1 : number(a - 1, b, c), k);
        if (b > 0) spring(p, number(a, b - 1, c), 0.7 * k);
        if (c > 0) spring(p, number(a, b, c - 1), 0.9 * k);
      }
  for (Mat A : {Mat(model.K), Mat(model.M)}) {
    check(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY), "lattice");
    check(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY), "lattice");
    check(MatSetOption(A, MAT_SYMMETRIC, PETSC_TRUE), "lattice");
  }
  model.forces.push_back({force_pattern, {}});
  const auto &force = model.forces[0].values;
  check(MatCreateVecs(model.K, model.forces[0].values.out(), model.preload.out()), "lattice");
  for (PetscInt i = own.begin; i < own.end; ++i) {
    check(VecSetValue(force, i, std::sin(0.3 * i), INSERT_VALUES), "lattice");
    check(VecSetValue(model.preload, i, std::cos(0.7 * i), INSERT_VALUES), "lattice");
  }
  for (Vec v : {Vec(force), Vec(model.preload)})
    check(VecAssemblyBegin(v), "lattice"), check(VecAssemblyEnd(v), "lattice");
  for (int p = 0; p < points; ++p) {
    const int first = 3 * (number(length - 1, 0, 0) + p);
    model.contact_dofs.push_back({first + 1, first, first + 2}); // not in the order of the dofs
  }
  return model;
}

} // namespace dovetail::testing
