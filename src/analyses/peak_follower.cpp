#include "analyses/peak_follower.hpp"

#include <algorithm>
#include <cmath>

#include "analyses/peak_search.hpp"
#include "analyses/saved_points.hpp"
#include "continuation/stepper.hpp"
#include "harmonic/dense_model.hpp"
#include "problems/forced_response.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "following a peak";
constexpr double farthest = 1e-2;   // of the range: so far beyond where the equations meet the peak is looked for
constexpr double longest_jump = 10; // times accuracy.between: from one maximum to the next at the same flat top

// A corner of the track is met as nearly as the curve is drawn: with hundreds of contact points there are many.
double shortest(const TrackSettings &settings) {
  return std::clamp(settings.search.between, step_limits.shortest, step_limits.careful);
}

class PeakFollower : private Stepper {
public:
  PeakFollower(HarmonicSystem &system, std::shared_ptr<VariedPreload> preload, const NewtonSettings &newton,
               const TrackSettings &settings, const BranchObserver &observer);

  BranchSummary run(Vec y, const BranchState *state);

private:
  using End = BranchSummary::End;

  bool find_first(Vec y);
  void begin(PeakSearch::Found found);
  bool goes_on();
  void restore(const BranchState &state);
  BranchState state();
  void archive(Archive &archive, SavedVectors &vectors);
  Outcome pass(Vec normal, double step, double plain, bool at_kink) override;
  bool takes_jump(double apart) override;
  void jumped() override;
  void halved(const std::string &why) override;
  void turned_kink(double angle, double value) override;
  Outcome no_step() override;
  bool is_peak(const CurvePoint &s);
  bool solve_within(const CurvePoint &until, double value, CurvePoint &s);
  Outcome pass_wanted(Vec normal, double plain, const CurvePoint &until);
  Outcome meet_minimum(Vec normal, double step, double plain);
  Outcome end(End how, const std::string &why = "");
  void report(const CurvePoint &s, double arclength, bool located = false);
  void notify(BranchEvent::Kind kind, const std::string &text, const CurvePoint &s);
  std::string name() const { return settings_.parameter->name; }

  HarmonicSystem &system_;
  const NewtonSettings &newton_;
  const TrackSettings &settings_;
  const BranchObserver &observer_;
  BranchSummary summary_;
  PeakSearch search_;
  PeakEquations &peak_;
  std::shared_ptr<TrackLeg> leg_; // that is followed
  AmplitudeMeter meter_;
  double arclength_ = 0, sense_; // of the parameter
  double leap_;                  // of the range, beyond the next corner
  bool ended_ = false;
};

double unit_of(const TrackSettings &settings) { return std::abs(settings.to - settings.from); }

PeakFollower::PeakFollower(HarmonicSystem &system, std::shared_ptr<VariedPreload> preload, const NewtonSettings &newton,
                           const TrackSettings &settings, const BranchObserver &observer)
    : Stepper({true, settings.search.step, settings.search.between, shortest(settings)}, unit_of(settings),
              newton.step_tolerance),
      system_(system), newton_(newton), settings_(settings), observer_(observer),
      search_(system, std::move(preload), newton, settings, summary_.counts), peak_(search_.equations()),
      leg_(search_.smooth()), meter_(peak_.system().layout(), settings.search.watched),
      sense_(settings.to < settings.from ? -1 : 1), leap_(shortest(settings)) {
  take_curve(*leg_->curve);
}

BranchSummary PeakFollower::run(Vec y, const BranchState *state) {
  summary_.parameter = summary_.farthest = settings_.from;
  if (state)
    restore(*state);
  else if (!find_first(y))
    return summary_;
  while (!ended_ && goes_on()) advance();
  summary_.parameter = summary_.farthest = here_.parameter;
  return summary_;
}

// Between two steps: where does it stand, and may it go on.
bool PeakFollower::goes_on() {
  curve_->recall(curve_->memory()), peak_.begin_solves(peak_.solver_memory()); // so does a restart
  if (observer_.state) observer_.state(state());
  if (summary_.counts.points >= settings_.max_points)
    end(End::max_points, "stopped at continuation.max_points = " + std::to_string(settings_.max_points));
  else if (observer_.interrupted && observer_.interrupted())
    end(End::interrupted, "interrupted");
  return !ended_;
}

