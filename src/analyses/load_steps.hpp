#pragma once
// A solution at one value of the parameter, along the solutions under a load that grows from nothing.
#include "analyses/response.hpp"

namespace dovetail {

/// For tries that others wait behind.
constexpr StepEffort hurried{.most = 15, .exact = true, .steady = true};

/// y becomes a solution of that system of the response, at that value of its parameter; false: none was found.
/// Collective.
bool solve_by_load_steps(const Response &response, const HarmonicSystem &system, double value, Vec y);

} // namespace dovetail
