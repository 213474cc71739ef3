#pragma once
// Points of a curve as a state file has them: whatever the number of ranks.
#include <functional>
#include <optional>
#include <vector>

#include "continuation/curve.hpp"
#include "harmonic/gathering.hpp"
#include "problems/response_metric.hpp"
#include "stuck/layout.hpp"
#include "support/archive.hpp"

namespace dovetail {

/// Back from a file: coefficients of all dofs, then the unknowns behind them, the same numbers on every rank. y: of a
/// response, or of a mode. Collective.
void set_numbers(const Layout &layout, std::vector<double> numbers, Vec y);

/// What a curve's solver has learned.
void archive_memory(Archive &archive, Curve &curve);

/// Vectors on their way into a state file, or back. All that are saved come to rank 0 by one message, so they are named
/// twice in one order: to be brought, and to be written. The file has them on rank 0 only.
class SavedVectors {
public:
  explicit SavedVectors(const Layout &layout) : layout_(layout), all_(layout) {}

  /// A field; or, before `bring`, a vector that is to be brought. Reads it back in an archive that restores.
  void field(Archive &archive, const char *name, Vec y);
  /// The largest motions met so far, of the whole and of each dof.
  void metric(Archive &archive, ResponseMetric &metric);
  /// A point, if it is known, without what belongs to its solve.
  void point(Archive &archive, const char *name, const Curve &curve, std::optional<CurvePoint> &point);
  /// Ends of steps that are still to be taken. `describe`: what belongs to the solve of one that is restored.
  void ahead(Archive &archive, const Curve &curve, std::vector<CurvePoint> &points,
             const std::function<void(CurvePoint &)> &describe);

  /// Outside of an archive: brought with the others, and taken in turn with them.
  void add(Vec y);
  std::vector<double> take() { return all_.take(next_++); }

  void bring(); ///< collective

private:
  void known_point(Archive &archive, CurvePoint &point);

  const Layout &layout_;
  Gathering all_;
  std::size_t next_ = 0;
  bool brought_ = false;
};

} // namespace dovetail
