#pragma once
// What the diagonal D, the preconditioner of GMRES in the modes of the stuck structure, does not know of the contacts
// (docs/theory/stuck-modes.md): the Jacobian J among few motions B of the whole structure, in single precision,
//     P^-1 = D^-1 + B { (B^T J B)^-1 - (B^T D B)^-1 } B^T.
// B are the lowest modes, to which a harmonic of the excitation comes near, and the shapes of the joint without their
// part in these (joint_shapes.hpp), all with all harmonics. Every rank factors and solves the same.
#include "harmonic/modal_operator.hpp"
#include "harmonic/rough_factors.hpp"

namespace dovetail {

class CoarseSpace {
public:
  /// `bases` must outlive this. Not used where harmonics have bases of their own.
  CoarseSpace(const StuckBases &bases, const Layout &layout);

  bool used() const { return most_ > 0; }
  /// Of the Jacobian that `contacts` has taken. Collective.
  void factor(const ModalOperator &contacts, const DynamicStiffness &structure);
  void forget() { sign_ = 0; }
  PetscInt size() const { return sign_ == 0 ? 0 : count_ * layout_.width; } ///< unknowns; 0: nothing is factored
  /// g (size) = this rank's part of B^T times v (own modal unknowns).
  void to_motions(const double *v, double *g) const;
  /// g = { (B^T J B)^-1 - (B^T D B)^-1 } g.
  void solve(double *g, bool transposed);
  /// v += B g.
  void add(const double *g, double *v) const;
  int sign() const { return sign_ == 0 ? 1 : sign_; } ///< of the determinant of P, but for that of D

private:
  void choose(double omega);
  double damper(const DynamicStiffness &structure, int h, std::size_t at) const {
    return structure.turn(h) * rates_[at] + structure.hysteresis(h) * losses_[at];
  }
  void factor_diagonal(const DynamicStiffness &structure);

  const StuckBasis &basis_;
  Layout layout_;
  Range own_;                                  // modal unknowns
  PetscInt most_;                              // motions at most; 0: the space is not used
  bool given_ = false;                         // that number of modes, by an option
  PetscInt lowest_ = -1, count_ = 0;           // modes among the motions; motions
  std::vector<double> motions_;                // (n, count) by columns
  std::vector<float> at_contacts_;             // (own contact dofs, count) Phi_c B
  std::vector<double> stiff_, heavy_, damped_; // (count, count) B^T Lambda B, B^T B, B^T diag(Phi^T K Phi) B
  std::vector<double> rates_, losses_;         // likewise, of the dampers' diagonal
  RoughFactors jacobian_;                      // unknowns motion by motion
  std::vector<RoughFactors> diagonal_;         // by harmonic: cosines of all motions, then sines
  std::vector<float> rough_, part_;
  int sign_ = 0;
};

} // namespace dovetail
