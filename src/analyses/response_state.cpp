// Where the curve stands, by the names of its fields, and back.
#include <algorithm>

#include "analyses/response_stepper.hpp"
#include "analyses/saved_points.hpp"

namespace dovetail {

// What needs no layout. Saved and restored by the same list.
void ResponseStepper::archive(Archive &archive) {
  range.archive(archive);
  archive.field("arclength", arclength_);
  amplitude_.archive(archive);
  archive.field("largest_amplitude", largest_);
  stability_.archive(archive);
  harmonics_.archive(archive);
  errors.archive(archive);
  archive.part("stepper", [&] { archive_steps(archive); });
  progress.archive(archive);
  archive_memory(archive, *curve_);
}

// Points that are gone back to or guessed by, without what belongs to the solve; and those that are to be given.
void ResponseStepper::archive_points(Archive &archive, SavedVectors &vectors) {
  vectors.point(archive, "before", *curve_, before_);
  vectors.point(archive, "farthest", *curve_, farthest.point);
  vectors.ahead(archive, *curve_, ahead_, [&](CurvePoint &point) { describe(point); });
}

// What belongs to a solve.
void ResponseStepper::describe(CurvePoint &point) {
  const UniqueVec r = response.system().unknowns();
  response.system().residual(point.y, r);
  point.data = curve_->problem.describe();
}

void ResponseStepper::save(BranchState &state, Archive &saved) {
  const HarmonicSystem &system = response.system();
  state.harmonics = system.harmonics(), state.samples = system.samples();
  SavedVectors vectors(system.layout());
  vectors.add(here_.y), vectors.add(here_.t);
  Archive brought;
  vectors.metric(brought, response.metric());
  archive_points(brought, vectors);
  vectors.bring();
  if (range.before_start(here_.parameter) <= 0) largest_ = std::max(largest_, amplitude_.here.value);
  state.y = vectors.take(), state.tangent = vectors.take();
  if (!state.y.empty()) state.y.back() = here_.parameter;
  vectors.metric(saved, response.metric());
  archive(saved);
  archive_points(saved, vectors);
  state.trail = progress.retraced.marks();
}

void ResponseStepper::restore(const BranchState &state, Archive &saved) {
  const HarmonicSystem &given = response.system();
  if (state.harmonics != given.harmonics() || state.samples != given.samples())
    adopt(std::make_unique<HarmonicSystem>(given, state.harmonics, state.samples));
  HarmonicSystem &system = response.system();
  set_numbers(system.layout(), state.y, here_.y);
  set_numbers(system.layout(), state.tangent, here_.t);
  here_.parameter = state.y.back();
  SavedVectors vectors(system.layout());
  vectors.metric(saved, response.metric());
  archive(saved);
  archive_points(saved, vectors);
  progress.retraced.restore(state.trail);
  describe(here_);
  stability_.stand(stability_.judge(here_));
  end_beyond_limits();
}

// Limits of before may have been farther.
void ResponseStepper::end_beyond_limits() {
  const std::string peaks = std::to_string(report_.counts.peaks);
  if (limit_ > 0 && largest_ >= limit_)
    report_.end(End::amplitude, "stopped: the amplitude has been beyond continuation.stop_at_amplitude");
  else if (most_peaks_ > 0 && report_.counts.peaks >= most_peaks_)
    report_.end(End::peaks, "stopped: peaks so far, " + peaks + ", are those of continuation.stop_after_peaks");
}

} // namespace dovetail
