#pragma once
// Pseudo-arc-length continuation of the periodic response over Omega (theory.md, section 8).
#include <functional>
#include <string>

#include "continuation/corrector.hpp"

namespace dovetail {

/// All frequencies in scaled numbers.
struct BranchSettings {
  double from = 0, to = 0; ///< equal: one point
  double step = 0;         ///< first arc length
  bool adaptive = true;    ///< false: `step` throughout, as the original
  int max_points = 1;
  std::vector<double> at; ///< solved exactly whenever the branch passes them, between from and to
};

struct BranchPoint {
  Vec y;            ///< [X; Omega], scaled; valid during the call only
  double omega;     ///< scaled
  double arclength; ///< along the branch so far, plain norm of the scaled unknowns
  Corrector::Outcome newton;
  const std::vector<Activity> &activity; ///< of the own contact points, scaled; valid during the call only
  double progress;                       ///< 0..1, how far from `from` to `to`
};

/// Something worth a line in words: a fold, a step cut, a leap to a solution that arc length does not lead to, a
/// frequency of `at` without solution.
struct BranchEvent {
  enum class Kind { fold, cut, leap, missed } kind;
  std::string text;
  double omega; ///< scaled
};

struct BranchObserver {
  std::function<void(const BranchPoint &)> point;
  std::function<void(const BranchEvent &)> event;
};

struct BranchSummary {
  enum class End { arrived, max_points, stalled, turned_back, no_start } end = End::arrived;
  int points = 0, cuts = 0, folds = 0, leaps = 0, missed = 0;
  long newton = 0, linear = 0; ///< iterations, those of failed steps included
  double omega = 0;            ///< where it ended, scaled
  std::string why;             ///< when it did not arrive
  bool good() const { return end == End::arrived || end == End::max_points; }
};

/// Follows the branch from the solution near y (whose Omega is set to settings.from) to settings.to. Every accepted
/// point goes to the observer at once. Collective.
BranchSummary follow_branch(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings, Vec y,
                            const BranchObserver &observer);

} // namespace dovetail
