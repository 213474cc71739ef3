#pragma once
// How far the watched dof moves within the period, and how that changes along a curve.
#include <vector>

#include "contact/wave_transform.hpp"
#include "continuation/between.hpp"
#include "harmonic/layout.hpp"
#include "support/handle.hpp"

namespace dovetail {

class AmplitudeMeter {
public:
  /// `watched`: a reduced dof, modes first, or -1: the contact dof that moves most (the mode, without contact).
  AmplitudeMeter(const Layout &layout, PetscInt watched);
  /// Largest |q(t) - mean| over the period, scaled, at y and along t. The extreme is that of the trigonometric
  /// polynomial, not of samples. Collective.
  Amplitude operator()(Vec y, Vec t);

private:
  double extreme(const double *coefficients);

  const Layout &layout_;
  PetscInt watched_;
  int harmonics_;
  std::vector<double> values_, slopes_; // on a grid of instants
  WaveTransform grid_;
};

} // namespace dovetail
