#pragma once
// The Jacobian among the lowest modes of the stuck structure, factored: the part of the preconditioner of GMRES in
// these modes (docs/points.md) that knows what the contacts do. Where many points slip, it is their smooth motions that
// the diagonal misses. In single precision, on the first rank, which owns these modes.
#include "harmonic/linear_part.hpp"
#include "harmonic/modal_operator.hpp"

namespace dovetail {

class LowestModes {
public:
  /// `basis` must outlive this. `count`: of modes; fewer if the first rank owns fewer.
  LowestModes(const StuckBasis &basis, const Layout &layout, PetscInt count);

  /// Of the Jacobian that `contacts` has taken. Collective.
  void factor(const ModalOperator &contacts, double omega, double damping);
  /// out = inverse times in, of own modal unknowns, the lowest come first; nothing happens on other ranks.
  void solve(const double *in, double *out, bool transposed = false);
  int sign() const { return sign_; } ///< of the determinant; 0: singular, or nothing factored, and nothing solved with

private:
  const StuckBasis &basis_;
  Layout layout_;
  PetscInt count_;
  std::vector<float> factors_, v_;
  std::vector<int> pivots_;
  int sign_ = 0;
};

} // namespace dovetail
