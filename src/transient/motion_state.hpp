#pragma once
#include <vector>

#include "contact/contact_point.hpp"

namespace dovetail {

/// A motion at one instant.
struct MotionState {
  std::vector<double> q, v; ///< (n) from the preload state, and d/dt
  std::vector<Memory> w;    ///< (points) sliders, in total displacements as Standstill::w
};

} // namespace dovetail
