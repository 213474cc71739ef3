#pragma once
// A periodic motion as the state that a march begins with.
#include "transient/flow.hpp"

namespace dovetail {

/// At theta = 0 of the motion with these coefficients (n, 2H+1), at the flow's frequency, the sliders where the motion
/// leaves them that begins with them as the preload did.
Flow::State state_of(const Flow &flow, const std::vector<double> &coefficients);

} // namespace dovetail
