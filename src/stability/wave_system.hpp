#pragma once
// Hill's problem of a distributed model: lambda^2 M p + lambda (C + 2 Omega M d/dtheta) p + J p = 0, rows dealt out to
// ranks as in the harmonic system, and its eigenvalues near zero by SLEPc. See hill.hpp for what they are.
#include <complex>
#include <optional>

#include "harmonic/harmonic_system.hpp"
#include "stability/slider_memory.hpp"
#include "support/error.hpp"

namespace dovetail {

class WaveSystem {
public:
  /// `blocks`: of the own contact points one after the other, as write_waves gives them, for a lag of exponent_shift
  /// if sliders are to remember `holds`. Collective.
  WaveSystem(const HarmonicSystem &system, Waves waves, double omega, const std::vector<double> &blocks,
             const std::vector<ContactHistory::Hold> &holds);

  struct Exponents {
    bool found = false;                       ///< false: singular, or not all of them converged
    std::vector<std::complex<double>> values; ///< over Omega, |Im| <= strip
  };
  /// All with |lambda| < (strip + 0.15) Omega. Collective.
  Exponents near_zero(double strip = 0.25);

private:
  void assemble(const std::vector<double> &blocks); // Q = J + lambda D + lambda^2 M at the shift
  static PetscErrorCode apply_inverse(Mat shell, Vec x, Vec y);
  void apply(const double *x, double *y);

  const HarmonicSystem &system_;
  Waves waves_;
  int width_; // coefficients of a dof
  double omega_;
  PetscInt own_;
  SliderMemory memory_;
  UniqueMat stiffness_, mass_, stiffness_kron_, mass_kron_; // (dofs, dofs), and acting on all coefficients at once
  UniqueMat shifted_, inverse_;
  UniqueVec p_, stiff_, heavy_, right_; // (own)
  UniqueKSP ksp_;
  Courier courier_;
};

} // namespace dovetail
