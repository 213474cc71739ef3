#pragma once
// What the run watches: in scaled numbers for the branch, its amplitude for screen and file.
#include <optional>

#include "case/case.hpp"
#include "harmonic/harmonic_system.hpp"
#include "problems/amplitude.hpp"
#include "results/point_record.hpp"

namespace dovetail {

class Watching {
public:
  /// `system` outlives it.
  Watching(const Case &study, const HarmonicSystem &system);

  /// For the branch: in scaled numbers, of which `unit()` is one in the user's.
  Watched scaled() const;
  double unit() const;
  /// An unknown of the kind that is shown; -1: of a contact point, or a node.
  int shown() const;

  /// Sets the amplitude of a point and whose it is. On rank 0.
  void measure(PointRecord &point);
  const Units &units() const { return units_; }

private:
  const Case &study_;
  const HarmonicSystem &system_;
  Units units_;
  PetscInt dof_;                  // of the case; -1: a node, or what moves most
  std::optional<WatchedRow> row_; // of a node, in user units
  std::optional<Swing> swing_;    // for so many harmonics:
  int harmonics_ = 0;
};

} // namespace dovetail
