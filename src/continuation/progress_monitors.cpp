#include "continuation/progress_monitors.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dovetail {
namespace {

constexpr double least_ahead = 0.01;  // of the range, for a curve that goes on
constexpr int many_folds = 12;        // turning points and kinks
constexpr double crowded_part = 0.03; // of the range, that they lie in; as far on, a curve is no longer the one left
constexpr double nothing = 1e-6;      // part of a step
constexpr int enough_still = 3;       // steps along which nothing but mean positions changes

} // namespace

void FoldClusterMonitor::folded(double parameter) {
  folds_.push_back(parameter);
  if (folds_.size() < many_folds) return;
  const auto [low, high] = std::minmax_element(folds_.end() - many_folds, folds_.end());
  crowded_ |= *high - *low < crowded_part * unit_;
}

double FoldClusterMonitor::beyond(double here, int sense) {
  const std::vector<double> folds = std::exchange(folds_, {});
  double farthest = sense * here;
  for (std::size_t i = 0; i < folds.size() && i < many_folds; ++i)
    farthest = std::max(farthest, sense * folds[folds.size() - 1 - i]);
  crowded_ = false;
  return sense * (farthest + least_ahead * unit_);
}

void FoldClusterMonitor::archive(Archive &archive) {
  archive.field("folds", folds_);
  archive.field("crowded", crowded_);
}

void NoProgressMonitor::begin(double parameter, long newton, int sense) {
  ahead_ = {parameter, newton};
  sense_ = sense;
}

void NoProgressMonitor::stepped(double parameter, long newton) {
  if (left_ > 0 && beyond(parameter, left_at_) > crowded_part * unit_) left_ = 0;
  if (beyond(parameter, ahead_.parameter) > least_ahead * unit_) ahead_ = {parameter, newton};
}

bool NoProgressMonitor::winds(double farthest, long newton, double patience) const {
  const double wound = static_cast<double>(newton - ahead_.newton), least = patience / (1 + left_);
  return wound > least &&
         (stayed_ == 0 || beyond(farthest, stayed_at_) > least_ahead * unit_ || wound > least * (1 + stayed_));
}

void NoProgressMonitor::left(double parameter) {
  ++left_, left_at_ = parameter;
  stayed_ = 0;
}

void NoProgressMonitor::stayed(double parameter) { stayed_at_ = parameter, ++stayed_; }

void NoProgressMonitor::archive(Archive &archive) {
  archive.field("parameter", ahead_.parameter);
  archive.field("newton", ahead_.newton);
  archive.field("sense", sense_);
  archive.field("times_left", left_);
  archive.field("left_at", left_at_);
  archive.field("times_stayed", stayed_);
  archive.field("stayed_at", stayed_at_);
}

void DriftMonitor::stepped(double swing, double way) { still_ = swing < nothing * way ? still_ + 1 : 0; }

bool DriftMonitor::drifts() const { return still_ == enough_still; }

} // namespace dovetail
