#include "app/follow.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "analyses/peak_follower.hpp"
#include "app/earlier_run.hpp"
#include "app/watching.hpp"
#include "case/number_text.hpp"
#include "problems/needed_harmonics.hpp"
#include "problems/peak_sensitivity.hpp"
#include "results/progress.hpp"
#include "support/error.hpp"
#include "support/signals.hpp"

namespace dovetail {
namespace {

constexpr PetscInt most_judged = 600; // reduced dofs, for a dense eigenproblem

// Estimates are known on rank 0.
bool beyond_belief(MPI_Comm comm, const BranchStory &story) {
  int some = std::any_of(story.estimates.begin(), story.estimates.end(),
                         [](const EstimateRecord &estimate) { return estimate.total() > no_error; });
  MPI_Bcast(&some, 1, MPI_INT, 0, comm);
  return some != 0;
}

// The forces that move the modes, which nearly cancel at a resonance [scaled].
double modal_forces(const HarmonicSystem &system, const PointRecord &record) {
  const std::vector<double> &squares = system.scaled().model.reduced.kaa;
  const std::size_t width = system.layout().width;
  double sum = 0;
  for (std::size_t mode = 0; mode < squares.size(); ++mode)
    for (std::size_t place = 1; place < width; ++place)
      sum += std::pow(squares[mode] * record.coefficients[mode * width + place] / system.scales().modal, 2);
  return std::sqrt(sum);
}

// Size of what remains at rest: the load.
double load_of(HarmonicSystem &system, double parameter) {
  UniqueVec y = system.unknowns(), f = system.unknowns();
  set_parameter(y, parameter);
  system.residual(y, f);
  PetscReal size;
  check(VecNorm(f, NORM_2, &size), "judging the load");
  return size;
}

// Whether nothing but rounding errors bounds the motion.
bool without_bound(const HarmonicSystem &system, const PointRecord &record, double load) {
  constexpr double share = 1e-3; // of the load: no more than three digits of the motion are right then
  return modal_forces(system, record) * std::numeric_limits<double>::epsilon() > share * load;
}

} // namespace

std::unique_ptr<HarmonicSystem> harmonic_system(const Case &study, PreloadedModel preloaded, const Scales &scales,
                                                int harmonics, int samples) {
  const CurveRange range = study.range();
  const PathParameter &parameter = *range.parameter;
  ScaledModel model = scaled(std::move(preloaded), study, scales);
  const auto varied =
      parameter.changes_joint ? std::make_shared<VariedPreload>(model.model, study.path->varied) : nullptr;
  auto system =
      std::make_unique<HarmonicSystem>(std::move(model), harmonics, samples, study.loads,
                                       study.solver == SolverKind::modal ? LinearForm::modal : LinearForm::assembled);
  system->vary(study.follows_peaks() ? ResponseParameter().beside(parameter, range.from / scales.of(parameter))
                                     : ResponseParameter(parameter, study.omega_from / scales.frequency),
               varied);
  return system;
}

BranchSettings settings_of(const Case &study, const HarmonicSystem &system) {
  const Scales &scales = system.scales();
  const Watching watching(study, system);
  BranchSettings settings;
  const CurveRange range = study.range();
  const double scale = scales.of(*range.parameter);
  settings.from = range.from / scale, settings.to = range.to / scale;
  settings.step = study.step;
  settings.adaptive = study.adaptive;
  settings.max_points = study.max_points;
  for (const double wanted : study.at) settings.at.push_back(wanted / scale);
  settings.watched = watching.scaled();
  settings.stop_after_peaks = study.stop_after_peaks;
  settings.stop_at_amplitude = study.stop_at_amplitude / watching.unit();
  settings.strategies = study.strategies;
  if (!study.allow_branch_change) settings.strategies.keep_branch();
  settings.work = study.work;
  settings.stability = study.stability.value_or(false);
  settings.estimates = study.estimates;
  settings.tolerance = study.tolerance, settings.between = study.between;
  return settings;
}

TrackSettings track_settings_of(const Case &study, const HarmonicSystem &system) {
  const BranchSettings range = settings_of(study, system);
  TrackSettings settings;
  settings.parameter = study.path->parameter;
  settings.from = range.from, settings.to = range.to, settings.at = range.at;
  settings.kind = *study.path->peak == PeakKind::phase ? TrackedPeak::phase : TrackedPeak::amplitude;
  settings.search = range;
  settings.search.from = study.omega_from / system.scales().frequency;
  settings.search.to = study.omega_to / system.scales().frequency;
  settings.search.at.clear();
  settings.max_points = range.max_points, settings.search.max_points = Case().max_points;
  return settings;
}

Followed follow(const Case &study, PreloadedModel preloaded, ResultsFile &results, const SavedRun *earlier,
                SavedRun begin, Stages &stages, StatusFile &status, const Voice &voice) {
  const MPI_Comm comm = preloaded.reduced.comm;
  const CurveRange range = study.range();
  const auto whole = stages.run("4 scaling", [&] {
    const Scales scales = earlier ? earlier->scales : choose_scales(study, preloaded);
    return harmonic_system(study, std::move(preloaded), scales, study.harmonics, study.samples);
  });
  HarmonicSystem &system = *whole;
  const Scales &scales = system.scales();
  Watching watching(study, system);
  const double scale = scales.of(*range.parameter);
  const BranchSettings settings = settings_of(study, system);
  UniqueVec y = system.unknowns();
  if (earlier)
    check_place(system, study, earlier->branch);
  else if (!study.start.empty())
    start_from(study.start, study.omega_from, system.layout(), scales, y);

  std::vector<double> named{range.from, range.to}; // come out as the user wrote them, to the last bit
  named.insert(named.end(), study.at.begin(), study.at.end());
  const auto user_value = [&](double value) {
    for (const double wanted : named)
      if (value == wanted / scale) return wanted;
    return value * scale;
  };
  double omega = study.omega_from; // at the last point or event of peaks, which knows its own
  const auto user_omega = [&](double value, double own) {
    if (own > 0) omega = own * scales.frequency;
    return own > 0 ? omega : study.path ? study.omega_from : user_value(value);
  };
  const double load = load_of(system, std::max(settings.from, settings.to)); // a factor on it may begin small
  int points = earlier ? earlier->branch.counts.points : 0;
  const auto progress = std::make_shared<Progress>( // results may outlive this function
      voice.speaks(), Told{watching.units(), study.watch.name, system.layout().modes}, watching.shown(), range, points,
      status);
  progress->heading();
  begin.scales = scales;
  StateKeeper keeper(comm, state_of(study), std::move(begin));
  int signal = 0;
  double clock = MPI_Wtime();
  CurveEnds ends(earlier == nullptr);
  int unknown = static_cast<int>(settings.watched.dof); // watched at the last point
  BranchObserver observer;
  struct { // the place that was reported last, for its sensitivity
    UniqueVec y;
    const HarmonicSystem *system = nullptr;
  } place;
  observer.point = [&](const BranchPoint &point) {
    const double now = MPI_Wtime();
    PointRecord record = collect(point, now - clock, scale);
    record.omega = user_omega(point.parameter, point.omega), record.parameter = user_value(point.parameter);
    results.agreement().hold([&] {
      if (!voice.speaks() || !without_bound(point.system, record, load)) return;
      results.flush();
      throw ComputeError("at " + range.text(user_value(point.parameter)) +
                         " an eigenfrequency is excited and nothing damps it: the motion is so large that "
                         "rounding errors are more than a thousandth of the load. Give damping.stiffness, or leave "
                         "this frequency out. The " +
                         std::to_string(points) + " points before are in " + results_of(study).string());
    });
    if (voice.speaks()) watching.measure(record);
    if (!study.follows_peaks()) ends.add({record.parameter, record.amplitude, record.unknown});
    ++points, clock = now, unknown = record.unknown;
    results.append(std::move(record), [progress](const PointRecord &row) { progress->point(row); });
    place.system = point.located ? &point.system : nullptr;
    if (study.sensitivity && point.located) {
      check(VecDuplicate(point.y, place.y.out()), "keeping a place");
      check(VecCopy(point.y, place.y), "keeping a place");
    }
  };
  observer.event = [&](const BranchEvent &event) {
    const EventRecord record{static_cast<int>(event.kind),
                             points - 1,
                             user_omega(event.parameter, event.omega),
                             event.amplitude * watching.unit(),
                             event.amplitude > 0 ? unknown : -1,
                             user_value(event.parameter)};
    results.append(record, [=] { progress->event(event, record); });
    if (is_jump(event.kind)) ends.jump();
    if (!study.sensitivity || event.kind != BranchEvent::Kind::peak || !place.system) return;
    results.agreement().hold([&] { results.flush(); }); // what follows is about this event
    if (const auto found = peak_sensitivity(*place.system, place.y, settings.watched))
      results.append(collect(*found, *place.system, watching.unit(), points - 1));
    else
      voice.say("  no sensitivity: no smooth maximum there, but a corner of the curve, or the steps of sampled forces");
  };
  observer.state = [&](BranchState state) { keeper.take(std::move(state), results); };
  observer.interrupted = [&] { return (signal = results.agreement().agree(noted_signal())) != 0; };
  BranchStory story;
  story.summary = stages.run("5 branch", [&] {
    const NewtonSettings newton{study.step_tolerance, study.residual_tolerance, study.max_iterations};
    if (study.follows_peaks())
      return follow_peak(system, system.preload(), newton, track_settings_of(study, system), y, observer,
                         earlier ? &earlier->branch : nullptr);
    return follow_branch(system, newton, settings, y, observer, earlier ? &earlier->branch : nullptr);
  });
  story.range = range, story.scale = scale, story.omega = omega;
  story.events = results.events();
  story.estimates = results.estimates(), story.tolerance = study.tolerance;
  if (!system.is_cyclic() && beyond_belief(comm, story) && system.layout().dofs() <= most_judged)
    story.closed_contact_frequency = scales.frequency * closed_contact_frequency(dense_model(system));
  story.told = {watching.units(), study.watch.name, system.layout().modes};
  story.ends = ends;
  story.parts = keeper.parts();
  story.seconds_all_parts = keeper.seconds();
  return {std::move(story), signal, false, std::move(keeper)};
}

} // namespace dovetail
