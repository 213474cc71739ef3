#pragma once
// The Jacobian of a nonlinear mode, assembled, with a border of three: columns Om, zeta, lam; rows of the length and
// the phase of Psi_1, and of the plane that a step ends on.
#include "harmonic/dampers.hpp"
#include "problems/nonlinear_mode.hpp"

namespace dovetail {

class ModeJacobian : public BorderedJacobian {
public:
  static constexpr int border = 3;
  explicit ModeJacobian(NonlinearMode &mode);

  Mat matrix() const override { return matrix_; }
  void set_up(KSP ksp) override;
  void assemble(Vec y, Vec plane) override;
  int determinant_sign(KSP ksp) override;
  std::string recover(KSP ksp) override;

private:
  void differentiate(); // columns_

  NonlinearMode &mode_;
  HarmonicSystem &system_;
  const Layout &layout_;
  std::vector<Coupling> couplings_;
  std::vector<Dampers::Entry> damper_entries_;
  UniqueMat matrix_;
  std::vector<double> values_;                 // in the order given to the matrix
  std::vector<double> columns_[border];        // (own coefficients)
  std::vector<double> swinging_, along_swing_; // motion of the own contact dofs without means, and G' times it
};

} // namespace dovetail
