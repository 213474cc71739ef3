#include "app/follow_mode.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "analyses/backbone.hpp"
#include "app/earlier_run.hpp"
#include "app/watching.hpp"
#include "results/progress.hpp"
#include "support/error.hpp"
#include "support/signals.hpp"

namespace dovetail {
namespace {

// A mode has no load to scale by: the amplitude at which the first contact point gives way is taken.
Scales scales_of(const Case &study, const StuckMode &mode) {
  if (study.scaling == ScalingKind::none) return {};
  if (study.scaling == ScalingKind::manual) return {study.scale_frequency, study.scale_modal, study.scale_contact};
  const double amplitude = std::isfinite(mode.onset.amplitude) ? mode.onset.amplitude : study.mode->from;
  return {mode.omega, amplitude, amplitude * (mode.largest > 0 ? mode.largest : 1)};
}

BackboneSettings settings_of(const Case &study, const StuckMode &mode, const Scales &scales) {
  BackboneSettings settings;
  settings.from = study.mode->from / scales.modal, settings.to = study.mode->to / scales.modal;
  for (const double wanted : study.at) settings.at.push_back(wanted / scales.modal);
  settings.to_force = study.mode->to_force;
  settings.step = study.step, settings.max_points = study.max_points, settings.between = study.between;
  settings.shape = mode.modal;
  for (const std::complex<double> value : mode.contact) settings.shape.push_back(value * scales.modal / scales.contact);
  settings.omega = mode.omega / scales.frequency, settings.onset = mode.onset.amplitude / scales.modal;
  settings.straight = mode.straight;
  return settings;
}

// Means move with it before anything slips: what is known of the onset is of the preload state.
bool has_constant_load(const Case &study) {
  return std::any_of(study.loads.begin(), study.loads.end(),
                     [](const LoadCourse &load) { return !load.fourier.empty() && load.fourier[0] != 0; });
}

PointRecord record_of(const BackbonePoint &point, const Scales &scales, double seconds) {
  const HarmonicSystem &system = point.mode.system();
  const UniqueVec x = system.unknowns();
  point.mode.motion(x);
  PointRecord record = collect({x, system, point.state.omega, point.arclength, point.newton, system.activity(), nullptr,
                                nullptr, NAN, point.progress, point.located},
                               seconds, 1);
  record.parameter = point.state.amplitude * scales.modal;
  record.damping_ratio = point.state.ratio;
  record.friction_energy = point.balance.friction * std::pow(scales.modal * scales.frequency, 2);
  record.force_level = point.balance.load;
  record.energy_error = point.balance.error();
  return record;
}

std::string amplitude_in_words(const Case &study, double amplitude) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", amplitude);
  return text + behind_number(study.units.instead_of(modal_amplitude().unit));
}

// What the user should know before the first point.
std::vector<Warning> warnings_of(const Case &study, const StuckMode &mode) {
  const double onset = mode.onset.amplitude;
  if (has_constant_load(study)) return {};
  if (!std::isfinite(onset))
    return {{"no_slip", "no contact point slips or lifts off in mode " + std::to_string(mode.number) +
                            ", at any amplitude: it is the linear mode of the stuck structure"}};
  if (study.mode->to > onset || !mode.straight) return {};
  return {{"no_slip", "mode.amplitude ends at " + amplitude_in_words(study, study.mode->to) +
                          ", below the onset: contact point " + std::to_string(mode.onset.point) + " " +
                          mode.onset.what + " first, at " + amplitude_in_words(study, onset) +
                          "; up to there the mode is linear"}};
}

void say_mode(const Case &study, const StuckMode &mode, int sectors, const Voice &voice) {
  std::string line = "mode " + std::to_string(mode.number);
  if (sectors > 0) line += " of nodal diameter " + std::to_string(std::abs(study.wave(sectors).index(1)));
  line += ": " + study.frequency_unit.in_hertz(true).text(mode.omega, 9) + " stuck";
  const bool known = !has_constant_load(study); // what gives way first
  if (known && std::isfinite(mode.onset.amplitude))
    line += "; contact point " + std::to_string(mode.onset.point) + " " + mode.onset.what + " first, at amplitude " +
            amplitude_in_words(study, mode.onset.amplitude);
  if (known && !mode.straight) line += "; a point is at its bound in the preload, and slips from amplitude 0 on";
  voice.say(line);
  constexpr double far_off = 1.5; // times what was asked for: no guess at a frequency is so rough
  const double asked = study.mode->near;
  if (asked > 0 && std::max(mode.omega / asked, asked / mode.omega) > far_off)
    voice.say("note: no mode is nearer to mode.near = " + study.frequency_unit.text(asked, 6) +
              "; continuation.unit says whether that is in rad/s or Hz");
}

} // namespace

