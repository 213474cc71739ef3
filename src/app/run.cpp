#include "app/run.hpp"

#include <memory>
#include <optional>
#include <sstream>

#include "app/check.hpp"
#include "app/choose_modes.hpp"
#include "app/earlier_run.hpp"
#include "app/ending.hpp"
#include "app/follow.hpp"
#include "app/follow_mode.hpp"
#include "app/forecast.hpp"
#include "app/hosts.hpp"
#include "app/own_files.hpp"
#include "app/tell_resonances.hpp"
#include "app/tell_sectors.hpp"
#include "case/number_text.hpp"
#include "case/restart.hpp"
#include "support/blas_kernel.hpp"
#include "support/folder_lock.hpp"
#include "support/signals.hpp"
#include "support/version.hpp"

namespace dovetail {
namespace {

constexpr const char *another_folder = "name another folder with output.directory or --out";

// Case, sizes and contact law: all that can be wrong in the input short of the matrices themselves.
struct Checked {
  Case study;
  Forecast sizes;
  std::vector<ContactPoint> contact;          // all points
  std::vector<double> initial;                // (3 N_x) [m]
  PetscInt dofs = 0;                          // of the reduced model
  PetscInt most_modes = 0;                    // that it may have, where a tolerance decides
  int sectors = 0;                            // of the whole, if the model is one
  bool has_c = false, has_structural = false; // damping matrices of the model
  Units units;
  std::optional<SavedRun> earlier; // the run to be continued
  bool has_results = false;        // on rank 0: results.h5 is this run's
};

Checked check_input(MPI_Comm comm, const Request &request) {
  Checked checked;
  on_all_ranks(comm, [&] {
    checked.study = read_case(request.file, request.out);
    Case &study = checked.study;
    ContactSettings from_model;
    const bool is_excited = !request.reduce_only && !request.modes_only;
    int &sectors = checked.sectors;
    if (study.reduced.empty()) {
      ModelHeader header = read_model_header(study.model);
      from_model = header.contact;
      if (study.modes_by_tolerance) first_modes(study, checked.most_modes = most_modes(study, header));
      check_patterns(study, header.forces, study.model);
      checked.units = units_of(header.units);
      settle_cyclic(study, sectors = header.sectors, header.has_structural, is_excited);
      if (!study.watch.node.empty()) node_motion(study.model, study.watch);
      settle_solver(study, static_cast<int>(study.modes + 3 * header.points));
      checked.sizes = forecast(header, study);
      checked.has_c = header.has_c, checked.has_structural = header.has_structural;
    } else {
      const ReducedHeader header = read_reduced_header(study.reduced);
      check_patterns(study, header.loads, study.reduced);
      from_model.area = header.area;
      checked.units = units_of(header.units);
      settle_cyclic(study, sectors = header.sectors, header.has_structural, is_excited);
      settle_solver(study, static_cast<int>(header.modes + 3 * header.points));
      checked.sizes = forecast(header, study);
      checked.has_c = header.has_c, checked.has_structural = header.has_structural;
    }
    settle_units(study, checked.units);
    const auto [modes, points] = std::pair(int(checked.sizes.modes), int(checked.sizes.points));
    if (modes + points == 0)
      throw InputError(study.given.at("reduction.modes") + ": reduction.modes = 0: " + study.model.string() +
                       " has no contact points, so modes are all that can move; write at least 1");
    settle_stability(study, modes + 3 * points);
    check_damping(study, modes, points, checked.has_c);
    watched_dof(study, modes, points);
    if (!study.start.empty()) check_start(study.start, modes + 3 * points, study.wave(sectors));
    // A file that another run is writing may look damaged.
    if (!request.dry_run && !request.check_only) FolderLock::refuse_held(study.directory, another_folder);
    refuse_foreign_files(study, request.reduce_only || request.modes_only);
    if (study.reduced.empty()) check_replaceable(study.directory / "reduced.h5");
    checked.contact = contact_points(study.contact, from_model, points);
    settle_path(study, from_model, points);
    check_path(study, checked.contact);
    checked.initial = initial_preload(study, points);
    checked.dofs = modes + 3 * points;
  });
  if (request.restart) {
    refuse_unshared_file(comm, state_of(checked.study));
    on_all_ranks(comm, [&] { checked.earlier = earlier_run(checked.study, checked.contact, checked.dofs); });
  }
  return checked;
}

int ranks_of(MPI_Comm comm) {
  int ranks;
  MPI_Comm_size(comm, &ranks);
  return ranks;
}

// The folder is this run's from here on, or another's, which is told. On rank 0; nothing on the others.
std::unique_ptr<FolderLock> take_folder(MPI_Comm comm, const Case &study, const Voice &voice) {
  std::unique_ptr<FolderLock> lock;
  on_all_ranks(comm, [&] {
    if (!voice.speaks()) return;
    prepare_output(study);
    lock = std::make_unique<FolderLock>(study.directory, another_folder);
    voice.say(lock->note());
  });
  if (ranks_of(comm) > 1) refuse_unshared(comm, study.directory, lock ? lock->published() : "");
  return lock;
}

// What hysteretic damping leaves out, and damping of the model that is not taken; or nothing.
std::vector<std::string> notes_on_damping(const Checked &checked) {
  const Damping &damping = checked.study.damping;
  std::vector<std::string> notes;
  if (!damping.acts_in_time())
    notes.push_back(
        "damping.structural: stability is not judged, and nothing is integrated in time; hysteretic damping "
        "has no motion in time");
  const std::string no_such = "on a sector of a cyclic structure none is taken yet";
  const auto left_out = [&](const std::string &matrix, const std::string &remedy) {
    notes.push_back("note: the model's " + matrix + " is left out; " + (checked.sectors > 0 ? no_such : remedy));
  };
  if (checked.has_c && !damping.matrix) left_out("viscous damping matrix", "damping.matrix = true takes it");
  if (checked.has_structural && damping.structural == 0)
    left_out("structural matrix", "damping.structural is the loss factor it wants");
  return notes;
}

std::string in_words(const SavedRun &earlier, const Case &study) {
  const CurveRange range = study.range();
  return "restart: goes on at " + range.text(place_of(study, earlier)) + " after " +
         std::to_string(earlier.branch.counts.points) + " points";
}

// The state the vibration starts from (eq 7), told if it took more than plain Newton.
PreloadedModel preload(const Checked &checked, ReducedModel reduced, const Voice &voice) {
  const Range own = reduced.own_points;
  std::string note;
  PreloadedModel preloaded =
      contact_preload(std::move(reduced), {checked.contact.begin() + own.begin, checked.contact.begin() + own.end},
                      {checked.initial.begin() + 3 * own.begin, checked.initial.begin() + 3 * own.end}, note);
  voice.say(note);
  return preloaded;
}

std::vector<Warning> say(const Resonances &found, const Case &study, const Voice &voice) {
  for (const std::string &line : in_lines(found, study)) voice.say(line);
  const std::vector<Warning> warnings = warnings_of(found, study);
  for (const Warning &warning : warnings) voice.warn(warning);
  return warnings;
}

// Of a dry run, which takes a preload without equilibrium for no error.
void show_resonances(const Checked &checked, std::optional<ReducedModel> reduced, const Voice &voice) {
  if (!reduced) return voice.say("resonances come with the reduction: dovetail modes, reduce or run");
  if (reduced->sectors > 0) return;
  try {
    const PreloadedModel preloaded = preload(checked, std::move(*reduced), voice);
    if (const auto found = try_resonances(preloaded, checked.study, voice)) say(*found, checked.study, voice);
  } catch (const ComputeError &error) {
    voice.say("resonances: not known, " + text_of(error));
  }
}

// Everything in force and the forecast sizes, after reading the model once for its checks and analysing its K_ee.
void show(MPI_Comm comm, const Checked &checked, const Voice &voice) {
  const Case &study = checked.study;
  std::string reduction;
  std::optional<ReducedModel> reduced;
  if (study.reduced.empty())
    reduction = forecast_reduction(comm, study, study.directory / "reduced.h5", reduced);
  else
    reduced = given_reduced_model(comm, study);
  if (voice.speaks()) {
    std::ostringstream in_force;
    describe(in_force, study, checked.contact, checked.units);
    describe(in_force, checked.sizes);
    if (!reduction.empty()) in_force << "  reduction                " << reduction << "\n";
    for (const std::string &note : notes_on_damping(checked)) in_force << note << "\n";
    if (checked.earlier) in_force << in_words(*checked.earlier, study) << "\n";
    log_line("%s", in_force.str().c_str());
  }
  for (const Warning &warning : warnings_of_wave(study, checked.sectors)) voice.warn(warning);
  show_resonances(checked, std::move(reduced), voice);
}

// `dovetail check`: what a dry run refuses, and what is doubtful. As there a reduced model is used if it is at hand.
void check_case(MPI_Comm comm, const Checked &checked, const Voice &voice) {
  const Case &study = checked.study;
  std::vector<Warning> found = doubts_of_case(study, checked.contact, ranks_of(comm));
  const auto add = [&](const std::vector<Warning> &more) { // what is told already is not told again by other means
    const std::vector<Warning> before = found;
    for (const Warning &one : more)
      if (std::none_of(before.begin(), before.end(), [&](const Warning &told) { return told.kind == one.kind; }))
        found.push_back(one);
  };
  std::optional<ReducedModel> reduced;
  if (study.reduced.empty())
    forecast_reduction(comm, study, study.directory / "reduced.h5", reduced,
                       [&](const FullModel &model) { add(doubts_of_model(model, study, checked.contact)); });
  else
    reduced = given_reduced_model(comm, study);
  const bool is_reduced = reduced.has_value();
  if (is_reduced) add(doubts_of_reduced(*reduced, study, checked.contact));
  add(warnings_of_wave(study, checked.sectors));
  for (const std::string &note : notes_on_damping(checked)) voice.say(note);
  if (is_reduced && reduced->sectors == 0) {
    try {
      const PreloadedModel preloaded = preload(checked, std::move(*reduced), voice);
      if (const auto resonances = try_resonances(preloaded, study, voice)) add(warnings_of(*resonances, study));
    } catch (const ComputeError &error) {
      found.push_back({"no_equilibrium", text_of(error)});
    }
  }
  for (const Warning &one : found) voice.warn({one.kind, one.text + "\n  docs/how-to/check-a-case.md#" + one.kind});
  voice.say(
      study.file.string() + ": " +
      (found.empty() ? "no warnings" : std::to_string(found.size()) + (found.size() > 1 ? " warnings" : " warning")) +
      (is_reduced ? "" : "; resonances and the load are looked at too once the model is reduced: dovetail reduce"));
}

// `dovetail modes`: of earlier runs in the folder it replaces nothing but a reduced file that no longer fits.
void show_modes(MPI_Comm comm, const Checked &checked, const Voice &voice) {
  const Case &study = checked.study;
  Stages stages;
  std::optional<ReductionFigures> figures;
  const auto lock = study.reduced.empty() ? take_folder(comm, study, voice) : nullptr;
  ReducedModel reduced = reduced_model(comm, study, study.directory / "reduced.h5", stages, voice, figures, false);
  const std::filesystem::path file = study.reduced.empty() ? study.model : study.reduced;
  reduced.file = file;
  const PreloadedModel preloaded = preload(checked, std::move(reduced), voice);
  const Resonances found = resonances(preloaded, study);
  if (!found.known) throw InputError(mass_not_positive(file));
  if (preloaded.reduced.sectors > 0) voice.say("nodal diameter 0, motions alike on all sectors:");
  voice.say(in_table(found, study));
  if (preloaded.reduced.sectors > 0) {
    voice.say(in_table("\nclosed points stuck [Hz]", stuck_frequencies(preloaded, listed_frequencies), checked.units));
    voice.say(in_table("\ncontact points held [Hz]", held_frequencies(preloaded.reduced), checked.units));
    for (const Warning &warning : warnings_of_wave(study, preloaded.reduced.sectors)) voice.warn(warning);
    return; // what else is warned of would be of nodal diameter 0 alone
  }
  for (const Warning &warning : warnings_of(found, study)) voice.warn(warning);
}

// Warns of what the curve shows, and of that alone: the rest was said before it.
void judge(MPI_Comm comm, const Checked &checked, BranchStory &story, const Voice &voice) {
  std::vector<Warning> found;
  on_all_ranks(comm, [&] {
    if (voice.speaks())
      found = warnings_of_curve(story.resonances, checked.study, checked.contact, story.summary.good());
  });
  for (const Warning &warning : found) voice.warn(warning);
  story.warnings.insert(story.warnings.end(), found.begin(), found.end());
}

// The job; ends with summary.json written unless it throws.
void work(MPI_Comm comm, Checked &checked, bool reduce_only, Stages &stages, StatusFile &status, const Voice &voice) {
  Case &study = checked.study;
  const SavedRun *earlier = checked.earlier ? &*checked.earlier : nullptr;
  const std::filesystem::path own_file = study.directory / "reduced.h5";
  std::optional<ReductionFigures> figures;
  ReducedModel reduced = // eqs (2), (5), (15)-(18)
      study.modes_by_tolerance && !earlier && !reduce_only
          ? reduced_to_tolerance(comm, study, checked.most_modes, own_file, checked.contact, checked.initial, stages,
                                 voice, figures)
          : reduced_model(comm, study, own_file, stages, voice, figures, !reduce_only);
  const ReductionFigures *reduction = figures ? &*figures : nullptr;
  if (reduce_only) {
    const bool alone = !std::filesystem::exists(results_of(study)); // else the summary is of those
    write_summary(comm, alone ? study.directory : "", nullptr, stages, reduction);
    voice.say("reduced model: " + (study.reduced.empty() ? own_file : study.reduced).string());
    return;
  }
  reduced.stuck_file = study.directory / "stuck.h5";
  reduced.file = study.reduced.empty() ? study.model : study.reduced;
  PreloadedModel preloaded =
      stages.run("3 preload", [&] { return preload(checked, std::move(reduced), voice); }); // eq (7)
  SectorFrequencies by_diameter; // of a sector, whose resonances differ with the nodal diameter
  const std::optional<Resonances> found = stages.run("3a resonances", [&]() -> std::optional<Resonances> {
    if (preloaded.reduced.sectors == 0) return try_resonances(preloaded, study, voice);
    by_diameter = stuck_frequencies(preloaded, listed_frequencies);
    voice.say(in_table("closed points stuck [Hz]", by_diameter, checked.units));
    return {};
  });
  std::vector<Warning> warnings;
  if (found) warnings = say(*found, study, voice);
  for (const Warning &warning : warnings_of_wave(study, preloaded.reduced.sectors)) {
    voice.warn(warning);
    warnings.push_back(warning);
  }
  if (study.follows_peaks())
    check_memory(comm, checked.sizes, "following a peak factors two matrices",
                 "fewer harmonics, or fewer modes, take less");
  std::optional<StuckMode> mode;
  if (study.mode) {
    if (study.solver == SolverKind::assembled)
      check_memory(comm, checked.sizes, "a mode factors its matrix",
                   "harmonic_balance.solver = \"modal\", or fewer harmonics, take less");
    mode = stages.run("3b mode", [&] { return stuck_mode(preloaded, study); });
  }
  SavedRun begin = earlier ? *earlier : SavedRun{};
  if (!earlier) begin.run = new_run_name();
  begin.problem = problem_of(study, checked.contact), begin.limits = limits_of(study), begin.end.clear();
  if (earlier) ++begin.parts;
  only_note_signals();
  const auto into_file = [&] { // closed again before anything is made of how it ended
    ResultsFile results(results_of(study), begin.run, study,
                        study.reduced.empty() ? std::filesystem::path("reduced.h5")
                                              : std::filesystem::absolute(study.reduced),
                        preloaded,
                        earlier ? ResultsFile::Kept{hsize_t(earlier->branch.counts.points), hsize_t(earlier->events)}
                                : ResultsFile::Kept{},
                        [&] {
                          if (!earlier) make_room(study);
                          std::filesystem::remove(study.directory / "summary.json"); // would pass for this run's
                          checked.has_results = true;
                        });
    if (!by_diameter.empty()) results.describe(by_diameter);
    Followed followed =
        mode
            ? follow_mode(study, std::move(preloaded), *mode, results, earlier, std::move(begin), stages, status, voice)
            : follow(study, std::move(preloaded), results, earlier, std::move(begin), stages, status, voice);
    followed.kept = results.finish();
    return followed;
  };
  Followed followed = into_file();
  BranchStory &story = followed.story;
  story.resonances = found;
  story.warnings.insert(story.warnings.begin(), warnings.begin(), warnings.end());
  if ((followed.kept || earlier) && !mode) judge(comm, checked, story, voice);
  write_summary(comm, followed.kept || earlier ? study.directory : "", &story, stages, reduction);
  const bool cut_off = story.summary.end == BranchSummary::End::interrupted;
  followed.keeper.finish(cut_off ? "" : name_of(story.summary.end)); // last: ended, nothing is missing
  const std::string message =
      in_words(story.summary, study, story.scale, followed.signal) +
      (followed.kept ? "" : "; the results of the run before stay in " + results_of(study).string());
  if (!story.summary.good()) throw ComputeError(message);
  voice.say(message);
  voice.say("results: " + results_of(study).string(), "end", member("end", quoted(name_of(story.summary.end))));
}

} // namespace

void run_case(MPI_Comm comm, const Request &request) {
  const Voice voice(comm);
  Checked checked = check_input(comm, request);
  const Case &study = checked.study;
  if (request.dry_run) return show(comm, checked, voice);
  if (request.check_only) return check_case(comm, checked, voice);
  if (request.modes_only) return show_modes(comm, checked, voice);
  const auto done = [&] {
    if (!checked.earlier || !nothing_left(study, *checked.earlier)) return false;
    voice.say("nothing to do: this run ended well (" + checked.earlier->end +
              "), and the case asks for no more; results: " + results_of(study).string());
    return true;
  };
  if (done()) return;
  const auto lock = take_folder(comm, study, voice);
  if (request.restart) { // again: it may have gone on, and ended, since it was looked at
    on_all_ranks(comm, [&] { checked.earlier = earlier_run(study, checked.contact, checked.dofs); });
    if (done()) return;
  }
  on_all_ranks(comm, [&] {
    if (!voice.speaks()) return;
    if (!request.reduce_only && !request.restart) look_around(study, voice);
  });
  voice.say("dovetail " + std::string(version) + "  " + study.file.string() +
            (study.title.empty() ? "" : ": " + study.title));
  if (blas_kernel().worth_saying()) voice.say("OpenBLAS kernel: " + in_words(blas_kernel()));
  voice.say(note_on_cores(comm));
  voice.say(note_on_arithmetic(comm));
  const std::string idle =
      request.reduce_only ? "" : idle_ranks(ranks_of(comm), static_cast<int>(checked.contact.size()));
  if (!idle.empty()) voice.say("note: " + idle);
  if (checked.earlier) voice.say(in_words(*checked.earlier, study));
  for (const std::string &note : notes_on_damping(checked)) voice.say(note);
  StatusFile status(voice.speaks() ? study.directory : std::filesystem::path());
  Stages stages;
  stages.begins = [&](const char *name) {
    status.stage(name);
    if (logs_json()) voice.say(name, "stage");
  };
  try {
    work(comm, checked, request.reduce_only, stages, status, voice);
  } catch (const std::exception &error) {
    if (voice.speaks() && (checked.has_results || !std::filesystem::exists(results_of(study))))
      note_failure(study.directory, text_of(error));
    throw;
  }
}

} // namespace dovetail
