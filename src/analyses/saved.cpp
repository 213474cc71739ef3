// Where a continuation stands, by the names of its fields, and back.
#include <utility>

#include "analyses/follower.hpp"
#include "support/error.hpp"

namespace dovetail {

// What needs no layout. Saved and restored by the same list.
void Follower::archive(Archive &archive) {
  const double from = settings_.from, to = settings_.to; // the case's, when this is restored; `to` may have moved
  archive.field("from", settings_.from);
  archive.field("direction", direction_);
  if (direction_ * (to - from) < 0) settings_.to = from; // begun at the other end
  archive.field("arclength", arclength_);
  archive.field("amplitude", amplitude_.value);
  archive.field("amplitude_slope", amplitude_.slope);
  archive.field("last_verdict", last_verdict_);
  archive.field("lent_at", lent_at_);
  archive.field("unchanged", unchanged_);
  archive.field("raised_harmonics", raised_.harmonics);
  archive.field("raised_error", raised_.error);
  archive.field("coarse_harmonics", coarse_.harmonics);
  archive.field("coarse_error", coarse_.error);
  archive.field("estimating", estimating_);
  archive.field("integrating", integrating_);
  archive.part("between", [&] { between_.archive(archive); });
  archive.part("stepper", [&] { archive_steps(archive); });
  archive.part("retraced", [&] { retraced_.archive(archive); });
  archive.part("cluster", [&] { cluster_.archive(archive); });
  archive.part("progress", [&] { progress_.archive(archive); });

  double memory = curve_->memory();
  archive.field("solver_memory", memory);
  if (archive.restores()) curve_->recall(memory);
}

// Coefficients of all dofs, then the last unknown.
void Follower::archive_vector(Archive &archive, const char *name, Vec y) const {
  std::vector<double> numbers;
  if (!archive.restores()) {
    numbers = all_coefficients(system_->layout(), y);
    numbers.push_back(system_->parameter_in(y));
  }
  archive.field(name, numbers);
  if (!archive.restores()) return;
  const double last = numbers.back();
  numbers.pop_back();
  set_coefficients(system_->layout(), numbers, y);
  set_parameter(y, last);
}

// Points that are gone back to or guessed by; without what belongs to the solve.
void Follower::archive_points(Archive &archive) {
  const std::pair<const char *, std::optional<CurvePoint> *> points[] = {{"before", &before_},
                                                                         {"farthest", &farthest_}};
  for (const auto &[name, point] : points)
    archive.part(name, [&, place = point] {
      bool known = place->has_value();
      archive.field("known", known);
      if (!known) return;
      if (archive.restores()) *place = curve_->point();
      archive.field("sign", (*place)->sign);
      archive_vector(archive, "y", (*place)->y);
      archive_vector(archive, "t", (*place)->t);
      (*place)->parameter = system_->parameter_in((*place)->y);
    });
}

BranchState Follower::state() {
  BranchState state;
  const Layout &layout = system_->layout();
  state.harmonics = system_->harmonics(), state.samples = system_->samples();
  state.y = all_coefficients(layout, here_.y), state.tangent = all_coefficients(layout, here_.t);
  UniqueVec largest = system_->unknowns(); // in the place of each dof's first coefficient
  double *own;
  check(VecGetArray(largest, &own), "saving a state");
  for (PetscInt d = 0; d < layout.own_dofs(); ++d) own[d * layout.width] = metric().largest_of_dofs()[d];
  check(VecRestoreArray(largest, &own), "saving a state");
  const std::vector<double> all = all_coefficients(layout, largest);
  for (std::size_t i = 0; i < all.size(); i += layout.width) state.largest.push_back(all[i]);
  state.y.push_back(here_.parameter), state.tangent.push_back(system_->parameter_in(here_.t));

  Archive saved;
  archive(saved);
  archive_points(saved);
  saved.note("largest_motion", curve_->norm.largest_motion());
  state.fields = saved.fields();
  state.trail = retraced_.marks();
  state.counts = summary_.counts;
  return state;
}

void Follower::restore(const BranchState &state) {
  summary_.counts = state.counts;
  if (state.harmonics != system_->harmonics() || state.samples != system_->samples()) {
    auto system = std::make_unique<HarmonicSystem>(*system_, state.harmonics, state.samples);
    std::swap(changed_, system);
  }
  if (changed_) take_system(*changed_);
  const std::vector<double> *from[] = {&state.y, &state.tangent};
  const Vec to[] = {here_.y, here_.t};
  for (int i = 0; i < 2; ++i) {
    set_coefficients(system_->layout(), *from[i], to[i]);
    set_parameter(to[i], from[i]->back());
  }
  here_.parameter = state.y.back();
  std::vector<double> largest;
  for (PetscInt d = 0; d < system_->layout().own_dofs(); ++d)
    largest.push_back(state.largest.at(system_->layout().number(d)));

  Archive saved(state.fields);
  double motion = 0;
  saved.field("largest_motion", motion);
  metric().restore(motion, std::move(largest));
  archive(saved);
  archive_points(saved);
  retraced_.restore(state.trail);
  recall_activity();
  verdict_ = judge(here_);
}

} // namespace dovetail
