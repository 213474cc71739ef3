#pragma once
// The Jacobian of a nonlinear mode, assembled and factored by MUMPS.
#include <memory>

#include "problems/mode_border.hpp"
#include "problems/wider_matrix.hpp"

namespace dovetail {

class ModeJacobian : public BorderedJacobian {
public:
  /// `system`: of the mode, in the assembled form. Collective.
  ModeJacobian(NonlinearMode &mode, HarmonicSystem &system);

  Mat matrix() const override { return matrix_->get(); }
  void set_up(KSP ksp) override;
  void assemble(Vec y, Vec plane) override;
  int determinant_sign(KSP ksp) override;
  std::string recover(KSP ksp) override;

private:
  NonlinearMode &mode_;
  HarmonicSystem &system_;
  UniqueMat inner_; // with Omega, and the row of the length
  std::unique_ptr<WiderMatrix> matrix_;
  ModeBorder border_;
};

} // namespace dovetail
