#pragma once
// The Jacobian of a nonlinear mode, assembled and factored by MUMPS.
#include "harmonic/dampers.hpp"
#include "problems/mode_border.hpp"

namespace dovetail {

class ModeJacobian : public BorderedJacobian {
public:
  /// `system`: of the mode, in the assembled form.
  ModeJacobian(NonlinearMode &mode, HarmonicSystem &system);

  Mat matrix() const override { return matrix_; }
  void set_up(KSP ksp) override;
  void assemble(Vec y, Vec plane) override;
  int determinant_sign(KSP ksp) override;
  std::string recover(KSP ksp) override;

private:
  NonlinearMode &mode_;
  HarmonicSystem &system_;
  const Layout &layout_;
  std::vector<Coupling> couplings_;
  std::vector<Dampers::Entry> damper_entries_;
  UniqueMat matrix_;
  std::vector<double> values_; // in the order given to the matrix
  ModeBorder border_;
};

} // namespace dovetail
