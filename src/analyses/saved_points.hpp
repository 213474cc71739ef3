#pragma once
// Points of a curve as a state file has them: whatever the number of ranks.
#include <functional>
#include <optional>
#include <vector>

#include "continuation/curve.hpp"
#include "harmonic/layout.hpp"
#include "problems/response_metric.hpp"
#include "support/archive.hpp"

namespace dovetail {

/// Coefficients of all dofs, then the unknowns behind them, on every rank. y: of a response, or of a mode. Collective.
std::vector<double> numbers_of(const Layout &layout, Vec y);
/// Back; collective, with the same numbers on every rank.
void set_numbers(const Layout &layout, std::vector<double> numbers, Vec y);

void archive_vector(Archive &archive, const char *name, const Layout &layout, Vec y);
/// The largest motions met so far, of the whole and of each dof.
void archive_metric(Archive &archive, const Layout &layout, ResponseMetric &metric);
/// What a curve's solver has learned.
void archive_memory(Archive &archive, Curve &curve);
/// A point, if it is known, without what belongs to its solve.
void archive_point(Archive &archive, const char *name, const Layout &layout, const Curve &curve,
                   std::optional<CurvePoint> &point);
/// Ends of steps that are still to be taken. `describe`: what belongs to the solve of one that is restored.
void archive_ahead(Archive &archive, const Layout &layout, const Curve &curve, std::vector<CurvePoint> &ahead,
                   const std::function<void(CurvePoint &)> &describe);

} // namespace dovetail
