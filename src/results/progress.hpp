#pragma once
// The run as a person sees it: one line per accepted point on a terminal or in JSON, now and then otherwise;
// folds and cuts in words.
#include <chrono>
#include <string>

#include "results/status_file.hpp"
#include "results/told.hpp"

namespace dovetail {

class Progress {
public:
  /// `speaks`: rank 0 only. `watched`: the unknown whose amplitude is shown, -1 where the case names none, or a node.
  /// `range`: of the curve. `points`: already there, of earlier parts.
  /// `status`: is told as well, and must outlive it.
  Progress(bool speaks, Told told, PetscInt watched, const CurveRange &range, int points, StatusFile &status);

  void heading() const;
  void point(const PointRecord &record);
  void event(const BranchEvent &event, const EventRecord &record);

private:
  void log_point(const PointRecord &record, double seconds_left) const;
  double elapsed() const;
  bool of_mode() const { return range_.parameter == &modal_amplitude(); }
  bool speaks_, terminal_;
  Told told_;
  PetscInt watched_;
  CurveRange range_;
  std::chrono::steady_clock::time_point begin_, last_line_;
  int points_;
  StatusFile &status_;
  double before_ = -1; // progress at the first point seen
};

} // namespace dovetail
