#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>

#include "case/case.hpp"
#include "case/contact_settings.hpp"
#include "case/damping_settings.hpp"
#include "case/document.hpp"
#include "case/keys.hpp"
#include "case/load_settings.hpp"
#include "case/mode_settings.hpp"
#include "case/path_settings.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

namespace fs = std::filesystem;

constexpr int first_harmonics = 3;  // where a tolerance chooses them
constexpr double narrowest = 1e-12; // sweep, of its frequency: steps of a hundredth are some 50 numbers wide

std::string text_of(const fs::path &file) {
  std::error_code error;
  if (fs::is_directory(file, error))
    throw InputError(file.string() + ": is a folder; write the case file in it, as " + (file / "case.toml").string());
  if (!fs::exists(file, error)) throw InputError(file.string() + ": there is no such case file");
  std::ifstream stream(file, std::ios::binary);
  std::string text(4096, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(stream.gcount()));
  if (stream.bad() || (!stream && !stream.eof())) throw InputError(file.string() + ": the case file cannot be read");
  // A model file handed over by mistake may be huge: its beginning is enough to tell.
  if (text.find('\0') != std::string::npos)
    throw InputError(file.string() + ": is not a text file; write a case file, case.toml");
  if (stream) text += std::string(std::istreambuf_iterator<char>(stream), {});
  if (text.rfind("\xEF\xBB\xBF", 0) == 0) text.erase(0, 3); // a mark of the encoding, which readers of results refuse
  return text;
}

// Each of these leaves `target` at its default where the key is absent.

void read_number(const Entry &entry, double &target) {
  if (entry) target = entry.number();
}

void read_whole(const Entry &entry, int &target) {
  if (entry) target = entry.whole();
}

void read_truth(const Entry &entry, bool &target) {
  if (entry) target = entry.truth();
}

/// An existing file, relative to the folder of the case file. The run must not overwrite what it reads.
void read_input_file(const Entry &entry, const Case &study, fs::path &target) {
  if (!entry) return;
  target = study.file.parent_path() / entry.words();
  std::error_code error;
  if (!fs::exists(target, error)) entry.refuse("there is no file " + target.string());
  if (!fs::is_regular_file(target, error)) entry.refuse(target.string() + " is not a file");
  if (!std::ifstream(target)) entry.refuse(target.string() + " cannot be read");
  for (const std::string written :
       {"results.h5", "reduced.h5", "state.h5", "stuck.h5", "summary.json", "status.json", "results.h5.partial",
        "reduced.h5.partial", "state.h5.partial", "status.json.partial", "dovetail.lock"})
    if (fs::equivalent(target, study.directory / written, error) &&
        !(&target == &study.reduced && written == "reduced.h5"))
      entry.refuse("the run would overwrite this file with its own " + written +
                   "; name another output.directory, or give --out");
}

void read_output(const Document &document, const fs::path &out, Case &study) {
  const Entry directory = document["output.directory"];
  const fs::path here = study.file.parent_path();
  study.directory = directory ? here / directory.words() : here.empty() ? "." : here;
  if (out.empty()) return;
  study.directory = out;
  study.given["output.directory"] = "--out";
}

void read_model(const Document &document, Case &study) {
  const Entry model = document["model"], reduced = document["reduced"], modes = document["reduction.modes"];
  if (!model && !reduced) document.missing("model", "model = \"model.h5\", or reduced = \"reduced.h5\",");
  if (model && reduced)
    reduced.refuse("model is given as well, in line " + std::to_string(model.line()) + "; keep one of the two");
  read_input_file(model, study, study.model);
  read_input_file(reduced, study, study.reduced);
  if (reduced && modes) modes.refuse("the reduced file has its own modes; delete this key");
  study.modes_by_tolerance = model && !modes;
  if (study.modes_by_tolerance && !document["accuracy.tolerance"])
    document.missing("reduction.modes", "modes = 10, or [accuracy] tolerance = 1e-3,");
  if (const Entry start = document["continuation.start"]; start && study.modes_by_tolerance)
    start.refuse(
        "holds motions of so many modes: give reduction.modes and reduction.kind as they were, or delete this key");
  read_whole(modes, study.modes);
  const Entry kind = document["reduction.kind"];
  study.residuals = kind ? kind.word() == "residual" : study.modes_by_tolerance;
  for (const char *key : {"reduction.kind", "reduction.interior_modes", "reduction.exact_modes",
                          "reduction.check_modes", "reduction.memory", "output.motion"})
    if (const Entry entry = document[key]; reduced && entry) entry.refuse("needs a full model; delete this key");
  read_truth(document["reduction.exact_modes"], study.exact_modes);
  read_whole(document["reduction.interior_modes"], study.interior_modes);
  read_truth(document["reduction.check_modes"], study.check_modes);
  read_number(document["reduction.memory"], study.memory);
}

