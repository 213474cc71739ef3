#include "app/run.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <optional>

#include "app/forecast.hpp"
#include "reduction/elastic_modes.hpp"
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
    if (!study.start.empty()) check_start(study.start, checked.sizes.modes + 3 * checked.sizes.points);
    if (study.reduced.empty()) check_replaceable(study.directory / "reduced.h5");
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

// Which rows of Phi and Psi are kept: those the case asks for; all, if it does not say, while they are few.
struct Motion {
  bool all = false;
  std::vector<PetscInt> dofs; // ascending, if not all
  std::string in_words;       // for the reduced file
};

Motion wanted_motion(const Case &study, PetscInt elastic, PetscInt columns) {
  constexpr double few = 8e6; // numbers, 64 MB
  Motion motion;
  const MotionWish &wish = study.motion;
  motion.all = wish.given ? wish.all : static_cast<double>(elastic) * columns <= few;
  if (!motion.all) motion.dofs = motion_dofs(study.model, wish);
  std::uint64_t hash = 0xcbf29ce484222325u; // FNV-1a
  for (const PetscInt dof : motion.dofs) hash = (hash ^ static_cast<std::uint64_t>(dof)) * 0x100000001b3u;
  motion.in_words = motion.all ? "all" : std::to_string(motion.dofs.size()) + " dofs " + std::to_string(hash);
  return motion;
}

struct Prepared { // for the reduction: parts, what is kept of the fields, and what it will take
  ClampedStructure parts;
  ReductionSettings settings;
  MemoryPlan plan;
};

Prepared prepare(const Case &study, FullModel &&model, const Motion &motion) {
  Prepared prepared;
  prepared.parts = clamp(std::move(model));
  auto &[parts, settings, plan] = prepared;
  settings.modes = study.modes, settings.check_modes = study.check_modes;
  settings.wanted.assign(parts.elastic_dofs.size(), motion.all);
  for (std::size_t i = 0; i < parts.elastic_dofs.size(); ++i)
    if (std::binary_search(motion.dofs.begin(), motion.dofs.end(), parts.elastic_dofs[i])) settings.wanted[i] = 1;
  const auto kept = std::count(settings.wanted.begin(), settings.wanted.end(), 1);
  plan = plan_memory(parts, settings.modes, static_cast<PetscInt>(kept), study.memory * 1024 * 1024 * 1024);
  return prepared;
}

void refuse_too_many_modes(const Case &study, const FullModel &model) {
  const PetscInt elastic = model.dofs - 3 * static_cast<PetscInt>(model.contact_dofs.size());
  if (study.modes > elastic)
    throw InputError(model.file.string() + ": reduction.modes = " + std::to_string(study.modes) +
                     ", but the model has only " + std::to_string(elastic) +
                     " elastic dofs (those not in /contact/dofs): at most so many modes exist");
}

// Steps 1 and 2: the reduced model, from its file if that still fits the case.
ReducedModel reduced_model(MPI_Comm comm, const Checked &checked, const std::filesystem::path &file, Stages &stages,
                           const Voice &voice, std::optional<ReductionFigures> &figures) {
  const Case &study = checked.study;
  if (!study.reduced.empty()) return stages.run("1 model", [&] { return read_reduced(comm, study.reduced); });
  FullModel model = stages.run("1 model", [&] { return read_full_model(comm, study.model); });
  refuse_too_many_modes(study, model);
  const auto points = static_cast<PetscInt>(model.contact_dofs.size());
  Motion motion;
  on_all_ranks(comm, [&] { motion = wanted_motion(study, model.dofs - 3 * points, study.modes + 3 * points); });
  Source source{model.file, model.hash, model.units, study.modes, motion.in_words, "none", model.contact_dofs};
  if (matches(comm, file, source)) {
    voice.say("reduction: " + file.string() + " still fits the model, reused");
    return stages.run("2 reduction", [&] { return read_reduced(comm, file); });
  }
  warn_of_slow_blas(voice);
  voice.say("reduction: " + std::to_string(model.dofs) + " dofs, " + std::to_string(points) + " contact points, " +
            std::to_string(study.modes) + " modes");
  return stages.run("2 reduction", [&] {
    Prepared prepared = stages.run("2a analysis", [&] { return prepare(study, std::move(model), motion); });
    char work[64] = "";
    double flops = 0;
    if (prepared.parts.solver) {
      source.ordering = prepared.parts.solver->ordering();
      flops = prepared.parts.solver->forecast_flops();
      std::snprintf(work, sizeof work, ", %.3g operations to factor", flops);
    }
    voice.say("  ordering " + source.ordering + work);
    voice.say("  memory " + in_words(prepared.plan));
    refuse_if_too_large(prepared.parts, prepared.plan);
    Reduction reduction = craig_bampton(std::move(prepared.parts), prepared.settings, prepared.plan, stages);
    stages.run("2h writing", [&] { write_reduced(file, source, reduction); });
    char line[160];
    if (study.modes > 0) {
      std::snprintf(line, sizeof line, "  fixed-interface frequencies %.6g .. %.6g Hz%s",
                    std::sqrt(reduction.model.kaa[0]) / (2 * M_PI), std::sqrt(reduction.model.kaa.back()) / (2 * M_PI),
                    study.check_modes ? ", none missed" : " (reduction.check_modes = true counts them)");
      voice.say(line);
    }
    if (!motion.all && !study.motion.given)
      voice.say("  the fields are large: only contact points and modes are kept; output.motion names more");
    figures = ReductionFigures{source.ordering, flops, prepared.plan.bytes / (1 << 20), reduction.backward_error,
                               prepared.plan.keep_psi};
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

// Everything in force and the forecast sizes, after reading the model once for its checks and analysing its K_ee.
void show(MPI_Comm comm, const Checked &checked, const Voice &voice) {
  const Case &study = checked.study;
  std::string reduction;
  if (study.reduced.empty()) {
    FullModel model = read_full_model(comm, study.model);
    refuse_too_many_modes(study, model);
    Motion motion;
    const PetscInt contacts = 3 * static_cast<PetscInt>(model.contact_dofs.size());
    on_all_ranks(comm, [&] { motion = wanted_motion(study, model.dofs - contacts, study.modes + contacts); });
    const Prepared prepared = prepare(study, std::move(model), motion);
    refuse_if_too_large(prepared.parts, prepared.plan);
    reduction = in_words(prepared.plan);
  } else {
    read_reduced(comm, study.reduced);
  }
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
  BranchSettings settings{study.omega_from / w0, study.omega_to / w0, study.step,
                          study.adaptive,        study.max_points,    study.at};
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
                         {on_point, on_event});
  });
}

// The job; ends with summary.json written unless it throws.
void work(MPI_Comm comm, const Checked &checked, bool reduce_only, Stages &stages, const Voice &voice) {
  const Case &study = checked.study;
  const std::filesystem::path own_file = study.directory / "reduced.h5";
  std::optional<ReductionFigures> figures;
  ReducedModel reduced = reduced_model(comm, checked, own_file, stages, voice, figures); // eqs (2), (5), (15)-(18)
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
  const std::string message = in_words(branch, frequency_scale, path.string());
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
