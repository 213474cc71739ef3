#pragma once
// Harmonic balance of the scaled reduced model: residual of eqs (11)-(12) and its exact derivative by [X; Omega].
#include <vector>

#include "contact/contact_forces.hpp"
#include "harmonic/layout.hpp"
#include "harmonic/loose_body.hpp"
#include "scaling/scaled_model.hpp"

namespace dovetail {

/// One entry of the scaled reduced matrices, by its row and column among the dofs of the harmonic system.
struct Coupling {
  PetscInt row, column;
  double k, m;
  bool stiff; ///< the pattern of K; M is taken to be everywhere
};

class HarmonicSystem {
public:
  /// `samples`: per period of the contact laws, or `exactly`; `fourier`: f(t) as (2H+1) coefficients. Collective.
  HarmonicSystem(ScaledModel model, int harmonics, int samples, std::vector<double> fourier);

  /// The same equations with other harmonics or samples, and k_n times `stiffness`. Collective.
  HarmonicSystem(const HarmonicSystem &like, int harmonics, int samples, double stiffness = 1);

  /// From here on the last unknown is a factor on the load, at this frequency, in place of Omega.
  void vary_load(double omega) { fixed_omega_ = omega; }

  const Layout &layout() const { return layout_; }
  const Scales &scales() const { return scaled_.scales; }
  int harmonics() const { return harmonics_; }
  int samples() const { return samples_; }
  const ScaledModel &scaled() const { return scaled_; }                 ///< without the matrices
  const std::vector<Coupling> &couplings() const { return couplings_; } ///< the matrices; this rank's share of them
  const std::vector<double> &fourier() const { return fourier_; }       ///< f(t), (2H+1)

  UniqueVec unknowns() const; ///< y = [X; Omega], zero
  UniqueMat matrix() const;   ///< empty Jacobian with the fixed pattern, bordered by Omega's row and column
  double omega(Vec y) const;  ///< last unknown, on every rank. Collective.

  /// f = residual of eq (11); its last entry, Omega's row, is left alone. Collective.
  void residual(Vec y, Vec f);
  /// J = [d residual / d y; border^T], border (unknowns,). Collective.
  void jacobian(Vec y, Vec border, Mat J);

  /// Rigid motions that only the joint holds. While contacts leave one of them adrift, jacobian() holds the points'
  /// means by a part of their springs: Newton then finds the way back to contact, or the mean it started from.
  const LooseBody &loose_body() const { return loose_; }
  bool adrift() const { return adrift_; } ///< so it was when the Jacobian was evaluated last

  /// What the own contact points did over the period at the motion evaluated last, in scaled units.
  const std::vector<Activity> &activity() const { return forces_.activity(); }

private:
  void build();
  void evaluate_contact(const double *q); // unless done at this motion
  void products(const double *q);         // stiffness_force_ = K q, inertia_force_ = M q, harmonic by harmonic
  void hold_adrift(std::size_t first_block);
  double load(PetscInt own_dof) const;
  double shared_omega(const double *own) const;

  ScaledModel scaled_;
  Layout layout_;
  int harmonics_, samples_;
  std::vector<double> fourier_;
  LooseBody loose_;
  bool adrift_ = false;
  double fixed_omega_ = 0; // when the load is varied; else 0
  ContactForces forces_;
  std::vector<double> contact_; // (own points, 3, 2H+1) motion that forces_ was last evaluated at
  std::vector<Coupling> couplings_;
  UniqueMat stiffness_, mass_;                         // (dofs, dofs) AIJ
  UniqueMat stiffness_kron_, mass_kron_;               // the same acting on all 2H+1 coefficients at once
  UniqueVec motion_, stiffness_force_, inertia_force_; // (dofs * width)
  std::vector<double> values_; // Jacobian entries in the order given to the matrix: couplings, contact, border
  std::vector<double> force_;  // (own points, 3, 2H+1)
};

} // namespace dovetail
