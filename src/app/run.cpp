#include "app/run.hpp"

#include <dlfcn.h>

#include <cmath>
#include <cstdio>
#include <iostream>
#include <optional>

#include "app/forecast.hpp"
#include "results/progress.hpp"
#include "results/summary.hpp"
#include "support/version.hpp"

namespace dovetail {
namespace {

class Voice { // rank 0 speaks
public:
  explicit Voice(MPI_Comm comm) { MPI_Comm_rank(comm, &rank_); }
  bool speaks() const { return rank_ == 0; }
  void say(const std::string &line) const {
    if (!speaks() || line.empty()) return;
    std::printf("%s\n", line.c_str());
    std::fflush(stdout);
  }

private:
  int rank_ = 0;
};

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
    checked.contact = contact_points(study.contact, from_model, static_cast<int>(checked.sizes.points));
    checked.initial = initial_preload(study, static_cast<int>(checked.sizes.points));
  });
  return checked;
}

void warn_of_slow_blas(const Voice &voice) {
  for (const char *known : {"openblas_get_config", "MKL_Get_Version", "bli_info_get_version_str", "armpl_get_version"})
    if (dlsym(RTLD_DEFAULT, known)) return;
  voice.say("note: this looks like reference BLAS, with which factorisations take about 8 times longer; on Debian "
            "install libopenblas0-serial");
}

// Steps 1 and 2: the reduced model, from its file if that still fits the case.
ReducedModel reduced_model(MPI_Comm comm, const Checked &checked, const std::filesystem::path &file, Stages &stages,
                           const Voice &voice) {
  const Case &study = checked.study;
  if (!study.reduced.empty()) return stages.run("1 model", [&] { return read_reduced(comm, study.reduced); });
  const FullModel model = stages.run("1 model", [&] { return read_full_model(comm, study.model); });
  if (matches(file, model, study.modes)) {
    voice.say("reduction: " + file.string() + " still fits the model, reused");
    return stages.run("2 reduction", [&] { return read_reduced(comm, file); });
  }
  warn_of_slow_blas(voice);
  voice.say("reduction: " + std::to_string(model.dofs) + " dofs, " + std::to_string(model.contact_dofs.size()) +
            " contact points, " + std::to_string(study.modes) + " modes ...");
  return stages.run("2 reduction", [&] {
    Reduction reduction = craig_bampton(model, study.modes);
    write_reduced(file, model, reduction);
    std::string first;
    if (study.modes > 0)
      first =
          ", first fixed-interface frequency " + std::to_string(std::sqrt(reduction.model.kaa[0]) / (2 * M_PI)) + " Hz";
    voice.say("reduction: ordering " + (reduction.ordering.empty() ? "none needed" : reduction.ordering) + first);
    return std::move(reduction.model);
  });
}

std::string in_words(const BranchSummary &summary, double frequency_scale, const std::string &results) {
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
           std::to_string(summary.points) + " points so far are in " + results +
           ". Where contacts open, more samples (harmonic_balance.samples) and more harmonics help; or sweep from the "
           "other end.";
  }
}

} // namespace

int run_case(MPI_Comm comm, const Request &request) {
  const Voice voice(comm);
  const Checked checked = check_input(comm, request);
  const Case &study = checked.study;
  if (request.dry_run) {
    if (study.reduced.empty())
      read_full_model(comm, study.model); // for its checks: symmetry, finite numbers, sizes
    else
      read_reduced(comm, study.reduced);
    if (voice.speaks()) {
      describe(std::cout, study, checked.contact);
      describe(std::cout, checked.sizes);
    }
    return 0;
  }
  on_all_ranks(comm, [&] {
    if (voice.speaks()) prepare_output(study);
  });
  Stages stages;
  std::optional<BranchSummary> branch;
  const auto summarise = [&](double scale, const std::string &failure) {
    write_summary(comm, study.directory, branch ? &*branch : nullptr, scale, stages, failure);
  };
  voice.say("dovetail " + std::string(version) + "  " + study.file.string() +
            (study.title.empty() ? "" : ": " + study.title));

  const std::filesystem::path own_file = study.directory / "reduced.h5";
  ReducedModel reduced = reduced_model(comm, checked, own_file, stages, voice); // eqs (2), (5), (15)-(18)
  if (request.reduce_only) {
    summarise(1, "");
    voice.say("reduced model: " + (study.reduced.empty() ? own_file : study.reduced).string());
    return 0;
  }

  const Range own = reduced.own_points;
  const std::string unit = reduced.units == "SI" ? "m" : "length";
  std::string note;
  PreloadedModel preloaded = stages.run("3 preload", [&] { // eq (7)
    return contact_preload(std::move(reduced), {checked.contact.begin() + own.begin, checked.contact.begin() + own.end},
                           {checked.initial.begin() + 3 * own.begin, checked.initial.begin() + 3 * own.end}, note);
  });
  voice.say(note);
  const std::filesystem::path results_path = study.directory / "results.h5";
  ResultsFile results(results_path, study,
                      study.reduced.empty() ? std::filesystem::path("reduced.h5")
                                            : std::filesystem::absolute(study.reduced),
                      preloaded);

  HarmonicSystem system = stages.run("4 scaling", [&] { // theory.md, section 7
    const Scales scales = choose_scales(study, preloaded);
    return HarmonicSystem(scaled(std::move(preloaded), study.damping, scales), study.harmonics, study.samples,
                          study.fourier);
  });

  const double w0 = system.scales().frequency;
  BranchSettings settings{study.omega_from / w0, study.omega_to / w0, study.step,
                          study.adaptive,        study.max_points,    study.at};
  for (double &w : settings.at) w /= w0;
  UniqueVec y = system.unknowns();
  if (!study.start.empty()) start_from(study.start, study.omega_from, system.layout(), system.scales(), y);
  Progress progress(voice.speaks(), system.layout(), unit);
  progress.heading();
  double clock = MPI_Wtime();
  const BranchObserver observer{[&](const BranchPoint &point) {
                                  const double now = MPI_Wtime();
                                  PointRecord record = collect(system, point, now - clock);
                                  // the frequencies the user named come out as he wrote them
                                  for (const double *named : {&study.omega_from, &study.omega_to})
                                    if (point.omega == *named / w0) record.omega = *named;
                                  for (const double named : study.at)
                                    if (point.omega == named / w0) record.omega = named;
                                  results.append(record);
                                  progress.point(record);
                                  clock = now;
                                },
                                [&](const BranchEvent &event) { progress.event(event, w0); }};
  branch = stages.run("5 branch", [&] {
    return follow_branch(system, {study.step_tolerance, study.residual_tolerance, study.max_iterations}, settings, y,
                         observer);
  });
  const std::string message = in_words(*branch, w0, results_path.string());
  const bool good = branch->end == BranchSummary::End::arrived || branch->end == BranchSummary::End::max_points;
  summarise(w0, good ? "" : message);
  if (!good) throw ComputeError(message);
  voice.say(message);
  voice.say("results: " + results_path.string());
  return 0;
}

} // namespace dovetail
