#pragma once
// Rules of physics of `dovetail check`: what is allowed, and doubtful. docs/how-to/check-a-case.md has a section on
// each kind of warning.
#include "model/full_model.hpp"
#include "reduction/reduced_model.hpp"
#include "results/summary.hpp"

namespace dovetail {

/// What the case alone shows; `contact`: all points.
std::vector<Warning> doubts_of_case(const Case &study, const std::vector<ContactPoint> &contact, int ranks);

/// What the full model shows. Collective.
std::vector<Warning> doubts_of_model(const FullModel &model, const Case &study,
                                     const std::vector<ContactPoint> &contact);

/// Units that look mixed, by size, density and wave speed of a meshed model. Collective.
std::vector<Warning> doubts_of_units(const FullModel &model);

/// What the reduced model shows beyond its resonances. Collective.
std::vector<Warning> doubts_of_reduced(const ReducedModel &model, const Case &study,
                                       const std::vector<ContactPoint> &contact);

} // namespace dovetail
