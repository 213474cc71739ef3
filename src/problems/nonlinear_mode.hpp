#pragma once
// Damped nonlinear modes as a problem to be continued (docs/theory/nonlinear-modes.md): periodic free motions that the
// artificial term -2 zeta Om M q' feeds with what is dissipated, over their amplitude.
#include <utility>
#include <vector>

#include "continuation/problem.hpp"
#include "harmonic/harmonic_system.hpp"

namespace dovetail {

/// A point of a mode, scaled.
struct ModeState {
  double omega = 0;     ///< |lambda|, the undamped frequency
  double ratio = 0;     ///< zeta, of the resonance
  double amplitude = 0; ///< modal amplitude alpha of the first harmonic
};

/// Unknowns [Psi; Om; zeta; lam], lam = log10 alpha: the mean of the motion is Psi_0 itself, its harmonic k is alpha
/// Psi_k, and Psi_1 has length 1 with the mass.
class NonlinearMode : public Problem {
public:
  static constexpr int extra = 3; ///< unknowns besides Psi: Om, zeta, lam
  /// `system`: in either form, whose motions are measured from the preload state. It outlives this.
  explicit NonlinearMode(HarmonicSystem &system);

  const Parameter &parameter() const override { return parameter_; }
  UniqueVec unknowns() const override;
  void residual(Vec y, Vec f) override;
  std::unique_ptr<BorderedJacobian> jacobian() override;
  bool is_drawn_by_cubics() const override { return false; } ///< but over the amplitude, see modes.py

  /// From here on the phase is such that the sine of Psi_1 is orthogonal, with the mass, to its cosine at y; of a
  /// cyclic sector, such that the product with Psi_1 at y, with the mass, is real. Collective.
  void refer_to(Vec y);
  /// The same, of a reference that was had before.
  void refer_to(std::vector<double> reference) { reference_ = std::move(reference); }
  /// Cosine of the angle, with the mass, between Psi_1 at y, of which without sectors the cosine is taken, and the one
  /// referred to. Collective.
  double along_reference(Vec y);

  /// Evaluates products and contact forces of the system at y. Collective.
  ModeState evaluate(Vec y);
  /// The motion of the point evaluated last, as unknowns of the system: [X; Om].
  void motion(Vec x) const;
  /// Its coefficients, (own).
  const std::vector<double> &coefficients() const { return q_; }

  const ModeState &state() const { return state_; } ///< likewise
  DynamicStiffness structure() const {              ///< likewise, with what feeds it
    return DynamicStiffness(system_.scaled().damping, state_.omega, 1, state_.ratio);
  }
  /// See refer_to; (own dofs, 2), cosine and sine, times the mass.
  const std::vector<double> &reference() const { return reference_; }

  const HarmonicSystem &system() const { return system_; }

private:
  double sum(double own) const; // over all ranks

  HarmonicSystem &system_;
  const Layout &layout_;
  Parameter parameter_{"log10 of the modal amplitude", "-"};
  std::vector<double> reference_; // (own dofs, 2) M times the shape referred to, which has length 1 with M
  std::vector<double> q_;         // (own coefficients) motion evaluated last
  ModeState state_;
};

} // namespace dovetail
