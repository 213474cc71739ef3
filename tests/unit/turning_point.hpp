#pragma once
// Where a curve in time turns.
#include "transient/orbit_curve.hpp"

namespace dovetail::testing {

/// The turning point within the last step, to `tolerance` of arc length, by bisection; none where Newton fails.
inline OrbitCurve::PlacePtr turning_point(OrbitCurve &curve, double tolerance) {
  const bool beyond = curve.here()->rises();
  OrbitCurve::PlacePtr place;
  for (double a = 0, b = curve.way(); b - a > tolerance;) {
    place = curve.between((a + b) / 2);
    if (!place) break;
    (place->rises() == beyond ? b : a) = (a + b) / 2;
  }
  return place;
}

} // namespace dovetail::testing
