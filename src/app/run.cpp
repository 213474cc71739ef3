#include "app/run.hpp"

#include "app/choose_modes.hpp"
#include "app/ending.hpp"
#include "app/follow.hpp"
#include "app/follow_mode.hpp"
#include "app/hosts.hpp"
#include "app/looks.hpp"
#include "app/own_files.hpp"
#include "app/tell_sectors.hpp"
#include "case/restart.hpp"
#include "support/blas_kernel.hpp"
#include "support/signals.hpp"
#include "support/version.hpp"

namespace dovetail {
namespace {

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
