#pragma once
// The harmonic system as one sparse matrix, (N_a + 3 N_x)(2H+1) + 1 unknowns, factored by MUMPS: the plain way, which
// the modal form is measured against.
#include "harmonic/dampers.hpp"

namespace dovetail {

class Assembled : public LinearPart {
public:
  /// `couplings`: this rank's. `damps_mass`: see DynamicStiffness. Collective.
  Assembled(std::vector<Coupling> couplings, const Layout &layout, bool damps_mass);

  void take(std::shared_ptr<const Dampers> dampers); ///< Collective.
  std::unique_ptr<LinearPart> like(const Layout &layout) const override;
  void multiply(const double *q, double *stiffness_force, double *inertia_force) override;
  std::vector<Coupling> couplings() const override { return couplings_; }
  void damp_mass() override { damps_mass_ = true; }
  UniqueMat matrix(const ContactForces &contact) const override;
  void fill(Mat J, const JacobianParts &parts) override;
  void set_up(KSP ksp, Mat J) const override;
  std::string recover(KSP ksp, Mat J) const override;
  int determinant_sign(KSP ksp) const override;
  LinearEffort take_effort(Mat, int solves) const override { return {solves, 0}; }

private:
  Layout layout_;
  bool damps_mass_; // the pattern of Q is that of M
  std::vector<Coupling> couplings_;
  std::vector<Dampers::Entry> damper_entries_;
  UniqueMat stiffness_, mass_;                         // (dofs, dofs) AIJ
  UniqueMat stiffness_kron_, mass_kron_;               // the same acting on all 2H+1 coefficients at once
  UniqueVec motion_, stiffness_force_, inertia_force_; // (dofs * width), without storage of their own
  std::vector<double> values_; // Jacobian entries in the order given to the matrix: couplings, contact, border
};

} // namespace dovetail