Followed follow_mode(const Case &study, PreloadedModel preloaded, const StuckMode &mode, ResultsFile &results,
                     const SavedRun *earlier, SavedRun begin, Stages &stages, StatusFile &status, const Voice &voice) {
  const MPI_Comm comm = preloaded.reduced.comm;
  BranchStory story;
  story.warnings = warnings_of(study, mode);
  say_mode(study, mode, preloaded.reduced.sectors, voice);
  for (const Warning &warning : story.warnings) voice.warn(warning);
  results.describe(mode);

  const Scales scales = earlier ? earlier->scales : scales_of(study, mode);
  const auto system = stages.run("4 scaling", [&] {
    return std::make_unique<HarmonicSystem>(
        scaled(std::move(preloaded), study, scales), study.harmonics, study.samples, study.loads,
        study.solver == SolverKind::modal ? LinearForm::modal : LinearForm::assembled);
  });
  BackboneSettings settings = settings_of(study, mode, scales);
  if (has_constant_load(study)) settings.straight = false;
  Watching watching(study, *system);
  story.range = study.range(), story.scale = scales.modal;
  story.told = {watching.units(), study.watch.name, system->layout().modes};
  if (earlier) {
    NonlinearMode there(*system);
    check_place(there, study, earlier->branch);
  }
  int signal = 0, points = earlier ? earlier->branch.counts.points : 0, unknown = -1;
  const auto progress = // results may outlive this function
      std::make_shared<Progress>(voice.speaks(), story.told, watching.shown(), story.range, points, status);
  progress->heading();

  std::vector<double> named{story.range.from, story.range.to}; // come out as the user wrote them, to the last bit
  named.insert(named.end(), study.at.begin(), study.at.end());
  const auto user_value = [&](double value) {
    for (const double wanted : named)
      if (std::abs(value - wanted) <= 1e-12 * wanted) return wanted;
    return value;
  };
  ModeStory &told = story.mode.emplace();
  told.number = mode.number, told.omega = mode.omega, told.onset = mode.onset;
  double clock = MPI_Wtime(), omega = mode.omega, amplitude = 0; // of what is watched, at the last point
  BackboneObserver observer;
  observer.point = [&](const BackbonePoint &point) {
    if (points == 0 && study.mode->to_force > 0 && !std::isfinite(point.balance.load))
      throw InputError(study.given.at("mode.to_force") + ": mode.to_force: the load of the case does no work on mode " +
                       std::to_string(mode.number) + ", so no multiple of it is reached; delete this key");
    const double now = MPI_Wtime();
    PointRecord record = record_of(point, scales, now - clock);
    record.parameter = user_value(record.parameter);
    if (voice.speaks()) watching.measure(record);
    ++points, clock = now, omega = record.omega, unknown = record.unknown, amplitude = record.amplitude;
    told.omega_last = record.omega, told.force_level = record.force_level;
    told.energy_error = std::max(told.energy_error, std::abs(record.energy_error));
    if (record.damping_ratio >= told.ratio_most)
      told.ratio_most = record.damping_ratio, told.amplitude_most = record.parameter;
    results.append(std::move(record), [progress](const PointRecord &row) { progress->point(row); });
  };
  observer.event = [&](const BranchEvent &event) {
    const bool place = event.kind == BranchEvent::Kind::fold; // the point reported last
    const EventRecord record{static_cast<int>(event.kind), std::max(0, points - 1), omega,
                             place ? amplitude : 0,        place ? unknown : -1,    event.parameter * scales.modal};
    results.append(record, [=] { progress->event(event, record); });
  };
  observer.interrupted = [&] { return (signal = results.agreement().agree(noted_signal())) != 0; };
  begin.scales = scales;
  StateKeeper keeper(comm, state_of(study), std::move(begin));
  observer.state = [&](BranchState state) { keeper.take(std::move(state), results); };
  observer.archive = [&](Archive &archive) {
    archive.field("omega_last", omega);
    archive.field("amplitude_last", amplitude);
    archive.field("unknown_last", unknown);
    archive.field("force_level", told.force_level);
    archive.field("energy_error", told.energy_error);
    archive.field("ratio_most", told.ratio_most);
    archive.field("amplitude_most", told.amplitude_most);
    if (archive.restores()) told.omega_last = omega;
  };
  story.summary = stages.run("5 branch", [&] {
    return follow_backbone(*system, {study.step_tolerance, study.residual_tolerance, study.max_iterations}, settings,
                           observer, earlier ? &earlier->branch : nullptr);
  });
  if (mode.twin > 0 && !story.summary.good() && signal == 0)
    story.summary.why +=
        "; mode " + std::to_string(mode.twin) +
        " of the stuck structure has the same frequency, and all sums of the two are modes as well: set "
        "them apart, by a constraint of symmetry or a small mass";
  story.omega = omega;
  story.events = results.events();
  story.parts = keeper.parts(), story.seconds_all_parts = keeper.seconds();
  return {std::move(story), signal, false, std::move(keeper)};
}

} // namespace dovetail
