#pragma once
// The structure in one harmonic, with all proportional kinds of damping (docs/theory/equations.md, formula (A)):
//     D_k = kappa_k K - mu_k M,    kappa_k = 1 + i (k Om b + eta),    mu_k = k^2 Om^2 - i k Om a + 2 i k zeta Om^2,
// eta but in the mean; zeta feeds a free motion with what is dissipated, and is 0 in a forced one. D_k = P + i Q stands
// for [P Q; -Q P] on cosine and sine.
#include "case/damping.hpp"

namespace dovetail {

class DynamicStiffness {
public:
  /// Damping and frequency scaled. `factor`: on all damping; `ratio`: zeta.
  explicit DynamicStiffness(const Damping &damping = {}, double omega = 0, double factor = 1, double ratio = 0)
      : damping_(damping.times(factor)), omega_(omega), factor_(factor), ratio_(ratio) {}

  /// Its transpose: Q the other way.
  DynamicStiffness transposed() const {
    DynamicStiffness other = *this;
    other.sign_ = -sign_;
    return other;
  }

  const Damping &damping() const { return damping_; }
  double omega() const { return omega_; }
  /// M is in Q.
  bool damps_mass() const { return damping_.mass != 0; }

  double inertia(int k) const { return k * omega_ * k * omega_; }                                       ///< Re mu_k
  double loss(int k) const { return sign_ * (k * omega_ * damping_.stiffness + eta(k)); }               ///< Im kappa_k
  double drag(int k) const { return sign_ * k * omega_ * (damping_.mass - 2 * ratio_ * omega_); }       ///< -Im mu_k
  double in_phase(int k, double stiffness, double mass) const { return stiffness - inertia(k) * mass; } ///< P
  double quadrature(int k, double stiffness, double mass) const { return loss(k) * stiffness + drag(k) * mass; } ///< Q

  // What multiplies other damping matrices, in Q: of a viscous one, and of one that is structural in place of K.
  double turn(int k) const { return sign_ * k * omega_ * factor_; }
  double hysteresis(int k) const { return k > 0 && damping_.of_parts ? sign_ * damping_.structural : 0; }

  // Derivatives by Omega.
  double inertia_slope(int k) const { return 2 * k * k * omega_; }
  double loss_slope(int k) const { return sign_ * k * damping_.stiffness; }
  double drag_slope(int k) const { return sign_ * k * (damping_.mass - 4 * ratio_ * omega_); }
  double turn_slope(int k) const { return sign_ * k * factor_; }
  /// Of drag, by zeta.
  double feeding_slope(int k) const { return -2 * k * omega_ * omega_; }

private:
  double eta(int k) const { return k > 0 && !damping_.of_parts ? damping_.structural : 0; }

  Damping damping_;
  double omega_, factor_, ratio_, sign_ = 1;
};

} // namespace dovetail
