#pragma once
// The reduction to modes and constraint modes where the parts are still needed after it.
#include "reduction/clamped_structure.hpp"
#include "reduction/reduced_model.hpp"

namespace dovetail {

/// As craig_bampton() of reduced_model.hpp; `shapes` receives Phi, and `parts` keeps matrices and, unless modes were
/// counted, factors.
Reduction craig_bampton(ClampedStructure &parts, const ReductionSettings &settings, const MemoryPlan &plan,
                        Stages &stages, Tall &shapes);

} // namespace dovetail
