// Where a continuation stands, as numbers, and back: what is given here in some order is taken there in the same.
#include <array>
#include <utility>

#include "continuation/follower.hpp"
#include "support/error.hpp"

namespace dovetail {

BranchState Follower::state() {
  BranchState state;
  state.harmonics = system_->harmonics(), state.samples = system_->samples();
  state.y = all_coefficients(system_->layout(), here_.y), state.tangent = all_coefficients(system_->layout(), here_.t);
  state.residual = orbit_ ? here_.newton.residual : 0;
  UniqueVec largest = system_->unknowns(); // in the place of each dof's first coefficient
  double *own;
  check(VecGetArray(largest, &own), "saving a state");
  for (PetscInt d = 0; d < system_->layout().own_dofs(); ++d)
    own[d * system_->layout().width] = curve_->norm.largest_of_dofs()[d];
  check(VecRestoreArray(largest, &own), "saving a state");
  const std::vector<double> all = all_coefficients(system_->layout(), largest);
  for (std::size_t i = 0; i < all.size(); i += system_->layout().width) state.largest.push_back(all[i]);
  state.y.push_back(here_.omega), state.tangent.push_back(system_->omega(here_.t));
  state.numbers = {step_,
                   arclength_,
                   curve_->norm.largest_motion(),
                   double(here_.sign),
                   amplitude_.value,
                   amplitude_.slope,
                   double(last_verdict_),
                   curvature_,
                   double(turned_round_ ? -direction_ : direction_), // as it began
                   begun_at_,
                   crowd_.omega,
                   double(crowd_.newton),
                   ahead_.omega,
                   double(ahead_.newton),
                   double(windings_),
                   left_at_,
                   double(!crowded_.empty()),
                   double(stays_),
                   stayed_at_,
                   double(settings_.both_ends),
                   double(turned_round_),
                   settings_.to,
                   double(in_vain_),
                   double(end_in_vain_),
                   double(corners_in_vain_),
                   double(lent_from_),
                   lent_at_,
                   double(unchanged_),
                   double(raised_.harmonics),
                   raised_.error,
                   double(coarse_.harmonics),
                   coarse_.error,
                   curve_->memory(),
                   estimating_,
                   integrating_};
  for (const double number : between_.save()) state.numbers.push_back(number);
  trail_.save_count(state.numbers);
  state.numbers.push_back(static_cast<double>(bends_.size()));
  state.numbers.insert(state.numbers.end(), bends_.begin(), bends_.end());
  for (const double number :
       {anchor_arc_, newer_arc_, double(since_anchor_), double(repeated_at_), double(careful_), careful_step_})
    state.numbers.push_back(number);
  for (const auto *station :
       {&before_, &farthest_, &anchors_[0], &anchors_[1]}) { // sign, motion and tangent, if there is one
    state.numbers.push_back(*station ? 1 : 0);
    if (!*station) continue;
    state.numbers.push_back((*station)->sign);
    for (const Vec v : {Vec((*station)->y), Vec((*station)->t)}) {
      const std::vector<double> coefficients = all_coefficients(system_->layout(), v);
      state.numbers.insert(state.numbers.end(), coefficients.begin(), coefficients.end());
      state.numbers.push_back(system_->omega(v));
    }
  }
  state.numbers.push_back(balanced_at_);
  state.numbers.push_back(here_.newton.newton);
  const std::vector<double> orbit = orbit_ ? orbit_->save() : std::vector<double>{};
  state.numbers.push_back(static_cast<double>(orbit.size()));
  state.numbers.insert(state.numbers.end(), orbit.begin(), orbit.end());
  state.trail = trail_.marks();
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
    curve_->set_omega(to[i], from[i]->back());
  }
  here_.omega = state.y.back(), here_.newton.residual = state.residual;
  auto next = state.numbers.begin();
  const auto take = [&] { return *next++; };
  const auto take_int = [&] { return static_cast<int>(take()); };
  step_ = take(), arclength_ = take();
  std::vector<double> largest;
  for (PetscInt d = 0; d < system_->layout().own_dofs(); ++d)
    largest.push_back(state.largest.at(system_->layout().number(d)));
  curve_->norm.restore(take(), std::move(largest));
  here_.sign = take_int();
  amplitude_.value = take(), amplitude_.slope = take();
  last_verdict_ = take_int(), curvature_ = take();
  next += 2; // direction and beginning: see follow_branch
  for (Crowd *crowd : {&crowd_, &ahead_}) crowd->omega = take(), crowd->newton = static_cast<long>(take());
  windings_ = take_int(), left_at_ = take();
  if (take() != 0) crowded_ = bends_often;
  stays_ = take_int();
  stayed_at_ = take();
  settings_.both_ends = take() != 0, turned_round_ = take() != 0;
  if (const double end = take(); turned_round_)
    direction_ = -direction_, settings_.from = std::exchange(settings_.to, end);
  in_vain_ = take_int(), end_in_vain_ = take_int(), corners_in_vain_ = take_int();
  lent_from_ = take_int(), lent_at_ = take(), unchanged_ = take_int();
  for (Adapted *adapted : {&raised_, &coarse_}) adapted->harmonics = take_int(), adapted->error = take();
  curve_->recall(take());
  estimating_ = take(), integrating_ = take();
  std::array<double, BetweenPoints::numbers> between;
  for (double &number : between) number = take();
  between_.restore(between);
  const double found = take(), sense = take();
  trail_.restore(state.trail, found, sense, take());
  bends_.resize(static_cast<std::size_t>(take()));
  for (double &bend : bends_) bend = take();
  anchor_arc_ = take(), newer_arc_ = take(), since_anchor_ = take_int(), repeated_at_ = take_int();
  careful_ = take_int(), careful_step_ = take();
  for (auto *station : {&before_, &farthest_, &anchors_[0], &anchors_[1]}) {
    if (take() == 0) continue;
    *station = curve_->station();
    (*station)->sign = take_int();
    for (const Vec v : {Vec((*station)->y), Vec((*station)->t)}) {
      const auto end = next + system_->layout().dofs() * system_->layout().width;
      set_coefficients(system_->layout(), {next, end}, v);
      curve_->set_omega(v, *end);
      next = end + 1;
    }
    (*station)->omega = system_->omega((*station)->y);
  }
  balanced_at_ = take();
  here_.newton.newton = take_int();
  if (const auto size = static_cast<std::ptrdiff_t>(take()); size > 0) {
    orbit_ = std::make_unique<OrbitCurve>(dense_model(*system_), *next, omega_unit_);
    if (!orbit_->restore({next, next + size})) throw ComputeError("the motion of the run before is not met again");
    show(orbit_->here(), trial_); // for what is missing in its harmonics
    here_.motion = trial_.motion, here_.error = trial_.error;
    next += size;
  }
  recall_activity();
  verdict_ = judge(here_);
}

} // namespace dovetail
