// Where the curve stands, by the names of its fields, and back.
#include <utility>

#include "analyses/response_stepper.hpp"
#include "analyses/saved_points.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

// One number of each dof, on every rank.
std::vector<double> of_all_dofs(const HarmonicSystem &system, const std::vector<double> &of_own) {
  const Layout &layout = system.layout();
  const UniqueVec y = system.unknowns(); // in the place of each dof's first coefficient
  double *own;
  check(VecGetArray(y, &own), "saving a state");
  for (PetscInt d = 0; d < layout.own_dofs(); ++d) own[d * layout.width] = of_own[d];
  check(VecRestoreArray(y, &own), "saving a state");
  const std::vector<double> all = all_coefficients(layout, y);
  std::vector<double> out;
  for (std::size_t i = 0; i < all.size(); i += layout.width) out.push_back(all[i]);
  return out;
}

} // namespace

// What needs no layout. Saved and restored by the same list.
void ResponseStepper::archive(Archive &archive) {
  range.archive(archive);
  archive.field("arclength", arclength_);
  amplitude_.archive(archive);
  stability_.archive(archive);
  harmonics_.archive(archive);
  errors.archive(archive);
  archive.part("stepper", [&] { archive_steps(archive); });
  progress.archive(archive);

  double memory = curve_->memory();
  archive.field("solver_memory", memory);
  if (archive.restores()) curve_->recall(memory);
}

// Points that are gone back to or guessed by, without what belongs to the solve; and those that are to be given.
void ResponseStepper::archive_points(Archive &archive) {
  archive_point(archive, "before", response.layout(), *curve_, before_);
  archive_point(archive, "farthest", response.layout(), *curve_, farthest.point);
  archive_ahead(archive, response.layout(), *curve_, ahead_, [&](CurvePoint &point) { describe(point); });
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
  state.y = numbers_of(system.layout(), here_.y), state.tangent = numbers_of(system.layout(), here_.t);
  state.y.back() = here_.parameter;
  state.largest = of_all_dofs(system, response.metric().largest_of_dofs());
  archive(saved);
  archive_points(saved);
  saved.note("largest_motion", curve_->norm.largest_motion());
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
  std::vector<double> largest;
  for (PetscInt d = 0; d < system.layout().own_dofs(); ++d)
    largest.push_back(state.largest.at(system.layout().number(d)));
  double motion = 0;
  saved.field("largest_motion", motion);
  response.metric().restore(motion, std::move(largest));
  archive(saved);
  archive_points(saved);
  progress.retraced.restore(state.trail);
  describe(here_);
  stability_.stand(stability_.judge(here_));
}

} // namespace dovetail
