#pragma once
// What is told of a curve on its way, what is counted, and how it ended.
#include <string>

#include "analyses/branch.hpp"
#include "continuation/stepper.hpp"

namespace dovetail {

class BranchReport {
public:
  using End = BranchSummary::End;

  explicit BranchReport(const BranchObserver &observer) : observer_(observer) {}

  BranchSummary summary;
  Counts &counts = summary.counts;

  void point(const BranchPoint &point) {
    ++counts.points;
    observer_.point(point);
  }
  void event(BranchEvent::Kind kind, const std::string &text, double parameter, double amplitude = 0) {
    observer_.event({kind, text, parameter, amplitude});
  }
  /// The same, of something located, or missed, that is counted.
  void event(int &count, BranchEvent::Kind kind, const std::string &text, double parameter, double amplitude = 0) {
    ++count;
    event(kind, text, parameter, amplitude);
  }

  /// Whether the user wants to stop; then that is why it ends, if it does.
  bool interrupted() {
    const bool yes = observer_.interrupted && observer_.interrupted();
    if (yes) summary.end = End::interrupted, summary.why = "interrupted";
    return yes;
  }
  Stepper::Outcome end(End how, const std::string &why = "") {
    summary.end = how, summary.why = why;
    ended_ = true;
    return Stepper::Outcome::ended;
  }
  /// Ends it where there are so many points; whether it did.
  bool ends_at(int most_points) {
    if (counts.points < most_points) return false;
    end(End::max_points, "stopped at continuation.max_points = " + std::to_string(most_points));
    return true;
  }
  void set_ended(bool yes) { ended_ = yes; } ///< recovery may find a way on beyond an end
  bool ended() const { return ended_; }

private:
  const BranchObserver &observer_;
  bool ended_ = false;
};

} // namespace dovetail
