#include "app/looks.hpp"

#include <sstream>

#include "app/check.hpp"
#include "app/choose_modes.hpp"
#include "app/hosts.hpp"
#include "app/tell_sectors.hpp"

namespace dovetail {
namespace {

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

} // namespace

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

} // namespace dovetail
