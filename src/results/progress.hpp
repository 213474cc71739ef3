#pragma once
// The run as a person sees it: one line per accepted point on a terminal, now and then otherwise; folds and cuts in
// words.
#include <chrono>
#include <string>

#include "results/results_file.hpp"

namespace dovetail {

class Progress {
public:
  /// `speaks`: rank 0 only. `units`: shown behind the amplitude.
  Progress(bool speaks, const Layout &layout, std::string length_unit);

  void heading() const;
  void point(const PointRecord &record);
  void event(const BranchEvent &event, double frequency_scale);

private:
  double elapsed() const;
  bool speaks_, terminal_;
  PetscInt modes_;
  int width_;
  std::string length_unit_;
  std::chrono::steady_clock::time_point begin_, last_line_;
  int points_ = 0;
};

} // namespace dovetail