void read_motion(const Document &document, Case &study) {
  const Entry motion = document["output.motion"];
  if (!motion) return;
  MotionWish &wish = study.motion;
  wish.given = true, wish.where = motion.where();
  if (!motion.is_list()) {
    if (!motion.is_words() || motion.words() != "all")
      motion.refuse("must be \"all\", or a list of node sets and node numbers such as [\"tip\", 12]; [] for none");
    wish.all = true;
    return;
  }
  for (const Entry &item : motion.items())
    if (item.is_words())
      wish.sets.push_back(item.words());
    else
      wish.nodes.push_back(item.whole());
}

void read_harmonic_balance(const Document &document, Case &study) {
  const Entry harmonics = document["harmonic_balance.harmonics"], samples = document["harmonic_balance.samples"];
  const Entry tolerance = document["accuracy.tolerance"], estimates = document["accuracy.estimates"];
  read_number(tolerance, study.tolerance);
  if (tolerance) study.between = study.tolerance;
  read_number(document["accuracy.between"], study.between);
  read_truth(estimates, study.estimates);
  if (tolerance && !study.estimates) estimates.refuse("a tolerance cannot do without; delete this key");
  if (tolerance && harmonics) harmonics.refuse("accuracy.tolerance chooses the harmonics; delete one of the two keys");
  if (!tolerance && !harmonics)
    document.missing("harmonic_balance.harmonics", "harmonics = 5, or [accuracy] tolerance = 1e-3,");
  study.harmonics = first_harmonics;
  read_whole(harmonics, study.harmonics);

  if (const Entry solver = document["harmonic_balance.solver"])
    study.solver = solver.word() == "modal" ? SolverKind::modal : SolverKind::assembled;
  if (!samples) return;
  if (samples.is_words()) {
    samples.word(", or a number of samples per period");
    return;
  }
  if (tolerance) samples.refuse("accuracy.tolerance takes exact contact forces; delete one of the two keys");
  const int least = 2 * study.harmonics + 1;
  study.samples = samples.whole();
  if (study.samples < least)
    throw InputError(samples.where() + " = " + samples.source() +
                     " is too small for harmonics = " + std::to_string(study.harmonics) + ": at least 2*" +
                     std::to_string(study.harmonics) + "+1 = " + std::to_string(least));
}

void read_preload(const Document &document, Case &study) {
  const Entry initial = document["preload.initial"];
  if (!initial) return;
  study.preload_initial = initial.is_list() ? initial.numbers() : std::vector<double>{initial.number()};
  study.preload_initial_where = initial.where();
  if (initial.is_list() && (study.preload_initial.empty() || study.preload_initial.size() % 3 != 0))
    initial.refuse(std::to_string(study.preload_initial.size()) +
                   " values; write one number without brackets, or 3 per contact point (t1, t2, n)");
}

void read_scaling(const Document &document, Case &study) {
  const Entry kind = document["scaling.kind"];
  if (kind) {
    const std::string word = kind.word();
    study.scaling = word == "auto" ? ScalingKind::automatic : word == "none" ? ScalingKind::none : ScalingKind::manual;
  }
  const std::pair<const char *, double *> scales[] = {{"scaling.frequency", &study.scale_frequency},
                                                      {"scaling.modal", &study.scale_modal},
                                                      {"scaling.contact", &study.scale_contact}};
  for (const auto &[key, target] : scales) {
    const Entry entry = document[key];
    if (study.scaling == ScalingKind::manual && !entry)
      document.missing(key, "all of frequency, modal and contact for kind = \"manual\"");
    if (study.scaling != ScalingKind::manual && entry)
      entry.refuse("is used only with kind = \"manual\"; delete it, or write that");
    read_number(entry, *target);
  }
}

// Before anything that is a frequency.
void read_frequency_unit(const Document &document, Case &study) {
  const Entry unit = document["continuation.unit"];
  study.frequency_unit.hertz = unit && unit.word() == "Hz";
}

// Of a sweep, or where the first of the peaks that are followed is sought.
void read_frequencies(const Document &document, Case &study) {
  const FrequencyUnit unit = study.frequency_unit;
  const Entry omega = document["continuation.omega"];
  if (!omega) document.missing("continuation.omega", std::string("omega = [from, to] in ") + unit.name());
  if (!omega.is_list()) omega.refuse("must be [from, to]; for one point, write the same number twice");
  const auto ends = omega.numbers();
  if (ends.size() != 2) omega.refuse("must be two numbers, [from, to], not " + std::to_string(ends.size()));
  if (ends[0] != ends[1] && std::abs(ends[1] - ends[0]) < narrowest * ends[0])
    omega.refuse("the ends differ in their last digits only, and no points lie between; for one point, write the same "
                 "number twice");
  if (study.follows_peaks() && ends[0] == ends[1])
    omega.refuse("a peak is sought in between; write two frequencies, from and to");
  study.omega_from = ends[0] * unit.radians(), study.omega_to = ends[1] * unit.radians();
}

