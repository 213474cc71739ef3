#pragma once
// Loads that move nothing: a run would step from rounding error to rounding error.
#include "case/case.hpp"
#include "model/full_model.hpp"
#include "reduction/reduced_model.hpp"

namespace dovetail {

/// InputError where the patterns that a case names have no force, or cancel in every harmonic. Collective.
void refuse_idle_loads(const Case &study, const FullModel &model);
void refuse_idle_loads(const Case &study, const ReducedModel &model);

} // namespace dovetail
