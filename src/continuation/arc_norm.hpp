#pragma once
// How arc length is measured. Adaptive runs weigh the motion by the largest met so far and Omega by the sweep, so that
// neither rules; the original's fixed step uses the plain norm of the scaled unknowns.
#include "harmonic/harmonic_system.hpp"

namespace dovetail {

class ArcNorm {
public:
  ArcNorm(const Layout &layout, double omega_unit, bool weighted);

  /// Takes note of the motion's size at an accepted point.
  void see(Vec y);
  /// row = W t, so that row . s is the inner product of t and s.
  void weigh(Vec t, Vec row) const;
  double product(Vec a, Vec b) const;
  double length(Vec t) const;
  /// Plain norm of the motion alone, without Omega.
  double motion(Vec y) const;

  double largest_motion() const { return motion_; } ///< seen so far
  void set_largest_motion(double motion) { motion_ = motion; }

private:
  PetscInt own_coefficients_;
  bool owns_omega_, weighted_;
  double motion_ = 0, omega_; // units of length
  MPI_Comm comm_;
};

} // namespace dovetail