void read_continuation(const Document &document, Case &study) {
  read_mode(document, study);
  read_path(document, study);
  const bool sweep = study.range().is_sweep();
  if (sweep || study.follows_peaks()) read_frequencies(document, study);
  if (sweep) read_wanted(document["continuation.at"], study.range(), study);
  read_number(document["continuation.step"], study.step);
  read_truth(document["continuation.adaptive"], study.adaptive);
  read_whole(document["continuation.max_points"], study.max_points);
  read_input_file(document["continuation.start"], study, study.start);
}

// Names as in python/dovetail/results.py.
void read_watch(const Entry &entry, Watch &watch) {
  if (!entry) return;
  watch.name = entry.words(), watch.where = entry.where();
  static const std::regex mode("a([1-9][0-9]{0,8})"), contact("x([1-9][0-9]{0,8})\\.(t1|t2|n)"), node("(.+)\\.([xyz])");
  std::smatch found;
  if (std::regex_match(watch.name, found, node)) {
    watch.node = found[1], watch.direction = *found[2].first - 'x';
    return;
  }
  if (std::regex_match(watch.name, found, contact))
    watch.direction = found[2] == "n" ? 2 : found[2] == "t2" ? 1 : 0;
  else if (!std::regex_match(watch.name, found, mode))
    entry.refuse(
        "must be \"tip.y\", a node set or the row of a node and x, y or z; or the name of an unknown: \"x1.t1\", "
        "\"x1.t2\" or \"x1.n\" of contact point 1, or \"a1\", the first mode");
  watch.number = std::stoi(found[1]);
}

void read_sensitivity(const Entry &of, Case &study) {
  if (study.path) of.refuse("is asked at peaks over the frequency, but [path] is given; delete one of the two");
  Watch asked;
  read_watch(of, asked);
  if (!study.watch.name.empty() && study.watch.name != asked.name)
    of.refuse("continuation.watch = \"" + study.watch.name +
              "\" is another unknown, and the peaks are of that; write one "
              "of them");
  study.watch = asked, study.sensitivity = true;
}

void read_watched(const Document &document, Case &study) {
  const Entry of = document["sensitivity.of"];
  read_watch(document["continuation.watch"], study.watch);
  if (of) read_sensitivity(of, study);
  if (!study.watch.node.empty() && study.model.empty())
    (of ? of : document["continuation.watch"])
        .refuse("names a node, whose motion the reduced model alone does not say; give  model =  in "
                "place of  reduced =, or name an unknown such as \"x1.t1\"");
}

void read_stops(const Document &document, Case &study) {
  read_watched(document, study);
  read_whole(document["continuation.stop_after_peaks"], study.stop_after_peaks);
  read_number(document["continuation.stop_at_amplitude"], study.stop_at_amplitude);
  if (const Entry enabled = document["stability.enabled"]) study.stability = enabled.truth();
}

void read_recovery(const Document &document, Case &study) {
  if (const Entry strategies = document["recovery.strategies"]) {
    if (!strategies.is_list())
      strategies.refuse("must be a list of names of " + key_named("recovery.strategies")->value.words_text() +
                        "; [] is plain arc length");
    study.strategies = {};
    for (const Entry &item : strategies.items())
      if (!study.strategies.add(Strategies::named(item.word()))) item.refuse("stands in the list twice");
  }
  read_truth(document["recovery.allow_branch_change"], study.allow_branch_change);
  read_number(document["recovery.work"], study.work);
}

} // namespace

Case read_case(const fs::path &file, const fs::path &out) {
  Case study;
  study.file = file;
  study.text = text_of(file);
  const Document document(file, study.text);

  std::vector<std::string> names;
  for (const auto &key : keys()) names.emplace_back(key.name);
  document.refuse_unknown(names);
  for (const auto &name : names)
    if (const Entry entry = document[name]) study.given[name] = entry.place();

  if (const Entry title = document["title"]) study.title = title.words();
  read_output(document, out, study);
  read_model(document, study);
  read_motion(document, study);
  read_damping(document, study);
  study.contact = read_contact_settings(document);
  study.contact.file = file.string();
  read_harmonic_balance(document, study);
  read_excitation(document, study);
  read_preload(document, study);
  read_number(document["newton.step_tolerance"], study.step_tolerance);
  read_number(document["newton.residual_tolerance"], study.residual_tolerance);
  read_whole(document["newton.max_iterations"], study.max_iterations);
  read_scaling(document, study);
  read_frequency_unit(document, study);
  read_continuation(document, study);
  read_stops(document, study);
  read_recovery(document, study);
  if (study.mode) refuse_beside_mode(document, study);
  leave_out_motions_in_time(document, study);
  return study;
}

} // namespace dovetail
