// The first peak of a track, and the whole way along it.
#include "analyses/peak_follower.hpp"

#include <algorithm>
#include <cmath>

#include "analyses/peak_stepper.hpp"
#include "harmonic/dense_model.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "following a peak";
// Of the sweep before the track, whose highest peak is sought again from where it was found: tolerances of Newton's
// method and of places, and how well its points draw the curve.
constexpr double seen = 1e-6, drawn = 1e-2;
constexpr double beyond_end = 1.2; // of the way to the end of the range: farther on nobody wants to know

} // namespace

BranchSummary PeakStepper::run(Vec y, const BranchState *state) {
  summary_.parameter = summary_.farthest = settings_.from;
  if (state)
    restore(*state);
  else if (!find_first(y))
    return summary_;
  while (!ended_ && goes_on()) advance();
  summary_.parameter = summary_.farthest = here_.parameter;
  return summary_;
}

// Between two steps: where does it stand, and may it go on.
bool PeakStepper::goes_on() {
  curve_->recall(curve_->memory()), peak_.begin_solves(peak_.solver_memory());  // so does a restart
  const double left = (settings_.to - here_.parameter) / parameter_of(here_.t); // along the tangent
  if (left > 0) control_.set(std::min(control_.step(), std::max(beyond_end * left, control_.shortest())));
  if (observer_.state) observer_.state(state());
  if (summary_.counts.points >= settings_.max_points)
    end(End::max_points, "stopped at continuation.max_points = " + std::to_string(settings_.max_points));
  else if (observer_.interrupted && observer_.interrupted())
    end(End::interrupted, "interrupted");
  return !ended_;
}

// The highest peak of the sweep, as the first point of the track.
bool PeakStepper::find_first(Vec y) {
  UniqueVec last = peak_.system().unknowns(), highest = peak_.system().unknowns();
  double most = 0;
  int peaks = 0;
  const BranchObserver search{[&](const BranchPoint &point) {
                                if (point.located) pad(point.system.layout(), point.y, peak_.system().layout(), last);
                              },
                              [&](const BranchEvent &event) {
                                if (event.kind != BranchEvent::Kind::peak) return;
                                ++peaks;
                                if (event.amplitude <= most) return;
                                most = event.amplitude;
                                check(VecCopy(last, highest), doing);
                              },
                              {},
                              observer_.interrupted};
  const NewtonSettings newton{std::max(newton_.step_tolerance, seen), std::max(newton_.residual_tolerance, seen),
                              newton_.max_iterations};
  BranchSettings sweep = settings_.search;
  sweep.between = std::max(sweep.between, drawn);
  const BranchSummary swept = follow_branch(system_, newton, sweep, y, search);
  summary_.counts.newton += swept.counts.newton, summary_.counts.linear += swept.counts.linear;
  summary_.counts.inexact += swept.counts.inexact;
  if (swept.end == End::interrupted) {
    end(End::interrupted, "interrupted");
    return false;
  }
  if (peaks == 0) {
    const bool whole = swept.end == End::arrived || swept.end == End::peaks;
    end(End::no_start, "no peak lies within continuation.omega at the first " + name() +
                           (whole ? "" : ", as far as it was swept: " + swept.why));
    return false;
  }
  auto found = search_.near(settings_.from, highest);
  if (!found) {
    end(End::no_start, "of the highest peak within continuation.omega at the first " + name() +
                           " no maximum is found that could be followed");
    return false;
  }
  const std::string which = peaks == 1 ? "the peak" : "the highest of " + std::to_string(peaks) + " peaks";
  notify(BranchEvent::Kind::start, which + " within continuation.omega", found->at);
  begin(std::move(*found));
  return true;
}

BranchSummary follow_peak(HarmonicSystem &system, std::shared_ptr<VariedPreload> preload, const NewtonSettings &newton,
                          const TrackSettings &settings, Vec y, const BranchObserver &observer,
                          const BranchState *state) {
  PeakStepper stepper(system, std::move(preload), newton, settings, observer);
  return stepper.run(y, state);
}

} // namespace dovetail
