// What is done with a step along the response curve.
#include <algorithm>
#include <cmath>
#include <utility>

#include "analyses/follower.hpp"

namespace dovetail {
namespace {

constexpr double most_beyond = 0.5; // of the sweep, and of its first value: so far a curve is followed before it

} // namespace

void Follower::halved(const std::string &why) {
  ++summary_.counts.cuts;
  notify(BranchEvent::Kind::cut, why + ", step halved", here_.parameter);
}

void Follower::turned_kink(double angle, double omega) {
  ++summary_.counts.corners;
  if (summary_.counts.folds == folds_before_) cluster_.folded(omega); // else it is one already
  notify(BranchEvent::Kind::corner,
         "corner of the curve, turning by " + std::to_string(std::lround(angle * 180 / M_PI)) + " degrees", omega);
}

Follower::Outcome Follower::no_step() {
  const std::string why = refusal_, where = difference();
  if (!settings_.adaptive || !recovers(Failure::Kind::no_step, why, here_.parameter))
    return end(interrupted() ? End::interrupted : End::stalled, why + where);
  return ended_ ? Outcome::ended : Outcome::on;
}

// here_ becomes trial_, `step` farther on along the curve, or `plain` times that in the plain norm; with all that lies
// within, and nothing where the curve has left the sweep.
Follower::Outcome Follower::pass(Vec normal, double step, double plain, bool at_kink) {
  folds_before_ = summary_.counts.folds;
  const Amplitude next = (*meter_)(trial_.y, trial_.t);
  const bool was_outside = beyond_start(here_.parameter) > 0, outside = beyond_start(trial_.parameter) > 0;
  const Amplitude by_arc{next.value, next.slope / plain_length(trial_.t)};
  BetweenPoints between = between_;
  if (at_kink) between.begin(by_arc);
  const double between_error = at_kink ? NAN : between.add(step * plain, by_arc);
  if (!was_outside || !outside) {
    std::vector<Place> found;
    if (!find_places(normal, step, at_kink, next, found)) return Outcome::refused;
    between_error_ = between_error;
    if (report_places(found, plain, at_kink) == Outcome::ended) return Outcome::ended;
  }
  if (outside && !was_outside)
    notify(BranchEvent::Kind::outside,
           "the curve leaves the sweep at its beginning: points beyond are not stored, the next is where it comes back",
           here_.parameter);
  const double room = settings_.from > 0 ? std::min(unit_, settings_.from) : unit_; // before the sweep
  arclength_ += step * plain;
  std::swap(here_, trial_);
  amplitude_ = next, between_ = between;
  if (const double w = trial_.parameter; direction_ * (here_.parameter - w) < 0 && farther(w)) note(farthest_, trial_);
  if (!outside)
    report(here_, arclength_, verdict_ ? &*verdict_ : nullptr);
  else if (beyond_start(here_.parameter) > most_beyond * room)
    return end(End::turned_back, "the branch turned back, left the sweep at its beginning and did not come back");
  return Outcome::on;
}

Follower::Outcome Follower::settle(Vec way) {
  drift_.stepped(metric().swing(way), curve_->norm.length(way));
  curve_->norm.see(here_.y);
  const auto sense = retraced_.add(curve_->problem, here_.y, here_.t, curve_->norm.largest_motion());
  if (sense != RetraceMonitor::Sense::fresh) {
    if (retraced_.met_left()) return end(End::turned_back, "the branch came back to a piece of it that had been left");
    return end(End::retraced, sense == RetraceMonitor::Sense::opposite
                                  ? "the branch runs back over itself"
                                  : "the branch is closed: it came back to where it was");
  }
  measure_anew();
  return Outcome::on;
}

} // namespace dovetail
