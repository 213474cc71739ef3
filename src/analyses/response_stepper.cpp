#include "analyses/response_stepper.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "analyses/other_harmonics.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr double most_beyond = 0.5; // of the room before the range: so far a curve is followed there
constexpr double alone = 1e-3;      // of its value, is what counts as much as the motion where there is one point only

double unit_of(const BranchSettings &settings) {
  return settings.to != settings.from ? std::abs(settings.to - settings.from) : alone * settings.from;
}

} // namespace

ResponseStepper::ResponseStepper(HarmonicSystem &system, const NewtonSettings &newton, const BranchSettings &settings,
                                 BranchReport &report)
    : Stepper({settings.adaptive, settings.step, settings.between}, unit_of(settings), newton.step_tolerance),
      response(system, newton, settings, unit_, report.counts), range{settings.from, settings.to, settings.at, unit_},
      progress(unit_), errors(response, newton, settings, unit_, report.counts), report_(report),
      limit_(settings.stop_at_amplitude), most_points_(settings.max_points), most_peaks_(settings.stop_after_peaks),
      stability_(settings.stability ? &system : nullptr),
      harmonics_(response, errors, settings.tolerance, unit_,
                 [this](int harmonics, int most, double error) { return change_harmonics(harmonics, most, error); }) {
  take_curve(response.curve());
}

void ResponseStepper::begin(double step) {
  if (range.direction() < 0) turn(here_);
  curve_->norm.see(here_.y);
  for (int i = 0; i < step_limits.most_refinements && harmonics_.refine(here_); ++i) {
  }
  stability_.stand(stability_.judge(here_));
  give(here_, 0, stability_.verdict());
  if (range.one_point()) return;
  measure_anew();
  control_.set(step);
  progress.ahead.begin(here_.parameter, report_.counts.newton, range.direction());
  begin_amplitude();
  progress.retraced.add(curve_->problem, here_.y, here_.t, curve_->norm.largest_motion());
  limit_step();
}

void ResponseStepper::land() {
  begin_amplitude();
  stability_.stand(stability_.judge(here_));
  give(here_, arclength_, stability_.verdict());
  curve_->norm.see(here_.y);
  measure_anew();
  progress.retraced.leave();
  progress.retraced.add(curve_->problem, here_.y, here_.t, curve_->norm.largest_motion());
  control_.set(step_limits.careful);
  limit_step();
}

void ResponseStepper::begin_amplitude() {
  forget_steps();
  amplitude_.begin(response.amplitude(here_), plain_length(here_.t));
  if (limit_ > 0 && amplitude_.here.value >= limit_) // with no step to it
    report_.end(End::amplitude, "stopped: the amplitude is beyond continuation.stop_at_amplitude");
}

// here_ becomes trial_, `step` farther on along the curve, with all that lies within, and nothing where the curve has
// left the range.
ResponseStepper::Outcome ResponseStepper::pass(Vec normal, double step, bool at_kink) {
  folds_before_ = report_.counts.folds;
  double length = curve_->chord(here_.y, trial_.y);
  const AmplitudeCourse next = amplitude_.after(response.amplitude(trial_), plain_length(trial_.t), length, at_kink);
  const bool was_outside = range.before_start(here_.parameter) > 0, outside = range.before_start(trial_.parameter) > 0;
  if (!was_outside || !outside) {
    const EventLocator within = locator();
    Places found = PlaceFinder(response, range, limit_, stability_, report_, within,
                               {here_, trial_, amplitude_.here, next.here, normal, step, at_kink})
                       .find(std::exchange(branch_point_, std::nullopt));
    progress.ahead.spare(found.newton_at_kinks);
    if (!found.complete) {
      refusal_ = found.why_incomplete;
      return Outcome::refused;
    }
    for (int i = 0; i < found.unlocated_folds; ++i) progress.cluster.folded(here_.parameter);
    amplitude_.error = next.error;
    if (!found.list.empty()) {
      std::vector<double> lengths{curve_->chord(here_.y, found.list[0].at.y)}; // to each place, from one to the next
      for (std::size_t i = 1; i < found.list.size(); ++i)
        lengths.push_back(lengths.back() + curve_->chord(found.list[i - 1].at.y, found.list[i].at.y));
      length = lengths.back() + curve_->chord(found.list.back().at.y, trial_.y);
      if (tell(found.list, lengths, at_kink) == Outcome::ended) return Outcome::ended;
    }
  }
  if (outside && !was_outside)
    report_.event(BranchEvent::Kind::outside,
                  "the curve leaves the sweep at its beginning: points beyond are not stored, the next is where it "
                  "comes back",
                  here_.parameter);
  arclength_ += length;
  std::swap(here_, trial_);
  amplitude_ = next;
  const double before = trial_.parameter;
  if (range.is_ahead(before, here_.parameter) && farthest.is_behind(before)) note(farthest.point, trial_);
  if (!outside)
    give(here_, arclength_, stability_.verdict());
  else if (range.before_start(here_.parameter) > most_beyond * range.room_before())
    return report_.end(End::turned_back,
                       "the branch turned back, left the sweep at its beginning and did not come back");
  return Outcome::on;
}

