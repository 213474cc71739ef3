#pragma once
// Solves with the bordered Jacobian [J b; c^T d] in the modes of the stuck structure: with x = Phi y it becomes
// [Phi^T J Phi, Phi^T b; (Phi^T c)^T, d], whose blocks are diagonal but for what the contacts do. GMRES, preconditioned
// by that diagonal, bordered; in single precision.
//
// Preconditioned on the right, GMRES judges what is left of the equations themselves. It does so in the norm of energy,
// r^T (K_s + k^2 Om^2 M)^-1 r in harmonic k, which no choice of unknowns changes. In this norm the contacts' part of J
// is bounded by one however stiff their springs are, so that single precision is good for 1e-6.
#include "modal/coarse_space.hpp"
#include "modal/linear_part.hpp"
#include "modal/modal_operator.hpp"
#include "support/error.hpp"

namespace dovetail {

/// Sign of the determinant of what GMRES inverts, preconditioned, from the negative ones among the eigenvalues that it
/// met when it solved last; 0 if it may have met too few.
int sign_of_met(KSP ksp);

class ModalKrylov {
public:
  /// `bases` must outlive this.
  ModalKrylov(const StuckBases &bases, const Layout &layout);
  ModalKrylov(const ModalKrylov &) = delete; // PETSc knows where it is

  void begin(bool for_one); ///< of another Newton solve, or of one Jacobian, of which nothing is factored
  /// `r`: the right-hand side that is solved for first. Collective.
  void take(const JacobianParts &parts, Vec r);
  /// x = inverse times r, unknowns of the harmonic system, to a relative `accuracy` no better than `best_accuracy`.
  /// False: not within `most` iterations, or the fewer that PETSc's options allow. Collective.
  bool solve(Vec r, Vec x, double accuracy, int most);
  /// A bound, relative to r in the norm of energy, for what the last solve left: GMRES's own number, and the rounding
  /// of products in single precision.
  double left() const { return left_; }
  int iterations() const { return count_; }                 ///< of the last solve
  int sign() const;                                         ///< of the determinant, by the last solve; 0: unknown
  double usual_accuracy() const { return usual_accuracy_; } ///< for Newton's method
  bool corrected() const { return coarse_.used(); }         ///< is the preconditioner, among few motions
  double work() const; ///< of an iteration but for the contacts' blocks, as ContactFactors::work

  static constexpr double best_accuracy = 1e-6;
  static constexpr int most_iterations = 300;
  template <class Work> PetscErrorCode run(Work &&work) { return courier_.run(work); }

private:
  void prepare_border(const JacobianParts &parts, Vec r, std::vector<float> &matrix);
  void prepare_inverse();
  void prepare_weights();
  void apply(Vec y, Vec out);                    // the bordered operator
  void precondition(Vec r, Vec out);             // the inverse of its diagonal, corrected among few motions, bordered
  template <class Work> void pairs(Work &&work); // (index of an own pair of coefficients, lambda, d, k)
  void weigh(double *r) const;                   // from forces to their norm of energy
  void bound_left();

  const StuckBases &bases_;
  Layout layout_;
  ModalShare share_;
  Range own_;          // modal unknowns
  PetscInt own_modal_; // their coefficients
  ModalOperator operator_;
  CoarseSpace coarse_;
  bool coarse_due_ = true; // it is to be factored of the next Jacobian, for a whole Newton solve
  DynamicStiffness structure_;
  double corner_ = 0;                                 // last entry of the border, where that is held
  std::vector<double> b_, c_, inverse_b_, inverse_c_; // (own modal unknowns) Phi^T b, c; with the diagonal's inverse
  std::vector<double> among_;                         // the coarse space's unknowns, and one more
  double schur_ = 1;
  std::vector<double> roots_, weights_; // (own modal unknowns, and the last one's) of the energy; 1 / that
  double column_energy_ = 0;            // norm of b_
  std::vector<double> moved_border_;    // that c_ belongs to
  UniqueMat matrix_;
  UniqueKSP ksp_;
  UniqueVec right_, answer_; // modal; right_ weighed
  Vec taken_ = nullptr;      // whose modal form right_ is, not yet weighed
  std::vector<double> forces_;
  PetscReal usual_accuracy_; // and most iterations, unless options say otherwise
  PetscInt most_;
  int count_ = 0;
  double left_ = 0;
  Courier courier_;
};

} // namespace dovetail
