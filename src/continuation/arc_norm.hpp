#pragma once
// How arc length is measured. Adaptive runs weigh the motion by the largest met so far and Omega by the sweep, so that
// neither rules: one half of the square is that of the whole motion, the other the mean over the dofs of each one's
// own, so that one dof that moves far does not hide what the others do. The original's fixed step uses the plain norm
// of the scaled unknowns.
#include <vector>

#include "harmonic/harmonic_system.hpp"

namespace dovetail {

class ArcNorm {
public:
  ArcNorm(const Layout &layout, double omega_unit, bool weighted);

  /// Takes note of the motion's size at an accepted point. Collective.
  void see(Vec y);
  /// row = W t, so that row . s is the inner product of t and s.
  void weigh(Vec t, Vec row) const;
  double product(Vec a, Vec b) const;
  double length(Vec t) const;
  /// Its length without the mean values of the motion.
  double swing(Vec t) const;
  /// Plain norm of the motion alone, without Omega.
  double motion(Vec y) const;

  /// What has been seen: the largest motion of the whole, and of each own dof.
  double largest_motion() const { return motion_; }
  const std::vector<double> &largest_of_dofs() const { return dofs_; }
  void restore(double motion, std::vector<double> dofs); ///< Collective.

private:
  void choose_weights();

  MPI_Comm comm_;
  int width_;
  PetscInt own_coefficients_;
  bool owns_omega_, weighted_;
  double omega_;                // unit of frequency
  double motion_ = 0;           // largest seen, plain norm
  std::vector<double> dofs_;    // (own dofs) largest seen of each
  std::vector<double> weights_; // (own dofs) of the squares
};

} // namespace dovetail
