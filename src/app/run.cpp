#include "app/run.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <optional>

#include "app/forecast.hpp"
#include "app/reduce.hpp"
#include "results/progress.hpp"
#include "results/summary.hpp"
#include "support/version.hpp"

namespace dovetail {
namespace {

// Case, sizes and contact law: all that can be wrong in the input short of the matrices themselves.
struct Checked {
  Case study;
  Forecast sizes;
  std::vector<ContactPoint> contact; // all points
  std::vector<double> initial;       // (3 N_x) [m]
};

Checked check_input(MPI_Comm comm, const Request &request) {
  Checked checked;
  on_all_ranks(comm, [&] {
    checked.study = read_case(request.file, request.out);
    const Case &study = checked.study;
    ContactSettings from_model;
    if (study.reduced.empty()) {
      ModelHeader header = read_model_header(study.model);
      from_model = header.contact;
      checked.sizes = forecast(header, study);
    } else {
      checked.sizes = forecast(read_reduced_header(study.reduced), study);
    }
    if (!study.start.empty()) check_start(study.start, checked.sizes.modes + 3 * checked.sizes.points);
    if (study.reduced.empty()) check_replaceable(study.directory / "reduced.h5");
    checked.contact = contact_points(study.contact, from_model, static_cast<int>(checked.sizes.points));
    checked.initial = initial_preload(study, static_cast<int>(checked.sizes.points));
  });
  return checked;
}

std::string in_words(const BranchSummary &summary, double frequency_scale, const std::string &results, bool exact) {
  char where[64];
  std::snprintf(where, sizeof where, "%.8g rad/s", summary.omega * frequency_scale);
  switch (summary.end) {
  case BranchSummary::End::arrived:
    return "";
  case BranchSummary::End::max_points:
    return summary.why + ", at " + where;
  case BranchSummary::End::no_start:
    return summary.why + " (" + where +
           "). Try the other end of the sweep, a start from other results (continuation.start), fewer harmonics, or a "
           "smaller load first.";
  default:
    return "the sweep could not go on beyond " + std::string(where) + ": " + summary.why + ". The " +
           std::to_string(summary.counts.points) + " points so far are in " + results +
           (exact ? ". Where contacts open, more harmonics help"
                  : ". Where contacts open, harmonic_balance.samples = \"exact\" and more harmonics help") +
           "; or sweep from the other end.";
  }
}

// Everything in force and the forecast sizes, after reading the model once for its checks and analysing its K_ee.
void show(MPI_Comm comm, const Checked &checked, const Voice &voice) {
  const Case &study = checked.study;
  std::string reduction;
  if (study.reduced.empty())
    reduction = forecast_reduction(comm, study);
  else
    read_reduced(comm, study.reduced);
  if (!voice.speaks()) return;
  describe(std::cout, study, checked.contact);
  describe(std::cout, checked.sizes);
  if (!reduction.empty()) std::cout << "  reduction                " << reduction << "\n";
}

// Steps 4 and 5: scaling (theory.md, section 7), then the response curve, point by point into the file and on the
// screen.
BranchSummary follow(const Case &study, PreloadedModel preloaded, ResultsFile &results, Stages &stages,
                     const Voice &voice, double &frequency_scale) {
  const std::string unit = preloaded.reduced.units == "SI" ? "m" : "length";
  HarmonicSystem system = stages.run("4 scaling", [&] {
    const Scales scales = choose_scales(study, preloaded);
    return HarmonicSystem(scaled(std::move(preloaded), study.damping, scales), study.harmonics, study.samples,
                          study.fourier);
  });
  const double w0 = frequency_scale = system.scales().frequency;
  BranchSettings settings{study.omega_from / w0,
                          study.omega_to / w0,
                          study.step,
                          study.adaptive,
                          study.max_points,
                          study.at,
                          -1,
                          0,
                          0,
                          false};
  for (double &w : settings.at) w /= w0;
  std::vector<double> named{study.omega_from, study.omega_to}; // come out as the user wrote them, to the last bit
  named.insert(named.end(), study.at.begin(), study.at.end());
  UniqueVec y = system.unknowns();
  if (!study.start.empty()) start_from(study.start, study.omega_from, system.layout(), system.scales(), y);
  Progress progress(voice.speaks(), system.layout(), unit);
  progress.heading();
  double clock = MPI_Wtime();
  const auto on_point = [&](const BranchPoint &point) {
    const double now = MPI_Wtime();
    PointRecord record = collect(system, point, now - clock);
    for (const double omega : named)
      if (point.omega == omega / w0) record.omega = omega;
    results.append(record);
    progress.point(record);
    clock = now;
  };
  const auto on_event = [&](const BranchEvent &event) { progress.event(event, w0); };
  return stages.run("5 branch", [&] {
    return follow_branch(system, {study.step_tolerance, study.residual_tolerance, study.max_iterations}, settings, y,
                         {on_point, on_event, {}, {}});
  });
}

// The job; ends with summary.json written unless it throws.
void work(MPI_Comm comm, const Checked &checked, bool reduce_only, Stages &stages, const Voice &voice) {
  const Case &study = checked.study;
  const std::filesystem::path own_file = study.directory / "reduced.h5";
  std::optional<ReductionFigures> figures;
  ReducedModel reduced = reduced_model(comm, study, own_file, stages, voice, figures); // eqs (2), (5), (15)-(18)
  const ReductionFigures *reduction = figures ? &*figures : nullptr;
  if (reduce_only) {
    write_summary(comm, study.directory, nullptr, 1, stages, reduction);
    voice.say("reduced model: " + (study.reduced.empty() ? own_file : study.reduced).string());
    return;
  }
  const Range own = reduced.own_points;
  std::string note;
  PreloadedModel preloaded = stages.run("3 preload", [&] { // eq (7)
    return contact_preload(std::move(reduced), {checked.contact.begin() + own.begin, checked.contact.begin() + own.end},
                           {checked.initial.begin() + 3 * own.begin, checked.initial.begin() + 3 * own.end}, note);
  });
  voice.say(note);
  const std::filesystem::path path = study.directory / "results.h5";
  double frequency_scale = 1;
  const auto into_file = [&] { // closed again before anything is made of how it ended
    ResultsFile results(path, study,
                        study.reduced.empty() ? std::filesystem::path("reduced.h5")
                                              : std::filesystem::absolute(study.reduced),
                        preloaded);
    return follow(study, std::move(preloaded), results, stages, voice, frequency_scale);
  };
  const BranchSummary branch = into_file();
  write_summary(comm, study.directory, &branch, frequency_scale, stages, reduction);
  const std::string message = in_words(branch, frequency_scale, path.string(), study.samples == exactly);
  if (!branch.good()) throw ComputeError(message);
  voice.say(message);
  voice.say("results: " + path.string());
}

} // namespace

void run_case(MPI_Comm comm, const Request &request) {
  const Voice voice(comm);
  const Checked checked = check_input(comm, request);
  if (request.dry_run) return show(comm, checked, voice);
  const std::filesystem::path &directory = checked.study.directory;
  on_all_ranks(comm, [&] {
    if (!voice.speaks()) return;
    prepare_output(checked.study);
    std::filesystem::remove(directory /
                            "summary.json"); // those of an earlier run would pass for this one's if it failed
    if (!request.reduce_only) std::filesystem::remove(directory / "results.h5");
  });
  voice.say("dovetail " + std::string(version) + "  " + checked.study.file.string() +
            (checked.study.title.empty() ? "" : ": " + checked.study.title));
  Stages stages;
  try {
    work(comm, checked, request.reduce_only, stages, voice);
  } catch (const std::exception &error) {
    if (voice.speaks()) note_failure(directory, error.what());
    throw;
  }
}

} // namespace dovetail
