#pragma once
// One Cholesky factorisation of K_ee by MUMPS, shared by x_e0, Psi and the eigensolver.
#include <string>

#include "support/handle.hpp"

namespace dovetail {

class ClampedSolver {
public:
  /// Factors K_ee. InputError in words if it is not positive definite. Collective.
  explicit ClampedSolver(Mat K_ee, const std::string &model_name);

  void solve(Vec b, Vec x) const;
  void solve(Mat B, Mat X) const; ///< many right-hand sides, dense
  KSP ksp() const { return ksp_; }
  std::string ordering() const;

private:
  UniqueKSP ksp_;
};

} // namespace dovetail
