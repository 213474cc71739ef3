#pragma once
// Where a nonlinear mode begins: a mode of the stuck structure at the preload state, and the amplitude at which the
// first contact point gives way (docs/theory/nonlinear-modes.md).
#include <complex>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "preload/contact_preload.hpp"

namespace dovetail {

/// The first event of a mode of growing amplitude.
struct Onset {
  double amplitude = 0;  ///< modal amplitude alpha; infinite where no contact point ever gives way
  int point = 0;         ///< contact point, from 1
  const char *what = ""; ///< "slips", "lifts off" or "closes"
};

struct StuckMode {
  int number = 0;   ///< from 1
  double omega = 0; ///< [rad/s]
  int twin = 0;     ///< number of another mode of the same frequency, but for rounding errors, or 0
  /// (own) phi, with phi^H M phi = 1; the largest entry is positive. Complex of a cyclic sector alone: the motion is
  /// its real part times cos, less its imaginary one times sin.
  std::vector<std::complex<double>> modal, contact;
  double largest = 0;   ///< entry of a contact dof, in size
  Onset onset;          ///< the first of those beyond amplitude 0
  bool straight = true; ///< below the onset the mode is a straight line: no point is at its bound in the preload
};

/// The mode that the case wants; of a cyclic sector, of the nodal diameter of harmonic 1. `model`: not scaled.
/// Collective. InputError: there is none, or nothing holds it.
StuckMode stuck_mode(const PreloadedModel &model, const Case &study);

} // namespace dovetail
