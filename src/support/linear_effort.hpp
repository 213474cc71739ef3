#pragma once

namespace dovetail {

/// What linear solves took.
struct LinearEffort {
  int iterations = 0;
  int inexact = 0; ///< solves that left more of the equations than was asked
};

} // namespace dovetail
