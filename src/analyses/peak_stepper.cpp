#include "analyses/peak_stepper.hpp"

#include <algorithm>
#include <cmath>

#include "harmonic/dense_model.hpp"
#include "problems/forced_response.hpp"
#include "support/error.hpp"
#include "support/shell.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "following a peak";
constexpr double farthest = 1e-2;   // of the range: so far beyond where the equations meet the peak is looked for
constexpr double longest_jump = 10; // times accuracy.between: from one maximum to the next at the same flat top

// A corner of the track is met as nearly as the curve is drawn: with hundreds of contact points there are many.
double shortest(const TrackSettings &settings) {
  return std::clamp(settings.search.between, step_limits.shortest, step_limits.careful);
}

double unit_of(const TrackSettings &settings) { return std::abs(settings.to - settings.from); }

} // namespace

PeakStepper::PeakStepper(HarmonicSystem &system, std::shared_ptr<VariedPreload> preload, const NewtonSettings &newton,
                         const TrackSettings &settings, const BranchObserver &observer)
    : Stepper({true, settings.search.step, settings.search.between, shortest(settings)}, unit_of(settings),
              newton.step_tolerance),
      system_(system), newton_(newton), settings_(settings), observer_(observer),
      search_(system, std::move(preload), newton, settings, summary_.counts), peak_(search_.equations()),
      leg_(search_.smooth()), meter_(peak_.system().layout(), settings.search.watched),
      sense_(settings.to < settings.from ? -1 : 1), leap_(shortest(settings)) {
  take_curve(*leg_->curve);
}

// From here on along the leg of that point.
void PeakStepper::begin(PeakSearch::Found found) {
  const bool was_in_corner = leg_->lies_in_corner();
  leg_ = std::move(found.leg);
  take_curve(*leg_->curve);
  here_ = std::move(found.at);
  if (parameter_of(here_.t) * sense_ < 0) turn(here_);
  curve_->norm.see(here_.y);
  measure_anew();
  report(here_, arclength_);
  if (leg_->lies_in_corner())
    notify(BranchEvent::Kind::corner,
           "from here on the peak lies in a corner of the response, where " + leg_->slider() + " begins to slip",
           here_);
  else if (was_in_corner)
    notify(BranchEvent::Kind::corner, "the peak has left the corner", here_);
  control_.set(step_limits.careful);
  limit_step();
  if (here_.parameter == settings_.to) end(End::arrived);
}

// Where one of many contact points begins to slip in the peak itself, the top changes its place, but not its height.
bool PeakStepper::takes_jump(double apart) {
  const double before = parameter_of(here_.t), behind = parameter_of(trial_.t);
  if (apart > longest_jump * control_.between() || before * behind <= 0) return false;
  const Amplitude from = meter_(here_.y, here_.t), to = meter_(trial_.y, trial_.t);
  const double slope = (from.slope / before + to.slope / behind) / 2, // by the parameter
      off = to.value - from.value - slope * (trial_.parameter - here_.parameter);
  return std::abs(off) <= control_.between() * from.value && is_peak(trial_);
}

void PeakStepper::jumped() {
  ++summary_.counts.corners;
  notify(BranchEvent::Kind::corner, "the peak goes on beside a corner of the response", here_);
}

void PeakStepper::halved(const std::string &why) {
  ++summary_.counts.cuts;
  notify(BranchEvent::Kind::cut, why + ", step halved", here_);
}

void PeakStepper::turned_kink(double angle, double) {
  ++summary_.counts.corners;
  notify(BranchEvent::Kind::corner,
         "corner of the track, turning by " + std::to_string(std::lround(angle * 180 / M_PI)) + " degrees", here_);
}

// Where the response has a corner in or near its maximum: the peak a little farther on, of whatever kind.
Stepper::Outcome PeakStepper::no_step() {
  const std::string why = refusal_;
  UniqueVec motion = peak_.system().unknowns();
  leg_->track->take(here_.y);
  check(VecCopy(peak_.y(), motion), doing);
  double next = settings_.to;
  for (const double value : settings_.at)
    if ((value - here_.parameter) * sense_ > 0 && (next - value) * sense_ > 0) next = value;
  while (leap_ <= farthest) {
    const double leap = leap_;
    leap_ *= 10;
    double value = here_.parameter + sense_ * leap * unit_;
    if ((value - next) * sense_ > 0) value = next;
    auto found = search_.near(value, motion);
    if (!found) continue;
    ++summary_.counts.corners;
    arclength_ += curve_->chord(here_.y, found->at.y);
    begin(std::move(*found));
    return ended_ ? Outcome::ended : Outcome::on;
  }
  return end(End::stalled, why);
}

// Whether a point of the track is a maximum: the minimum that a maximum meets lies on the same track.
bool PeakStepper::is_peak(const CurvePoint &s) {
  if (settings_.kind == TrackedPeak::phase) return true;
  if (leg_->lies_in_corner()) {
    const auto sides = search_.sides(*leg_->track, s.y);
    return sides && sides->is_peak();
  }
  leg_->track->take(s.y);
  if (!peak_.differentiate()) return false;
  peak_.turn();
  return peak_.slope() > 0;
}

// The peak at a value of the parameter between those of here_ and `until`; else s.newton.why tells.
bool PeakStepper::solve_within(const CurvePoint &until, double value, CurvePoint &s) {
  const double part = (value - here_.parameter) / (until.parameter - here_.parameter);
  check(VecAXPBYPCZ(s.y, 1 - part, part, 0, here_.y, until.y), doing);
  if (!curve_->solve_at(value, s)) return false;
  if (is_peak(s)) return true;
  s.newton.why = "what is found there is no maximum";
  return false;
}

