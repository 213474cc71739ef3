#pragma once
// The run as a person sees it: one line per accepted point on a terminal, now and then otherwise; folds and cuts in
// words.
#include <chrono>
#include <string>

#include "results/point_record.hpp"

namespace dovetail {

class Progress {
public:
  /// `speaks`: rank 0 only. `length_unit`: shown behind the amplitude. `range`: of the curve. `points`: already there,
  /// of earlier parts.
  Progress(bool speaks, const Layout &layout, std::string length_unit, const CurveRange &range, int points);

  void heading() const;
  void point(const PointRecord &record);
  void event(const BranchEvent &event, double scale); ///< of the parameter

private:
  double elapsed() const;
  bool speaks_, terminal_;
  PetscInt modes_;
  std::string length_unit_;
  CurveRange range_;
  std::chrono::steady_clock::time_point begin_, last_line_;
  int points_;
  double before_ = -1; // progress at the first point seen
};

} // namespace dovetail
