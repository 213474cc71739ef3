#pragma once
// What is wanted later of the motion of a sector, by modes and contact points of an index, from the real rows by
// interior modes and dofs b.
#include "reduction/reduced_model.hpp"
#include "reduction/sector_coordinates.hpp"
#include "support/dense.hpp"

namespace dovetail {

class SectorMotion {
public:
  using Rows = std::vector<std::complex<double>>; // own ones, row-major

  /// phi (rows, modes) and psi (rows, n_b) of `before` are taken. `E`: of any index.
  SectorMotion(const SectorCoordinates &E, PetscInt modes, Recovery &before);

  /// With x held: columns of b (n_b, n) and of interior modes (N_m, n), or none of these.
  Rows of(const ComplexDense &by_b, const ComplexDense *by_modes = nullptr) const;
  /// By x: b (n_b, 3 N_x) where entries of b that are x itself count as 1.
  Rows of_contacts(const ComplexDense &by_x) const;

private:
  std::vector<int> rest_, same_, contact_; // entries of b that are not x itself; those that are, and which
  Dense by_rest_, by_same_, by_modes_;     // a column for each row of the motion
};

} // namespace dovetail
