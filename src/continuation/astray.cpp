// A curve that leads nowhere: it comes upon itself, bends again and again, or winds on.
#include <algorithm>
#include <cmath>
#include <utility>

#include "continuation/follower.hpp"

namespace dovetail {

void Follower::drop_anchors() {
  for (auto &anchor : anchors_) anchor.reset();
  since_anchor_ = careful_ = 0;
}

// A curve that runs on from its beginning cannot come upon an older piece of itself, unless a step has led to another
// piece of it, or the wrong way round a corner. That is where it came upon it, or where it was there before. So the
// last points are followed once more, with short steps.
bool Follower::follow_again(const std::string &why) {
  const bool just_done = repeated_at_ > 0 && summary_.counts.points - repeated_at_ < 2 * careful_points;
  if (!settings_.adaptive || settings_.steps_only || !anchors_[0] || just_done ||
      summary_.counts.repeats >= most_repeats)
    return false;
  repeated_at_ = summary_.counts.points;
  here_ = std::move(*anchors_[0]);
  recall_activity();
  const double way = anchor_arc_;
  const int points = anchored + since_anchor_ + 1;
  drop_anchors();
  careful_ = careful_points, careful_step_ = careful_part * way / points;
  ++summary_.counts.repeats;
  notify(BranchEvent::Kind::again, why + ": the last points once more, with short steps", here_.omega);
  begin_amplitude();
  trail_.interrupt();
  still_ = 0;
  check(VecScale(here_.t, 1 / curve_->norm.length(here_.t)), "measuring arc length");
  step_ = careful_step_;
  limit_step();
  return true;
}

// Many bends within a small part of the sweep are no physics, but too few harmonics for contacts that open and close.
// Not in time, where harmonics do not count.
void Follower::note_bend(double omega) {
  if (orbit_) return;
  bends_.push_back(omega);
  if (bends_.size() < many_bends) return;
  const auto [low, high] = std::minmax_element(bends_.end() - many_bends, bends_.end());
  if (*high - *low >= crowded_part * omega_unit_) return;
  crowded_ = bends_often;
}

// Nor are many short steps that come to nothing.
void Follower::note_creeping() {
  if (orbit_) return;
  const long now = summary_.counts.newton;
  const auto near = [&](double omega) { return std::abs(omega - crowd_.omega) <= creeping_part * omega_unit_; };
  if (!near(here_.omega)) crowd_ = {here_.omega, now};
  if (now - crowd_.newton <= most_creeping || std::count_if(bends_.begin(), bends_.end(), near) < few_bends) return;
  crowded_ = "the curve bends again and again and makes no way";
  crowd_.newton = now;
}

// A curve that winds on between frequencies it has met, for as many iterations as a whole sweep may take, and as some
// seconds hold if it is small, is left: the frequencies ahead are what was asked for. The more often, the sooner.
bool Follower::winds() {
  const long now = summary_.counts.newton;
  const auto beyond = [&](double omega) { return direction_ * (here_.omega - omega); };
  if (windings_ > 0 && beyond(left_at_) > enough_ahead * omega_unit_) windings_ = 0;
  if (beyond(ahead_.omega) > least_ahead * omega_unit_) ahead_ = {here_.omega, now};
  const double unknowns = static_cast<double>(system_->layout().dofs() * system_->layout().width);
  const double least = dear() && !orbit_ ? dear_patience : least_patience;
  const double patience = std::max(least, most_wound / unknowns) / (1 << std::min(windings_, most_halved));
  return settings_.adaptive && !settings_.steps_only && static_cast<double>(now - ahead_.newton) > patience &&
         farthest_ && (orbit_ || beyond(farthest_->omega) < 0) &&
         (stays_ == 0 || direction_ * (farthest_->omega - stayed_at_) > least_ahead * omega_unit_ ||
          static_cast<double>(now - ahead_.newton) > patience * (1 + stays_));
}

// Steps converge and lead nowhere: harmonics that the contacts want and do not have, unless that was tried, or else on
// beyond the crowd.
void Follower::pass_crowd() {
  refusal_ = std::exchange(crowded_, "");
  const std::vector<double> bends = std::exchange(bends_, {});
  if (settings_.steps_only || (summary_.counts.harmonics == 0 && more_harmonics())) return;
  double farthest = direction_ * here_.omega;
  for (std::size_t i = 0; i < bends.size() && i < many_bends; ++i)
    farthest = std::max(farthest, direction_ * bends[bends.size() - 1 - i]);
  const double beyond = direction_ * (farthest + creeping_part * omega_unit_);
  if (!leap(Way::newton, beyond) && !leap(Way::integration, beyond)) leap(Way::anew, beyond);
}

// A branch that runs back, in a circle or on and on is left at its farthest point, for the next one of the sweep's
// sense; false if none is found, and nothing has changed then. `why` by value: the ways on have words of their own.
bool Follower::leave_from_farthest(std::string why, bool briefly) {
  if (settings_.steps_only) return false;
  bool left;
  if (!farthest_ || direction_ * (here_.omega - farthest_->omega) > 0) { // all that leads ahead was tried
    left = (orbit_ && (leap(Way::integration, here_.omega, 0.4) || leap(Way::scattered, here_.omega))) ||
           from_other_end(why, here_.omega, briefly) || (!briefly && leap(Way::sown, here_.omega));
  } else if (summary_.counts.leaps >= most_leaps || summary_.counts.integrations >= most_integrations) {
    left = from_other_end(why, farthest_->omega, briefly);
  } else {
    std::swap(here_, *farthest_);
    refusal_ = why;
    integrating_ -= 2 * brief_work; // nothing else is left
    const double turned = here_.omega, skipped = windings_ > 0 ? std::min(first_skip * std::pow(2, windings_), 1.0) : 0,
                 from = turned + direction_ * skipped * omega_unit_,
                 within = direction_ * (settings_.to - from) > 0 ? from : turned;
    left = (!briefly && leap(Way::newton, from)) || leap(Way::integration, from, 0.4) ||
           (orbit_ && leap(Way::scattered, within)) || (briefly && stays_ == 0 && !dear() && leap(Way::newton, from)) ||
           from_other_end(why, turned, briefly) ||
           (!orbit_ && (briefly ? stays_ > 0 && leap(Way::scattered, within) : leap(Way::sown, within)));
    if (left) {
      farthest_.reset();
      ++windings_, left_at_ = turned;
      stays_ = 0;
    } else {
      std::swap(here_, *farthest_);
    }
  }
  if (!left && summary_.end != End::interrupted) summary_.why = why;
  return left;
}

} // namespace dovetail
