#pragma once
// Solves with the bordered Jacobian [J b; c^T d] in the modes of the stuck structure: with x = Phi y it becomes
// [Phi^T J Phi, Phi^T b; (Phi^T c)^T, d], whose blocks are diagonal but for what the contacts do. GMRES, preconditioned
// by that diagonal, bordered; in single precision, with rounds of refinement in double where more is asked for.
#include <memory>
#include <optional>

#include "harmonic/assembled.hpp"
#include "harmonic/modal_operator.hpp"
#include "support/error.hpp"

namespace dovetail {

class ModalSolver {
public:
  ModalSolver(std::shared_ptr<const StuckBasis> basis, const Layout &layout);
  ModalSolver(const ModalSolver &) = delete; // PETSc knows where it is

  /// `parts.contact` and `linear` must outlive the solves.
  void fill(const JacobianParts &parts, LinearPart &linear);
  /// The bordered Jacobian itself, in the unknowns of the harmonic system and in double precision. Collective.
  void multiply(Vec x, Vec y);
  /// Makes `ksp` solve with it: well enough for Newton's method, or as accurately as its relative tolerance asks for.
  void set_up(KSP ksp, Mat J);
  /// Sign of its determinant, from that of the preconditioner and the negative ones among the eigenvalues that GMRES
  /// met when it solved last. Where that sign is new, or there is none, the assembled matrix is factored; 0 if too
  /// large.
  int determinant_sign();
  int take_iterations() { return std::exchange(iterations_, 0); }

  template <class Work> PetscErrorCode run(Work &&work) { return courier_.run(work); }

private:
  void solve(Vec r, Vec x);
  void solve_roughly(Vec r, double accuracy); // to correction_
  void apply(Vec y, Vec out);                 // the bordered operator in the modes
  void precondition(Vec r, Vec out);          // the inverse of its diagonal, bordered
  void prepare_diagonal();
  int sign_by_krylov() const;
  int sign_by_factors();
  template <class Work> void pairs(Work &&work); // (index of an own pair of coefficients, lambda, d, k)

  std::shared_ptr<const StuckBasis> basis_;
  Layout layout_;
  Range own_;          // modal unknowns
  PetscInt own_modal_; // their coefficients
  ModalOperator operator_;
  bool stale_ = true; // what operator_ took, and what follows from it
  const ContactForces *contact_ = nullptr;
  LinearPart *linear_ = nullptr;
  double omega_ = 0, damping_ = 0, corner_ = 0;       // corner: last entry of the border, on the last rank
  std::vector<double> held_, column_, border_;        // (own contact dofs), (own coefficients) twice
  std::vector<double> b_, c_, inverse_b_, inverse_c_; // (own modal unknowns) Phi^T b, c; with the diagonal's inverse
  double schur_ = 1;
  std::vector<double> moved_border_;          // that c_ belongs to
  std::vector<double> stiff_, heavy_, force_; // (own coefficients)
  UniqueMat matrix_;
  UniqueKSP krylov_;
  UniqueVec right_, answer_;         // modal
  UniqueVec remainder_, correction_; // of the unknowns of the harmonic system
  PetscReal newton_accuracy_;        // and most iterations, unless options say otherwise
  PetscInt most_iterations_;
  KSP outer_ = nullptr;
  struct Twin { // of the Jacobian
    Assembled form;
    UniqueMat matrix;
    UniqueKSP ksp;
  };
  std::unique_ptr<Twin> twin_;
  int sign_ = 0, krylov_count_ = 0; // of the determinant, and of the iterations, the last time
  std::optional<int> first_sign_;   // of the determinant, by the first round of the last solve, where others followed
  int iterations_ = 0;
  Courier courier_;
};

} // namespace dovetail
