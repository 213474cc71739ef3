#include "app/preparation.hpp"

#include "app/check.hpp"
#include "app/choose_modes.hpp"
#include "app/hosts.hpp"
#include "app/own_files.hpp"
#include "case/restart.hpp"

namespace dovetail {
namespace {

constexpr const char *another_folder = "name another folder with output.directory or --out";

} // namespace

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

} // namespace dovetail
