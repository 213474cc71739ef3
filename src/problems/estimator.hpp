#pragma once
// How far a point is from the curve that more harmonics and exact contact forces would give: the first step of Newton's
// method there, from the motion padded with zeros. (The size of the harmonics left out of the forces tells nothing;
// what they move does.)
#include <memory>
#include <utility>
#include <vector>

#include "harmonic/harmonic_system.hpp"

namespace dovetail {

/// Distances to the finer curve: of the motion without its means, relative to its own size, and of the frequency,
/// relative to the sweep, as one root of squares. NaN where the linear solver failed.
struct ErrorEstimate {
  double harmonics = 0, sampling = 0; ///< by what is missing; they add up as vectors, so their sum bounds the whole
  double modes = 0;                   ///< by modes that the reduced model leaves out, as far as they are known; not the
                                      ///< Estimator's: see ResponseCurve::left_out
  bool has_modes = false;             ///< that has been estimated
  std::vector<double> content;        ///< size of each harmonic, 0 .. finer H, of the corrected motion; relative

  double balance() const { return harmonics + sampling; } ///< what more harmonics would mend
};

/// Inner product of two motions without their means. Collective.
double swing_product(const Layout &layout, Vec a, Vec b);

class Estimator {
public:
  /// For points of `system`; a residual below `negligible` is none. Collective, like all that follows.
  Estimator(const HarmonicSystem &system, double omega_unit, double negligible);

  /// From now on for points of the same model with other harmonics or samples.
  void match(const HarmonicSystem &system);

  /// Of the linear solver since asked last (linear_part.hpp).
  double take_work() { return std::exchange(work_, 0.0); }
  int take_inexact() { return std::exchange(inexact_, 0); } ///< linear solves, see LinearEffort

  /// At a solution y, with the curve's tangent t there.
  ErrorEstimate operator()(Vec y, Vec t);

private:
  void build(std::unique_ptr<HarmonicSystem> finer);
  double correct();                                 // y_ by the step that residual_ asks for: its length
  void measure_content(ErrorEstimate &found) const; // of y_
  double size(Vec y) const;                         // without means

  double omega_unit_, negligible_;
  const HarmonicSystem *system_;
  std::unique_ptr<HarmonicSystem> finer_;
  UniqueMat jacobian_;
  UniqueKSP ksp_;
  UniqueVec y_, t_, row_, residual_, correction_;
  double motion_ = 0; // size of the motion at hand
  double work_ = 0;   // see take_work()
  int inexact_ = 0;   // see take_inexact()
};

} // namespace dovetail
