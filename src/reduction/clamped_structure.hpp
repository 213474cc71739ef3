#pragma once
// The full model split into elastic and contact dofs, ready to be condensed.
#include <memory>
#include <vector>

#include "model/full_model.hpp"
#include "reduction/clamped_solver.hpp"
#include "reduction/tall.hpp"
#include "support/partition.hpp"

namespace dovetail {

struct Blocks { // of one symmetric matrix; rows ..e with elastic dofs, ..c with contact points, on their owners
  UniqueMat ee, ec, ce, cc;
};

struct MovedRows { // what is wanted later of the motion of a sector whose joints are relative, by unknowns e and c
  std::vector<long> dofs; // own ones, of the model
  UniqueMat e, c;
};

struct ClampedStructure {
  FullModel full; ///< without its matrices and loads, which are in the parts below
  Range own_points;
  PetscInt elastic = 0;           ///< n_e
  Range own;                      ///< this rank's elastic rows
  std::vector<long> elastic_dofs; ///< (own) their numbers in the full model
  Blocks K, M;
  Blocks C, K_structural;                   ///< or none
  MovedRows moved;                          ///< or none
  Tall force_e;                             ///< own parts of the F_j, a column each [N]
  std::vector<std::vector<double>> force_c; ///< likewise, of contact dofs
  std::vector<double> preload_e, preload_c; ///< own parts of P [N]
  std::unique_ptr<ClampedSolver> solver;    ///< K_ee analysed, not factored; none if n_e = 0
};

/// Splits the model, elastic dofs by METIS, contact points in even shares, and analyses K_ee. Collective.
ClampedStructure clamp(FullModel &&full);

} // namespace dovetail
