// A curve that leads nowhere: it comes upon itself, bends again and again, or winds on.
#include <algorithm>
#include <cmath>
#include <utility>

#include "analyses/follower.hpp"

namespace dovetail {

void Follower::drop_anchors() {
  for (auto &anchor : anchors_) anchor.reset();
  since_anchor_ = 0;
  control_.be_careful(0, 0);
}

// A curve that runs on from its beginning cannot come upon an older piece of itself, unless a step has led to another
// piece of it, or the wrong way round a corner. That is where it came upon it, or where it was there before. So the
// last points are followed once more, with short steps.
bool Follower::follow_again(const std::string &why) {
  const bool just_done = repeated_at_ > 0 && summary_.counts.points - repeated_at_ < 2 * careful_points;
  if (!settings_.adaptive || !may(Strategy::repeat) || !anchors_[0] || just_done ||
      summary_.counts.repeats >= most_repeats)
    return false;
  repeated_at_ = summary_.counts.points;
  here_ = std::move(*anchors_[0]);
  recall_activity();
  const double way = anchor_arc_;
  const int points = anchored + since_anchor_ + 1;
  drop_anchors();
  const double careful_step = careful_part * way / points;
  control_.be_careful(careful_points, careful_step);
  ++summary_.counts.repeats;
  notify(BranchEvent::Kind::again, why + ": the last points once more, with short steps", here_.parameter);
  begin_amplitude();
  retraced_.interrupt();
  drift_.forget();
  measure_anew();
  control_.set(careful_step);
  limit_step();
  return true;
}

// Many bends within a small part of the sweep are no physics, but too few harmonics for contacts that open and close.
// Not in time, where harmonics do not count.
void Follower::note_bend(double omega) {
  if (!orbit_) cluster_.folded(omega);
}

// A curve that winds on between frequencies it has met, for as many iterations as a whole sweep may take, and as some
// seconds hold if it is small, is left: the frequencies ahead are what was asked for. The more often, the sooner.
bool Follower::winds() {
  progress_.stepped(here_.parameter, summary_.counts.newton);
  if (!settings_.adaptive || settings_.strategies.none() || !farthest_) return false;
  if (!orbit_ && !(direction_ * (here_.parameter - farthest_->parameter) < 0)) return false;
  const double unknowns = static_cast<double>(system_->layout().dofs() * system_->layout().width);
  const double least = dear() && !orbit_ ? dear_patience : least_patience;
  return progress_.winds(farthest_->parameter, summary_.counts.newton, std::max(least, most_wound / unknowns));
}

// Steps converge and lead nowhere: harmonics that the contacts want and do not have, unless that was tried, or else on
// beyond the crowd.
void Follower::pass_crowd() {
  refusal_ = cluster_.why();
  const double beyond = cluster_.beyond(here_.parameter, direction_);
  if (summary_.counts.harmonics == 0 && more_harmonics()) return;
  if (!leap(Way::newton, beyond) && !leap(Way::integration, beyond)) leap(Way::anew, beyond);
}

// A branch that runs back, in a circle or on and on is left at its farthest point, for the next one of the sweep's
// sense; false if none is found, and nothing has changed then. `why` by value: the ways on have words of their own.
bool Follower::leave_from_farthest(std::string why, bool briefly) {
  bool left;
  if (!farthest_ || direction_ * (here_.parameter - farthest_->parameter) > 0) { // all that leads ahead was tried
    left = (orbit_ && (leap(Way::integration, here_.parameter, 0.4) || leap(Way::scattered, here_.parameter))) ||
           from_other_end(why, here_.parameter, briefly) || (!briefly && leap(Way::sown, here_.parameter));
  } else if (summary_.counts.leaps >= most_leaps || summary_.counts.integrations >= most_integrations) {
    left = from_other_end(why, farthest_->parameter, briefly);
  } else {
    std::swap(here_, *farthest_);
    refusal_ = why;
    integrating_ -= 2 * brief_work; // nothing else is left
    const int times = progress_.times_left(), stays = progress_.times_stayed();
    const double turned = here_.parameter, skipped = times > 0 ? std::min(first_skip * std::pow(2, times), 1.0) : 0,
                 from = turned + direction_ * skipped * unit_,
                 within = direction_ * (settings_.to - from) > 0 ? from : turned;
    left = (!briefly && leap(Way::newton, from)) || leap(Way::integration, from, 0.4) ||
           (orbit_ && leap(Way::scattered, within)) || (briefly && stays == 0 && !dear() && leap(Way::newton, from)) ||
           from_other_end(why, turned, briefly) ||
           (!orbit_ && (briefly ? stays > 0 && leap(Way::scattered, within) : leap(Way::sown, within)));
    if (left) {
      farthest_.reset();
      progress_.left(turned);
    } else {
      std::swap(here_, *farthest_);
    }
  }
  if (!left && summary_.end != End::interrupted) summary_.why = why;
  return left;
}

} // namespace dovetail
