// Where the track of a peak stands, by the names of its fields, and back.
#include "analyses/peak_stepper.hpp"
#include "analyses/saved_points.hpp"
#include "problems/forced_response.hpp"

namespace dovetail {
namespace {

void archive_leg(Archive &archive, const char *name, SavedVectors &vectors, const TrackLeg &leg) {
  archive.part(name, [&] {
    leg.condition->archive(archive);
    vectors.metric(archive, leg.metric());
    archive_memory(archive, *leg.curve);
  });
}

} // namespace

BranchState PeakStepper::state() {
  const HarmonicSystem &system = peak_.system();
  BranchState state;
  state.harmonics = system.harmonics(), state.samples = system.samples();
  state.counts = summary_.counts;
  SavedVectors vectors(system.layout());
  vectors.add(here_.y), vectors.add(here_.t);
  Archive brought, saved;
  archive(brought, vectors);
  vectors.bring();
  state.y = vectors.take(), state.tangent = vectors.take();
  archive_corner(saved);
  archive(saved, vectors);
  state.fields = saved.fields();
  return state;
}

void PeakStepper::restore(const BranchState &state) {
  const Layout &layout = peak_.system().layout();
  summary_.counts = state.counts;
  Archive saved(state.fields);
  SavedVectors vectors(layout);
  archive_corner(saved);
  set_numbers(layout, state.y, here_.y);
  set_numbers(layout, state.tangent, here_.t);
  here_.parameter = parameter_of(here_.y);
  archive(saved, vectors);
}

// Saved and restored by the same list, and first: the leg makes here_ anew.
void PeakStepper::archive_corner(Archive &archive) {
  int point = leg_->point;
  Graze graze;
  graze.direction = leg_->direction;
  archive.field("point", point);
  archive.field("direction", graze.direction);
  if (archive.restores() && point > 0) {
    leg_ = search_.corner(point, graze);
    take_curve(*leg_->curve);
  }
}

// Saved and restored by the same list.
void PeakStepper::archive(Archive &archive, SavedVectors &vectors) {
  archive_leg(archive, "smooth", vectors, *search_.smooth());
  if (leg_->lies_in_corner()) archive_leg(archive, "corner", vectors, *leg_);

  std::vector<double> memory = peak_.solver_memory();
  archive.field("peak_solver_memory", memory);
  if (archive.restores()) peak_.begin_solves(memory);
  archive.field("arclength", arclength_);
  archive.field("leap", leap_);
  archive.part("stepper", [&] { archive_steps(archive); });
  vectors.point(archive, "before", *curve_, before_);
  vectors.ahead(archive, *curve_, ahead_, [&](CurvePoint &s) {
    const UniqueVec r = peak_.system().unknowns();
    leg_->track->take(s.y);
    peak_.system().residual(peak_.y(), r);
    s.data = leg_->track->describe();
  });
}

} // namespace dovetail
