#pragma once
// What the modes that the reduced model leaves out would do to a periodic motion.
#include <vector>

#include "harmonic/harmonic_system.hpp"

namespace dovetail {

/// `residual` becomes what would be added to the residual of y, both of `system`, if the modes left out were in it.
/// Their own motion: root of the sum of squares of its coefficients [1], without means. Collective.
double left_out_forces(HarmonicSystem &system, Vec y, Vec residual);

} // namespace dovetail
