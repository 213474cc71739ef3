#pragma once
// Harmonic balance of the scaled reduced model: residual of eqs (11)-(12) and its exact derivative by [X; Omega].
#include <array>
#include <vector>

#include "harmonic/layout.hpp"
#include "scaling/scaled_model.hpp"

namespace dovetail {

class HarmonicSystem {
public:
  /// `fourier`: f(t) as (2H+1) coefficients. Collective.
  HarmonicSystem(ScaledModel model, int harmonics, int samples, std::vector<double> fourier);

  const Layout &layout() const { return layout_; }
  const Scales &scales() const { return scaled_.scales; }

  UniqueVec unknowns() const; ///< y = [X; Omega], zero
  UniqueMat matrix() const;   ///< empty Jacobian with the fixed pattern, bordered by Omega's row and column
  double omega(Vec y) const;  ///< last unknown, on every rank. Collective.

  /// f = residual of eq (11); its last entry, Omega's row, is left alone. Collective.
  void residual(Vec y, Vec f);
  /// J = [d residual / d y; border^T], border (unknowns,). Collective.
  void jacobian(Vec y, Vec border, Mat J);

  /// Own contact points by what they did over the period at the last residual: stick, slip, open.
  const std::array<long, 3> &states() const { return states_; }

private:
  struct Coupling { // one entry of the reduced matrices
    PetscInt row, column;
    double k, m;
    bool stiff; // the pattern of K; M is taken to be everywhere
  };
  void list_couplings();
  void products(const double *q); // stiffness_force_ = K q, inertia_force_ = M q, harmonic by harmonic
  double shared_omega(const double *own) const;

  ScaledModel scaled_;
  Layout layout_;
  int harmonics_;
  std::vector<double> fourier_;
  SampledLaw law_;
  std::vector<Coupling> couplings_;
  UniqueMat stiffness_, mass_;                         // (dofs, dofs) AIJ
  UniqueMat stiffness_kron_, mass_kron_;               // the same acting on all 2H+1 coefficients at once
  UniqueVec motion_, stiffness_force_, inertia_force_; // (dofs * width)
  std::vector<double> values_; // Jacobian entries in the order given to the matrix: couplings, contact, border
  std::vector<double> force_;  // (3, 2H+1) of one point
  std::array<long, 3> states_{};
};

} // namespace dovetail
