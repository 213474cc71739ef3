#pragma once
// Where along a curve its motions become stable or unstable.
#include <memory>
#include <optional>

#include "analyses/branch_report.hpp"
#include "stability/large_stability.hpp"

namespace dovetail {

class StabilityWatch {
public:
  /// Null: nothing is judged.
  explicit StabilityWatch(HarmonicSystem *system);
  /// From now on for points of that system.
  void match(HarmonicSystem &system);

  bool asked() const { return system_ != nullptr; }
  /// Nothing unless asked for. Collective.
  std::optional<Stability> judge(const CurvePoint &s);

  /// Of the point where the curve stands.
  const Stability *verdict() const { return verdict_ ? &*verdict_ : nullptr; }
  void stand(const std::optional<Stability> &verdict) { verdict_ = verdict; }

  struct Fold {
    double parameter, amplitude;
  };
  void folded(const Fold &fold) { fold_ = fold; } ///< on the way to the next point
  /// Judges the next point. What has changed since the last one that was certain: a turning point between them, where
  /// it may have; else the growth before, if that is certain. Collective.
  struct Change {
    std::optional<Fold> fold;
    std::optional<double> growth_before;
  };
  std::optional<Change> go_to(const CurvePoint &next);
  /// Counts a change, and tells of it.
  void tell(BranchReport &report, double parameter, double amplitude) const;

  void archive(Archive &archive) { archive.field("last_verdict", last_); }

private:
  void begin();

  HarmonicSystem *system_;
  std::unique_ptr<StabilityTest> small_;
  std::unique_ptr<LargeStabilityTest> large_;
  std::optional<Stability> verdict_;
  int last_ = -1;            // the last verdict that was certain: 1 stable, 0 unstable; -1: none yet
  std::optional<Fold> fold_; // the last turning point since then
};

} // namespace dovetail