// Points at the values of `at` between here_ and `until`. The end of the range, where it is among them, needs a peak:
// else the step is refused.
Stepper::Outcome PeakStepper::pass_wanted(const CurvePoint &until) {
  const double from = here_.parameter, sense = until.parameter < from ? -1 : 1;
  const auto passed = [&](double value) {
    return (value - from) * sense > 0 && (until.parameter - value) * sense >= 0;
  };
  const auto along = [&](const CurvePoint &s) { return arclength_ + curve_->chord(here_.y, s.y); };
  const bool arrives = passed(settings_.to);
  CurvePoint last = curve_->point();
  if (arrives && !solve_within(until, settings_.to, last)) {
    refusal_ = "no peak at the end of path.range: " + last.newton.why;
    return Outcome::refused;
  }
  std::vector<double> wanted;
  for (const double value : settings_.at)
    if (passed(value) && (settings_.to - value) * sense > 0) wanted.push_back(value);
  std::sort(wanted.begin(), wanted.end(), [&](double a, double b) { return (b - a) * sense > 0; });
  for (const double value : wanted) {
    CurvePoint s = curve_->point();
    if (solve_within(until, value, s)) {
      report(s, along(s), true);
      continue;
    }
    ++summary_.counts.missed;
    notify(BranchEvent::Kind::missed, "no peak at this " + name() + " of path.at: " + s.newton.why, s);
  }
  if (!arrives) return Outcome::on;
  report(last, along(last));
  std::swap(here_, last);
  return end(End::arrived);
}

// A fold of the track: beyond, it leads back along the minimum of the response that the peak meets here; in a corner,
// along another corner.
Stepper::Outcome PeakStepper::meet_minimum(Vec normal, double step) {
  const Measured rate = [](CurvePoint &s) { return parameter_of(s.t); };
  std::optional<Located> fold = locator().within(normal, step, {rate(here_), rate(trial_)}, rate);
  const bool corner = leg_->lies_in_corner(), phase = settings_.kind == TrackedPeak::phase;
  if (fold) {
    if (const Outcome outcome = pass_wanted(fold->at); outcome != Outcome::on) return outcome;
    report(fold->at, arclength_ + curve_->chord(here_.y, fold->at.y), true);
    std::swap(here_, fold->at);
    ++summary_.counts.folds;
    notify(BranchEvent::Kind::fold,
           corner  ? "the corner in which the peak lies turns back: beyond, there is neither"
           : phase ? "phase resonance turns back here: beyond, there is none"
                   : "the peak meets a minimum of the amplitude: beyond, there is neither",
           here_);
  }
  return end(End::vanished, corner  ? "the corner in which the peak lay turned back, and the peak vanished"
                            : phase ? "phase resonance turned back"
                                    : "the peak met a minimum of the amplitude and vanished");
}

Stepper::Outcome PeakStepper::pass(Vec normal, double step, bool at_kink) {
  if (leg_->lies_in_corner() && !is_peak(trial_)) {
    refusal_ = "the peak leaves the corner within the step";
    return Outcome::refused;
  }
  if (parameter_of(here_.t) * parameter_of(trial_.t) < 0) {
    refusal_ = "the track turns back in a corner"; // to a minimum: the peak itself goes on, if in the corner
    return at_kink ? Outcome::refused : meet_minimum(normal, step);
  }
  if (const Outcome outcome = pass_wanted(trial_); outcome != Outcome::on) return outcome;
  arclength_ += curve_->chord(here_.y, trial_.y);
  std::swap(here_, trial_);
  report(here_, arclength_);
  leap_ = shortest(settings_);
  return Outcome::on;
}

Stepper::Outcome PeakStepper::end(End how, const std::string &why) {
  summary_.end = how, summary_.why = why;
  ended_ = true;
  return Outcome::ended;
}

// [dX; d parameter] along the track, of its plain length, which counts the frequency in.
UniqueVec PeakStepper::tangent_of(const CurvePoint &s, double along) const {
  const double plain = plain_length(s.t);
  UniqueVec tangent = peak_.system().unknowns();
  {
    const ReadValues from(s.t);
    const Values to(tangent);
    const PetscInt own = peak_.system().layout().own_coefficients();
    std::transform(from + 0, from + own, to + 0, [&](double value) { return along * value; });
  }
  set_parameter(tangent, along * parameter_of(s.t));
  note_plain_length(tangent, plain);
  return tangent;
}

void PeakStepper::report(const CurvePoint &s, double arclength, bool located) {
  ++summary_.counts.points;
  leg_->track->take(s.y);
  const double along = curve_->norm.product(s.t, here_.t) < 0 ? -1 : 1;
  const UniqueVec tangent = tangent_of(s, along);
  const double progress = 1 - std::abs(settings_.to - s.parameter) / unit_;
  observer_.point({peak_.y(), peak_.system(), s.parameter, arclength, s.newton,
                   static_cast<const ResponseData &>(*s.data).activity, nullptr, nullptr, NAN, progress, located,
                   peak_.omega(), tangent, along * leg_->track->omega_of(s.t)});
}

void PeakStepper::notify(BranchEvent::Kind kind, const std::string &text, const CurvePoint &s) {
  observer_.event({kind, text, parameter_of(s.y), meter_(s.y, s.y).value, leg_->track->omega_of(s.y)});
}

} // namespace dovetail
