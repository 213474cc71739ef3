#pragma once
// The coordinates of a cyclic sector: dofs b that its real modes hold, and for each index h those of which they are
// made, b = E_h [s; x]: s of contact pairs and of the left face, x the relative displacements of the contact points.
#include <array>
#include <vector>

#include "model/cyclic_sector.hpp"
#include "support/hermitian.hpp"

namespace dovetail {

/// Contact nodes a, b and both faces, then one or two more dofs where these are no multiple of three.
std::vector<std::array<PetscInt, 3>> held_dofs(const CyclicSector &sector, PetscInt dofs);

class SectorCoordinates {
public:
  using Value = std::complex<double>;

  /// Of index h in 0..N/2; `held`: n_b, the number of dofs b in the order of held_dofs.
  SectorCoordinates(const CyclicSector &sector, PetscInt held, int index);

  int own() const { return own_; }         ///< length of s
  int contact() const { return contact_; } ///< length of x, 3 N_x
  int all() const { return own_ + contact_; }
  int held() const { return static_cast<int>(rows_.size()); } ///< n_b
  int contact_at(int i) const;                                ///< which of x dof i of b is, -1 if it is none

  ComplexDense to_held(const ComplexDense &y) const;                  ///< E y; of s alone, x is 0
  ComplexDense own_from_held(const ComplexDense &b) const;            ///< the rows of s of E^H b
  ComplexDense from_held(const double *values, int columns) const;    ///< E^H A of real A (n_b, columns) row-major
  ComplexDense congruent(const std::vector<double> &symmetric) const; ///< E^H A E of real A (n_b, n_b)

private:
  struct Entry {
    int column;
    Value value;
  };
  int own_ = 0, contact_ = 0;
  std::vector<std::vector<Entry>> rows_; // of E
};

} // namespace dovetail
