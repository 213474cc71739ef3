#pragma once
// status.json: how far a run is, for those who look at it from outside. It is there while the run goes on.
#include <chrono>
#include <filesystem>

#include "case/curve_range.hpp"

namespace dovetail {

struct PointRecord;

/// Written at most once a second, beside and then renamed, so that it is always whole. What cannot be written is left
/// out: nobody's results hang on it.
class StatusFile {
public:
  /// An empty folder: none is written, as on ranks other than 0.
  explicit StatusFile(std::filesystem::path folder = {});
  ~StatusFile();
  StatusFile(const StatusFile &) = delete;
  StatusFile &operator=(const StatusFile &) = delete;

  /// A stage of the run, by its name in summary.json.
  void stage(const std::string &name);
  /// `points` so far; `left` [s], negative while it is not known.
  void point(const CurveRange &range, int points, const PointRecord &record, double left);

private:
  using Clock = std::chrono::steady_clock;
  void write(const std::string &state, const std::string &more);

  std::filesystem::path file_;
  Clock::time_point begin_ = Clock::now(), last_;
  bool written_ = false;
};

} // namespace dovetail
