#pragma once
// Damping ratios of single modes of the stuck structure: viscous damping besides the proportional one,
//     C = V diag(c) V^T,    V = M phi_j,    c_j = 2 zeta_j sqrt(lambda_j),    which is diagonal in these modes.
#include "harmonic/linear_part.hpp"
#include "harmonic/stuck_basis.hpp"

namespace dovetail {

class RatioDamping {
public:
  /// Of the modes of `basis`; `part` knows the mass. Collective.
  RatioDamping(LinearPart &part, const StuckBasis &basis, const std::vector<ModeRatio> &ratios, const Layout &layout);

  /// out = C q, (own coefficients) of any number of harmonics. Collective.
  void multiply(const double *q, int width, double *out) const;

  struct Entry {
    PetscInt row, column; ///< of the harmonic system's dofs
    double value;
  };
  std::vector<Entry> entries() const; ///< C's own rows, whole. Collective.

private:
  MPI_Comm comm_;
  PetscInt first_, own_, all_; // dofs
  std::vector<double> rates_;  // (r) c
  std::vector<double> shapes_; // (own dofs, r) V
};

} // namespace dovetail
