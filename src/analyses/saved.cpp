// Where a continuation stands, by the names of its fields, and back.
#include <utility>

#include "analyses/follower.hpp"
#include "support/error.hpp"

namespace dovetail {

// What needs no layout. Saved and restored by the same list.
void Follower::archive(Archive &archive) {
  archive.note("direction", turned_round_ ? -direction_ : direction_); // as it began: see follow_branch
  archive.note("begun_at", begun_at_);
  archive.field("arclength", arclength_);
  archive.field("amplitude", amplitude_.value);
  archive.field("amplitude_slope", amplitude_.slope);
  archive.field("last_verdict", last_verdict_);
  archive.field("both_ends", settings_.both_ends);
  archive.field("turned_round", turned_round_);
  archive.field("in_vain", in_vain_);
  archive.field("end_in_vain", end_in_vain_);
  archive.field("lent_from", lent_from_);
  archive.field("lent_at", lent_at_);
  archive.field("unchanged", unchanged_);
  archive.field("raised_harmonics", raised_.harmonics);
  archive.field("raised_error", raised_.error);
  archive.field("coarse_harmonics", coarse_.harmonics);
  archive.field("coarse_error", coarse_.error);
  archive.field("estimating", estimating_);
  archive.field("integrating", integrating_);
  archive.field("anchor_arc", anchor_arc_);
  archive.field("newer_arc", newer_arc_);
  archive.field("since_anchor", since_anchor_);
  archive.field("repeated_at", repeated_at_);
  archive.field("balanced_at", balanced_at_);
  archive.part("between", [&] { between_.archive(archive); });
  archive.part("stepper", [&] { archive_steps(archive); });
  archive.part("retraced", [&] { retraced_.archive(archive); });
  archive.part("cluster", [&] { cluster_.archive(archive); });
  archive.part("progress", [&] { progress_.archive(archive); });

  double to = settings_.to, memory = curve_->memory();
  archive.field("to", to);
  archive.field("solver_memory", memory);
  if (!archive.restores()) return;
  if (turned_round_) {
    direction_ = -direction_;
    settings_.from = std::exchange(settings_.to, to);
  }
  curve_->recall(memory);
}

// Coefficients of all dofs, then the last unknown.
void Follower::archive_vector(Archive &archive, const char *name, Vec y) const {
  std::vector<double> numbers;
  if (!archive.restores()) {
    numbers = all_coefficients(system_->layout(), y);
    numbers.push_back(system_->omega(y));
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
  const std::pair<const char *, std::optional<CurvePoint> *> points[] = {
      {"before", &before_}, {"farthest", &farthest_}, {"older_anchor", &anchors_[0]}, {"newer_anchor", &anchors_[1]}};
  for (const auto &[name, point] : points)
    archive.part(name, [&, place = point] {
      bool known = place->has_value();
      archive.field("known", known);
      if (!known) return;
      if (archive.restores()) *place = curve_->point();
      archive.field("sign", (*place)->sign);
      archive_vector(archive, "y", (*place)->y);
      archive_vector(archive, "t", (*place)->t);
      (*place)->parameter = system_->omega((*place)->y);
    });
}

BranchState Follower::state() {
  BranchState state;
  const Layout &layout = system_->layout();
  state.harmonics = system_->harmonics(), state.samples = system_->samples();
  state.y = all_coefficients(layout, here_.y), state.tangent = all_coefficients(layout, here_.t);
  state.residual = orbit_ ? here_.newton.residual : 0;
  UniqueVec largest = system_->unknowns(); // in the place of each dof's first coefficient
  double *own;
  check(VecGetArray(largest, &own), "saving a state");
  for (PetscInt d = 0; d < layout.own_dofs(); ++d) own[d * layout.width] = metric().largest_of_dofs()[d];
  check(VecRestoreArray(largest, &own), "saving a state");
  const std::vector<double> all = all_coefficients(layout, largest);
  for (std::size_t i = 0; i < all.size(); i += layout.width) state.largest.push_back(all[i]);
  state.y.push_back(here_.parameter), state.tangent.push_back(system_->omega(here_.t));

  Archive saved;
  archive(saved);
  archive_points(saved);
  saved.note("largest_motion", curve_->norm.largest_motion());
  saved.note("in_time", orbit_ != nullptr);
  if (orbit_) saved.part("orbit", [&] { orbit_->save(saved); });
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
  here_.parameter = state.y.back(), here_.newton.residual = state.residual;
  std::vector<double> largest;
  for (PetscInt d = 0; d < system_->layout().own_dofs(); ++d)
    largest.push_back(state.largest.at(system_->layout().number(d)));

  Archive saved(state.fields);
  double motion = 0;
  bool in_time = false;
  saved.field("largest_motion", motion);
  saved.field("in_time", in_time);
  metric().restore(motion, std::move(largest));
  archive(saved);
  archive_points(saved);
  retraced_.restore(state.trail);
  if (in_time)
    saved.part("orbit", [&] {
      double begun = 0;
      saved.field("begun_at", begun);
      orbit_ = std::make_unique<OrbitCurve>(dense_model(*system_), begun, unit_);
      if (!orbit_->restore(saved)) throw ComputeError("the motion of the run before is not met again");
      show(orbit_->here(), trial_); // for what is missing in its harmonics
      here_.data = trial_.data;
    });
  if (!orbit_) recall_activity();
  verdict_ = judge(here_);
}

} // namespace dovetail