// The highest peak of the sweep, as the first point of the track.
bool PeakFollower::find_first(Vec y) {
  UniqueVec last = peak_.system().unknowns(), highest = peak_.system().unknowns();
  double most = 0;
  int peaks = 0;
  const BranchObserver search{[&](const BranchPoint &point) {
                                if (point.located) pad(point.system.layout(), point.y, peak_.system().layout(), last);
                              },
                              [&](const BranchEvent &event) {
                                if (event.kind != BranchEvent::Kind::peak) return;
                                ++peaks;
                                if (event.amplitude <= most) return;
                                most = event.amplitude;
                                check(VecCopy(last, highest), doing);
                              },
                              {},
                              observer_.interrupted};
  const BranchSummary swept = follow_branch(system_, newton_, settings_.search, y, search);
  summary_.counts.newton += swept.counts.newton, summary_.counts.linear += swept.counts.linear;
  summary_.counts.inexact += swept.counts.inexact;
  if (swept.end == End::interrupted) {
    end(End::interrupted, "interrupted");
    return false;
  }
  if (peaks == 0) {
    const bool whole = swept.end == End::arrived || swept.end == End::peaks;
    end(End::no_start, "no peak lies within continuation.omega at the first " + name() +
                           (whole ? "" : ", as far as it was swept: " + swept.why));
    return false;
  }
  auto found = search_.near(settings_.from, highest);
  if (!found) {
    end(End::no_start, "of the highest peak within continuation.omega at the first " + name() +
                           " no maximum is found that could be followed");
    return false;
  }
  const std::string which = peaks == 1 ? "the peak" : "the highest of " + std::to_string(peaks) + " peaks";
  notify(BranchEvent::Kind::start, which + " within continuation.omega", found->at);
  begin(std::move(*found));
  return true;
}

// From here on along the leg of that point.
void PeakFollower::begin(PeakSearch::Found found) {
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
bool PeakFollower::takes_jump(double apart) {
  const double before = parameter_of(here_.t), behind = parameter_of(trial_.t);
  if (apart > longest_jump * control_.between() || before * behind <= 0) return false;
  const Amplitude from = meter_(here_.y, here_.t), to = meter_(trial_.y, trial_.t);
  const double slope = (from.slope / before + to.slope / behind) / 2, // by the parameter
      off = to.value - from.value - slope * (trial_.parameter - here_.parameter);
  return std::abs(off) <= control_.between() * from.value && is_peak(trial_);
}

void PeakFollower::jumped() {
  ++summary_.counts.corners;
  notify(BranchEvent::Kind::corner, "the peak goes on beside a corner of the response", here_);
}

void PeakFollower::halved(const std::string &why) {
  ++summary_.counts.cuts;
  notify(BranchEvent::Kind::cut, why + ", step halved", here_);
}

void PeakFollower::turned_kink(double angle, double) {
  ++summary_.counts.corners;
  notify(BranchEvent::Kind::corner,
         "corner of the track, turning by " + std::to_string(std::lround(angle * 180 / M_PI)) + " degrees", here_);
}

// Where the response has a corner in or near its maximum: the peak a little farther on, of whatever kind.
Stepper::Outcome PeakFollower::no_step() {
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
    arclength_ += curve_->norm.length(here_.t) * leap;
    begin(std::move(*found));
    return ended_ ? Outcome::ended : Outcome::on;
  }
  return end(End::stalled, why);
}