ResponseStepper::Outcome ResponseStepper::settle(Vec way) {
  std::vector<Problem::Projected> marks = curve_->problem.own_projected({here_.y, here_.t});
  const ResponseMetric::Lengths lengths = response.metric().see(here_.y, way, marks);
  progress.drift.stepped(lengths.swing, lengths.whole);
  const auto sense = progress.retraced.add(marks, curve_->norm.largest_motion());
  if (sense != RetraceMonitor::Sense::fresh) {
    if (progress.retraced.met_left())
      return report_.end(End::turned_back, "the branch came back to a piece of it that had been left");
    return report_.end(End::retraced, sense == RetraceMonitor::Sense::opposite
                                          ? "the branch runs back over itself"
                                          : "the branch is closed: it came back to where it was");
  }
  measure_anew();
  return Outcome::on;
}

void ResponseStepper::halved(const std::string &why) {
  report_.event(report_.counts.cuts, BranchEvent::Kind::cut, why + ", step halved", here_.parameter);
}

void ResponseStepper::turned_kink(double angle, double parameter) {
  if (report_.counts.folds == folds_before_) progress.cluster.folded(parameter); // else it is one already
  report_.event(report_.counts.corners, BranchEvent::Kind::corner,
                "corner of the curve, turning by " + std::to_string(std::lround(angle * 180 / M_PI)) + " degrees",
                parameter);
}

// The system before goes last: points and curves of it are in use until then.
void ResponseStepper::adopt(std::unique_ptr<HarmonicSystem> system) {
  if (farthest.point) { // where the curve may be left: no solution any more, but near one
    farthest.point->y = padded(response.layout(), farthest.point->y, *system);
    farthest.point->t = padded(response.layout(), farthest.point->t, *system);
  }
  const std::unique_ptr<HarmonicSystem> before = response.exchange(std::move(system));
  take_curve(response.curve());
  stability_.match(response.system());
  errors.match();
}

void ResponseStepper::stand_on(CurvePoint point, std::unique_ptr<HarmonicSystem> system) {
  if (system) {
    adopt(std::move(system));
    harmonics_.lent(point.parameter);
    ++report_.counts.harmonics;
  }
  here_ = std::move(point);
}

bool ResponseStepper::change_harmonics(int harmonics, int most_newton, double error) {
  const int before = response.system().harmonics();
  std::unique_ptr<HarmonicSystem> system = response.with(harmonics);
  auto there = in_other_harmonics(response, *system, range, here_, {report_.counts.points == 0, most_newton});
  if (!there) return false;
  const double step = control_.step();
  adopt(std::move(system));
  here_ = std::move(*there);
  begin_amplitude();
  control_.set(step);
  char text[120];
  std::snprintf(text, sizeof text, "%d %s from here on (estimated error with %d: %.1e)", harmonics,
                harmonics == 1 ? "harmonic" : "harmonics", before, error);
  report_.event(report_.counts.adaptations, BranchEvent::Kind::harmonics, text, here_.parameter);
  return true;
}

} // namespace dovetail
