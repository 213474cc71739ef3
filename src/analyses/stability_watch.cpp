#include "analyses/stability_watch.hpp"

#include <string>
#include <utility>

namespace dovetail {
namespace {

std::string in_words(Stability::Kind kind) {
  switch (kind) {
  case Stability::Kind::jump:
    return "a multiplier passes +1: the motion jumps";
  case Stability::Kind::period_doubling:
    return "a multiplier passes -1: the period doubles";
  case Stability::Kind::second_frequency:
    return "a pair of multipliers leaves the unit circle: a second frequency appears";
  default:
    return "";
  }
}

} // namespace

StabilityWatch::StabilityWatch(HarmonicSystem *system) : system_(system) {
  if (system_) begin();
}

void StabilityWatch::begin() {
  if (judged_densely(system_->layout().dofs()))
    small_ = std::make_unique<StabilityTest>(dense_model(*system_));
  else
    large_ = std::make_unique<LargeStabilityTest>(*system_);
}

void StabilityWatch::match(HarmonicSystem &system) {
  if (!system_) return;
  system_ = &system;
  if (large_) begin();
}

std::optional<Stability> StabilityWatch::judge(const CurvePoint &s) {
  if (!system_) return std::nullopt;
  system_->set(s.parameter);
  if (large_) return large_->judge(s.y);
  const PathParameter &kind = system_->parameter().kind();
  if (kind.changes_joint || kind.changes_damping) begin(); // of the model there
  return small_->judge(all_coefficients(system_->layout(), s.y), system_->setting().omega);
}

std::optional<StabilityWatch::Change> StabilityWatch::go_to(const CurvePoint &next) {
  using Verdict = Stability::Verdict;
  const auto before = std::exchange(verdict_, judge(next));
  if (verdict_->verdict == Verdict::uncertain) return std::nullopt;
  const int now = verdict_->verdict == Verdict::stable, then = std::exchange(last_, now);
  Change change{std::exchange(fold_, std::nullopt), {}};
  if (then < 0 || then == now) return std::nullopt;
  if (before && before->verdict != Verdict::uncertain) change.growth_before = before->growth;
  return change;
}

void StabilityWatch::tell(BranchReport &report, double parameter, double amplitude) const {
  report.event(report.counts.stability_changes, BranchEvent::Kind::stability,
               last_ == 1 ? "stable from here on" : "unstable from here on: " + in_words(verdict_->kind), parameter,
               amplitude);
}

} // namespace dovetail