// Whether a point of the track is a maximum: the minimum that a maximum meets lies on the same track.
bool PeakFollower::is_peak(const CurvePoint &s) {
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
bool PeakFollower::solve_within(const CurvePoint &until, double value, CurvePoint &s) {
  const double part = (value - here_.parameter) / (until.parameter - here_.parameter);
  check(VecAXPBYPCZ(s.y, 1 - part, part, 0, here_.y, until.y), doing);
  if (!curve_->solve_at(value, s)) return false;
  if (is_peak(s)) return true;
  s.newton.why = "what is found there is no maximum";
  return false;
}

// Points at the values of `at` between here_ and `until`. The end of the range, where it is among them, needs a peak:
// else the step is refused.
Stepper::Outcome PeakFollower::pass_wanted(Vec normal, double plain, const CurvePoint &until) {
  const double from = here_.parameter, sense = until.parameter < from ? -1 : 1;
  const auto passed = [&](double value) {
    return (value - from) * sense > 0 && (until.parameter - value) * sense >= 0;
  };
  const auto along = [&](const CurvePoint &s) {
    return arclength_ + (curve_->plane(normal, s.y) - curve_->plane(normal, here_.y)) * plain;
  };
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
Stepper::Outcome PeakFollower::meet_minimum(Vec normal, double step, double plain) {
  const Measured rate = [](CurvePoint &s) { return parameter_of(s.t); };
  std::optional<Located> fold =
      locator().between(normal, {0, here_.y, rate(here_)}, {step, trial_.y, rate(trial_)}, rate);
  const bool corner = leg_->lies_in_corner(), phase = settings_.kind == TrackedPeak::phase;
  if (fold) {
    if (const Outcome outcome = pass_wanted(normal, plain, fold->at); outcome != Outcome::on) return outcome;
    report(fold->at, arclength_ + fold->along * plain, true);
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

Stepper::Outcome PeakFollower::pass(Vec normal, double step, double plain, bool at_kink) {
  if (leg_->lies_in_corner() && !is_peak(trial_)) {
    refusal_ = "the peak leaves the corner within the step";
    return Outcome::refused;
  }
  if (parameter_of(here_.t) * parameter_of(trial_.t) < 0) {
    refusal_ = "the track turns back in a corner"; // to a minimum: the peak itself goes on, if in the corner
    return at_kink ? Outcome::refused : meet_minimum(normal, step, plain);
  }
  if (const Outcome outcome = pass_wanted(normal, plain, trial_); outcome != Outcome::on) return outcome;
  arclength_ += step * plain;
  std::swap(here_, trial_);
  report(here_, arclength_);
  leap_ = shortest(settings_);
  return Outcome::on;
}

Stepper::Outcome PeakFollower::end(End how, const std::string &why) {
  summary_.end = how, summary_.why = why;
  ended_ = true;
  return Outcome::ended;
}

void PeakFollower::report(const CurvePoint &s, double arclength, bool located) {
  ++summary_.counts.points;
  leg_->track->take(s.y);
  const double progress = 1 - std::abs(settings_.to - s.parameter) / unit_;
  observer_.point({peak_.y(), peak_.system(), s.parameter, arclength, s.newton,
                   static_cast<const ResponseData &>(*s.data).activity, nullptr, nullptr, NAN, progress, located,
                   peak_.omega()});
}

void PeakFollower::notify(BranchEvent::Kind kind, const std::string &text, const CurvePoint &s) {
  observer_.event({kind, text, parameter_of(s.y), meter_(s.y, s.y).value, leg_->track->omega_of(s.y)});
}

BranchState PeakFollower::state() {
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
  archive(saved, vectors);
  state.fields = saved.fields();
  return state;
}

void PeakFollower::restore(const BranchState &state) {
  const Layout &layout = peak_.system().layout();
  summary_.counts = state.counts;
  Archive saved(state.fields);
  SavedVectors vectors(layout);
  archive(saved, vectors);
  set_numbers(layout, state.y, here_.y);
  set_numbers(layout, state.tangent, here_.t);
  here_.parameter = parameter_of(here_.y);
}

void archive_leg(Archive &archive, const char *name, SavedVectors &vectors, const TrackLeg &leg) {
  archive.part(name, [&] {
    leg.condition->archive(archive);
    vectors.metric(archive, leg.metric());
    archive_memory(archive, *leg.curve);
  });
}

// Saved and restored by the same list: the leg first, which makes here_ anew.
void PeakFollower::archive(Archive &archive, SavedVectors &vectors) {
  int point = leg_->point;
  Graze graze;
  graze.direction = leg_->direction;
  archive.field("point", point);
  archive.field("direction", graze.direction);
  if (archive.restores() && point > 0) {
    leg_ = search_.corner(point, graze);
    take_curve(*leg_->curve);
  }
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

} // namespace

BranchSummary follow_peak(HarmonicSystem &system, std::shared_ptr<VariedPreload> preload, const NewtonSettings &newton,
                          const TrackSettings &settings, Vec y, const BranchObserver &observer,
                          const BranchState *state) {
  PeakFollower follower(system, std::move(preload), newton, settings, observer);
  return follower.run(y, state);
}

} // namespace dovetail
