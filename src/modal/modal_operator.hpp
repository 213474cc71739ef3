#pragma once
// The derivative of the residual in the modes of the stuck structure (docs/theory/stuck-modes.md),
//     J_k y = [kappa_k lambda - mu_k] y + Phi_c^H { dG - kappa_k K_t } Phi_c y:
// its second part, Phi that of harmonic k. In single precision: what is solved with it is a correction. Modal unknowns
// are dealt out to the ranks in order. Rows of Phi_c whose points stick all through the period could be left out if
// damping were taken to be diagonal in the modes; Newton's method then converges linearly: inputs/two_solids took eight
// times as many points.
#include <vector>

#include "contact/contact_derivative.hpp"
#include "modal/index_groups.hpp"
#include "modal/modal_share.hpp"
#include "modal/slab_products.hpp"
#include "scaling/dynamic_stiffness.hpp"
#include "stuck/stuck_basis.hpp"

namespace dovetail {

class ModalOperator {
public:
  using Real = float;

  /// `bases` must outlive this.
  ModalOperator(const StuckBases &bases, const Layout &layout, const ModalShare &share);

  /// Takes the contact's derivative at its last evaluation. `held`: see JacobianParts.
  void take(const ContactDerivative &contact, const double *held, const DynamicStiffness &structure);

  struct Forces {
    const double *given; ///< (own coefficients) r
    double *modal;       ///< (own modal unknowns) becomes Phi^H r
  };
  /// Of all of them; and `sums` and `rough` become those over all ranks, on all. Collective, one message where every
  /// rank has all modal unknowns.
  void to_modes(const std::vector<Forces> &forces, std::vector<double> &sums, std::vector<Real> &rough);
  /// q (own coefficients) = Phi y, of y (own modal unknowns). Collective.
  void from_modes(const double *y, double *q);
  /// out (own modal unknowns) = Phi_c^H { dG - kappa_k K_t } Phi_c y, and what is not diagonal of dampers. Where each
  /// rank has its share: y's last, which the last rank holds, made known to all, and `sum` made the sum over all ranks,
  /// on the last. Collective.
  void apply(const double *y, double *out, double &last, double &sum);

  /// Of apply() but for the contacts' blocks, as ContactFactors::work.
  double work() const;
  struct Motions { ///< of harmonics that share a basis
    IndexGroup of;
    PetscInt count = 0;
    std::vector<Real> real, imaginary; ///< (own contact dofs, count) Phi_c B; imaginary of complex bases
  };
  /// The part of own points in Phi_c^H { ... } Phi_c among motions, every one with all of its group's coefficients: by
  /// columns; its unknowns group by group, in these coefficient by coefficient, for each of these the motions.
  std::vector<Real> among(const std::vector<Motions> &motions) const;

private:
  struct Block {
    int row, column;
    std::size_t at; // in blocks_
  };
  struct Point {
    bool stuck = false; // as the basis: only the damping differs
    std::vector<Block> blocks;
  };
  struct Sheaf { // the coefficients of harmonics that share a basis
    IndexGroup of;
    const StuckBasis &basis;
    Bundle<Real> all, sum; // (n, or twice that if complex; columns)
    Aligned<Real> few;     // (a few rows, columns)
  };
  void spread(const double *y, double last);
  void move(PetscInt row, PetscInt count, Real *motion);
  void press(PetscInt row, PetscInt count, const Real *force);
  void clear_sum();
  void press_all(const double *r);
  void list_sum(Real *to) const;
  void collect(double *out, double *sum);
  void take_own(const Real *share, double *out) const;
  void contact_forces(PetscInt first, PetscInt count);
  void add_dampers(const Slab<float> &rows, double (DynamicStiffness::*factor)(int) const, double *out);

  const StuckBasis &basis_; // of the mean
  Layout layout_;
  bool everywhere_;
  Range own_;
  int padded_;
  std::vector<Sheaf> sheaves_;
  std::vector<int> counts_, starts_; // of the ranks' modal unknowns, padded; the last one has one more
  std::vector<Point> points_;
  std::vector<Real> cross_;         // Im kappa_k per coefficient, with the sign that the other of its pair enters with
  Aligned<Real> blocks_;            // (width, padded) each: columns, one after the other
  std::vector<double> written_;     // of one point, as the contact law gives them
  Aligned<Real> all_, sum_, share_; // (n, padded) and one more
  std::vector<Real> message_;
  Aligned<Real> motion_, force_; // (own dofs or a few contact rows, padded)
  Aligned<Real> damped_;         // (own modal unknowns, width), of dampers that are not diagonal
  DynamicStiffness structure_;
};

} // namespace dovetail
