#include "results/summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "results/counts.hpp"
#include "support/blas_kernel.hpp"
#include "support/json.hpp"
#include "support/log.hpp"
#include "support/version.hpp"

namespace dovetail {
namespace {

std::string list(const double *values, int count, int stride) {
  std::string out = "[";
  char number[32];
  for (int r = 0; r < count; ++r) {
    std::snprintf(number, sizeof number, "%s%.6g", r ? ", " : "", values[r * stride]);
    out += number;
  }
  return out + "]";
}

std::string number(const char *format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

using Kind = BranchEvent::Kind;

// The places of one kind as a JSON list.
std::string places(const BranchStory &story, Kind kind, bool amplitude) {
  const bool path = !story.range.is_sweep();
  std::string out = "[";
  for (const EventRecord &event : story.events) {
    if (event.kind != static_cast<int>(kind)) continue;
    out += (out.size() > 1 ? ", " : "") + std::string("{\"point\": ") + std::to_string(event.point) +
           ", \"omega\": " + number("%.17g", event.omega);
    if (path) out += ", \"parameter\": " + number("%.17g", event.parameter);
    if (amplitude)
      out += ", \"amplitude\": " + number("%.17g", event.amplitude) +
             ", \"unknown\": " + quoted(story.told.name(event.unknown));
    out += "}";
  }
  return out + "]";
}

constexpr double much_between = 0.01; // of the amplitude: a peak may hide there

// What the estimates of all points amount to.
struct Accuracy {
  double largest = 0, omega = 0; // and where
  double most_points = 0;        // 95 % of them are below
  double harmonics = 0, sampling = 0, modes = 0;
  int above = 0, unknown = 0, meaningless = 0; // the tolerance; where the estimate failed; beyond no_error
  int wanted = 0;                              // harmonics there, by the rule for contacts that open and close
  double between = 0, before = 0; // largest error of the amplitude between points, and the frequency after it
};

template <class Record> double value_of(const BranchStory &story, const Record &record) {
  return story.range.is_sweep() ? record.omega : record.parameter;
}

Accuracy accuracy_of(const BranchStory &story) {
  Accuracy found;
  std::vector<double> totals;
  const bool opens = std::any_of(story.estimates.begin(), story.estimates.end(),
                                 [](const EstimateRecord &estimate) { return estimate.open > 0; });
  for (const EstimateRecord &estimate : story.estimates) {
    if (estimate.between > found.between) found.between = estimate.between, found.before = value_of(story, estimate);
    const double total = estimate.total();
    if (!std::isfinite(total)) {
      ++found.unknown;
      continue;
    }
    totals.push_back(total);
    found.above += story.tolerance > 0 && total > story.tolerance;
    if (total > no_error) {
      ++found.meaningless;
      const double needed = 1.5 * story.closed_contact_frequency / estimate.omega;
      if (opens && estimate.modes <= estimate.harmonics)
        found.wanted = std::max(found.wanted, static_cast<int>(std::ceil(std::min(needed, 1e6))));
    }
    found.harmonics = std::max(found.harmonics, estimate.harmonics);
    found.sampling = std::max(found.sampling, estimate.sampling);
    found.modes = std::max(found.modes, estimate.modes);
    if (total > found.largest) found.largest = total, found.omega = value_of(story, estimate);
  }
  std::sort(totals.begin(), totals.end());
  if (!totals.empty()) found.most_points = totals[static_cast<std::size_t>(0.95 * double(totals.size() - 1))];
  return found;
}

std::string accuracy_in_json(const BranchStory &story) {
  if (story.estimates.empty()) return "";
  const Accuracy found = accuracy_of(story);
  const std::string place = story.range.is_sweep() ? "omega" : "parameter";
  std::string out =
      "  \"accuracy\": {\"largest\": " + number("%.3g", found.largest) + ", \"" + place +
      "\": " + number("%.17g", found.omega) + ", \"most_points\": " + number("%.3g", found.most_points) +
      ", \"harmonics\": " + number("%.3g", found.harmonics) + ", \"sampling\": " + number("%.3g", found.sampling) +
      ", \"modes\": " + number("%.3g", found.modes) + ", \"unknown\": " + std::to_string(found.unknown) +
      ", \"meaningless\": " + std::to_string(found.meaningless) + ", \"between\": " + number("%.3g", found.between) +
      ", \"between_" + place + "\": " + number("%.17g", found.before);
  if (found.wanted > 0) out += ", \"harmonics_wanted\": " + std::to_string(found.wanted);
  if (story.tolerance > 0)
    out += ", \"tolerance\": " + number("%.17g", story.tolerance) + ", \"above\": " + std::to_string(found.above);
  return out + "},\n";
}

std::string in_json(const Resonances &found) {
  const std::pair<const char *, const ResonanceSet *> sets[] = {
      {"stuck", &found.stuck}, {"slipping", &found.slipping}, {"open", &found.open}};
  std::string out = "  \"resonances\": {", in_sweep;
  for (const auto &[name, set] : sets) {
    std::string values, met;
    for (std::size_t j = 0; j < set->omega.size(); ++j) {
      values += (values.empty() ? "" : ", ") + number("%.17g", set->omega[j]);
      if (set->in_sweep[j] > 0) met += (met.empty() ? "" : ", ") + std::to_string(j + 1);
    }
    out += quoted(name) + ": [" + values + "],\n    ";
    in_sweep += (in_sweep.empty() ? "" : ", ") + quoted(name) + ": [" + met + "]";
  }
  return out + "\"in_sweep\": {" + in_sweep + "},\n    \"closed_points\": " + std::to_string(found.closed) +
         ", \"clamping\": " + number("%.17g", found.clamping) + "},\n";
}

std::string in_json(const std::vector<Warning> &warnings) {
  std::string out;
  for (const Warning &warning : warnings)
    out += (out.empty() ? "\n    " : ",\n    ") + std::string("{\"kind\": ") + quoted(warning.kind) +
           ", \"text\": " + quoted(warning.text) + "}";
  return "  \"warnings\": [" + out + (out.empty() ? "" : "\n  ") + "],\n";
}

std::string in_json(const ModeStory &mode) {
  const auto finite = [](double value) { return std::isfinite(value) ? number("%.17g", value) : std::string("null"); };
  return "  \"mode\": {\"number\": " + std::to_string(mode.number) + ", \"omega\": " + number("%.17g", mode.omega) +
         ", \"onset\": " + finite(mode.onset.amplitude) + ", \"onset_point\": " + std::to_string(mode.onset.point) +
         ", \"onset_kind\": " + quoted(mode.onset.what) +
         ",\n    \"largest_damping_ratio\": " + number("%.17g", mode.ratio_most) +
         ", \"energy_error\": " + number("%.3g", mode.energy_error) + ", \"force_level\": " + finite(mode.force_level) +
         "},\n";
}

std::string in_json(const BranchStory &story) {
  const BranchSummary &branch = story.summary;
  std::string out = "  \"end\": " + quoted(name_of(branch.end)) + ",\n  \"why\": " + quoted(branch.why) +
                    ",\n  \"failures\": " + (branch.good() ? "0" : "1") + ",\n";
  for_each_count(branch.counts, [&](const char *name, long count) {
    out += "  " + quoted(name) + ": " + std::to_string(count) + ",\n";
  });
  out += accuracy_in_json(story);
  if (story.mode) out += in_json(*story.mode);
  if (story.resonances) out += in_json(*story.resonances);
  out += in_json(story.warnings);
  const double last = branch.parameter * story.scale;
  const bool sweep = story.range.is_sweep();
  if (!sweep)
    out += "  \"parameter\": " + quoted(story.range.parameter->name) +
           ",\n  \"last_parameter\": " + number("%.17g", last) + ",\n";
  out += "  \"last_omega\": " + number("%.17g", sweep ? last : story.omega) +
         ",\n  \"parts\": " + std::to_string(story.parts) +
         ",\n  \"branch_seconds\": " + number("%.6g", story.seconds_all_parts) + ",\n  \"located\": {\n";
  out += "    \"peaks\": " + places(story, Kind::peak, true) + ",\n    \"folds\": " + places(story, Kind::fold, true) +
         ",\n    \"branch_points\": " + places(story, Kind::branch, false) +
         ",\n    \"stability_changes\": " + places(story, Kind::stability, false) + "\n  },\n";
  return out;
}

std::string many(long count, const char *one, const char *more) {
  return std::to_string(count) + " " + (count == 1 ? one : more);
}

void tell_accuracy(const BranchStory &story) {
  if (story.estimates.empty()) return;
  const Accuracy found = accuracy_of(story);
  const int points = static_cast<int>(story.estimates.size());
  if (found.unknown < points && found.largest == 0)
    log_line("  estimated errors: 0 at every point\n");
  else if (found.unknown < points)
    log_line("  estimated errors: at most %.1e (at %s), %.1e or less at 95 %% of the points%s\n", found.largest,
             story.range.text(found.omega).c_str(), found.most_points,
             found.modes > std::max(found.sampling, found.harmonics) ? "; mostly by modes left out: more of them "
                                                                       "with a larger reduction.modes"
             : found.sampling > found.harmonics                      ? "; mostly by too few samples"
                                                                     : "");
  if (found.meaningless > 0)
    log_line(
        "  %d points with estimated errors above %g mean nothing: %s\n", found.meaningless, no_error,
        found.modes > found.harmonics ? "more modes are wanted"
        : found.wanted > 0
            ? ("contacts that open and close want some " + std::to_string(found.wanted) + " harmonics there").c_str()
            : "more harmonics are wanted");
  if (found.between > 0)
    log_line("  between points: the amplitude is off a curve through them by %.1e at most (before %s)%s\n",
             found.between, story.range.text(found.before).c_str(),
             found.between > much_between ? ("; look closer there with " + std::string(story.range.at_key())).c_str()
                                          : "");
  if (found.unknown > 0)
    log_line("  no estimate at %d of %d points%s\n", found.unknown, points,
             story.tolerance > 0 ? ": every other one is asked, while harmonics stay" : "");
  if (found.above > 0)
    log_line("  the tolerance of %g is not kept at %d of %d points asked: %s\n", story.tolerance, found.above,
             points - found.unknown,
             found.modes > 0.5 * story.tolerance ? "modes left out take too much of it; raise reduction.modes"
                                                 : "more harmonics would not have helped there");
}

void tell(const ModeStory &mode, const BranchStory &story) {
  const auto amplitude = [&](double value) {
    return number("%.7g", value) + behind_number(story.told.units.instead_of(story.range.parameter->unit));
  };
  if (story.summary.counts.points == 0) return;
  log_line("  mode %d: %s stuck, %s at the end; damping ratio of the resonance at most %.5g, at amplitude %s\n",
           mode.number, story.range.unit.text(mode.omega).c_str(), story.range.unit.text(mode.omega_last).c_str(),
           mode.ratio_most, amplitude(mode.amplitude_most).c_str());
  if (mode.onset.point > 0)
    log_line("  contact point %d %s first, at amplitude %s\n", mode.onset.point, mode.onset.what,
             amplitude(mode.onset.amplitude).c_str());
  else
    log_line("  no contact point slips or lifts off in this mode, at any amplitude\n");
  log_line("  energies balance to a damping ratio of %.1e\n", mode.energy_error);
  if (std::isfinite(mode.force_level))
    log_line("  the last point is the resonance under %.5g times the load\n", mode.force_level);
  else
    log_line("  the load does no work on this mode: there is no force level\n");
}

// The same in words.
void tell(const BranchStory &story) {
  const Counts &counts = story.summary.counts;
  log_line("  %d points, %ld Newton iterations, %s, %s\n", counts.points, counts.newton,
           many(counts.cuts, "step cut", "step cuts").c_str(),
           many(counts.folds, "turning point", "turning points").c_str());
  const std::pair<int, std::string> helped[] = {
      {counts.corners, many(counts.corners, "corner", "corners")},
      {counts.harmonics, "harmonics added " + many(counts.harmonics, "time", "times")},
      {counts.leaps, many(counts.leaps, "leap", "leaps")},
      {counts.integrations, many(counts.integrations, "time integration", "time integrations")}};
  std::string used;
  for (const auto &[count, words] : helped)
    if (count > 0) used += (used.empty() ? "" : ", ") + words;
  if (!used.empty()) log_line("  where plain steps did not lead on: %s\n", used.c_str());
  if (counts.inexact > 0)
    log_line("  %s left more of the equations than was asked: Newton's method may creep, and turns be missed\n",
             many(counts.inexact, "linear solve", "linear solves").c_str());
  if (story.mode) tell(*story.mode, story);
  tell_accuracy(story);
  if (counts.leaps + counts.integrations > 0)
    log_line("  after a leap the branch may be another one: look at the curve there\n");
  double highest = 0;
  for (const EventRecord &event : story.events)
    if (event.kind == static_cast<int>(Kind::peak)) {
      highest = std::max(highest, event.amplitude);
      log_line("  peak of %s at %s\n", story.told.amplitude(event.unknown, event.amplitude).c_str(),
               story.range.text(value_of(story, event)).c_str());
    }
  const bool at_peak = !story.events.empty() && story.events.back().kind == static_cast<int>(Kind::peak) &&
                       story.events.back().point == counts.points - 1; // the run stopped there
  const std::pair<const CurveEnds::End *, const char *> ends[] = {
      {story.ends.falling(), "falling from the beginning of the curve"},
      {at_peak ? nullptr : story.ends.rising(), "still rising at the end of the curve"}};
  for (const auto &[end, words] : ends)
    if (end && end->amplitude > highest) // a lower one is no news
      log_line("  no peak, %s: %s at %s\n", words, story.told.amplitude(end->unknown, end->amplitude).c_str(),
               story.range.text(end->value).c_str());
  for (const EventRecord &event : story.events)
    if (event.kind == static_cast<int>(Kind::stability))
      log_line("  stability changes at %s\n", story.range.text(value_of(story, event)).c_str());
  if (counts.missed > 0)
    log_line("  %d %s without solution\n", counts.missed,
             story.range.is_sweep() ? "frequencies of continuation.at"
             : story.mode           ? "amplitudes of mode.at"
                                    : "values of path.at");
}

} // namespace

const char *name_of(BranchSummary::End end) {
  switch (end) {
  case BranchSummary::End::arrived:
    return "arrived";
  case BranchSummary::End::max_points:
    return "max_points";
  case BranchSummary::End::stalled:
    return "stalled";
  case BranchSummary::End::peaks:
    return "peaks";
  case BranchSummary::End::amplitude:
    return "amplitude";
  case BranchSummary::End::vanished:
    return "vanished";
  case BranchSummary::End::interrupted:
    return "interrupted";
  case BranchSummary::End::retraced:
    return "retraced";
  case BranchSummary::End::turned_back:
    return "turned_back";
  case BranchSummary::End::no_start:
    return "no_start";
  }
  return "?";
}

void write_summary(MPI_Comm comm, const std::filesystem::path &directory, const BranchStory *branch,
                   const Stages &stages, const ReductionFigures *reduction) {
  int rank, ranks;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  std::vector<double> own;
  for (const auto &record : stages.records()) own.insert(own.end(), {record.seconds, record.cpu, record.peak_mib});
  const std::vector<double> all = gather(comm, own); // (ranks, stages, 3)
  std::vector<double> forecast;
  if (reduction) forecast = gather(comm, {reduction->forecast_mib});
  on_all_ranks(comm, [&] {
    if (rank != 0) return;
    const int count = static_cast<int>(stages.records().size());
    std::ostringstream file;
    file << "{\n  \"program\": " << quoted(std::string("dovetail ") + version + " " + git_revision)
         << ",\n  \"blas_kernel\": " << quoted(blas_kernel().name) << ",\n  \"ranks\": " << ranks << ",\n";
    if (branch) file << in_json(*branch);
    if (reduction) {
      char numbers[128];
      std::snprintf(numbers, sizeof numbers, "\"flops\": %.6g, \"backward_error\": %.3g, \"kept_psi\": %s",
                    reduction->flops, reduction->backward_error, reduction->kept_psi ? "true" : "false");
      file << "  \"reduction\": {\"ordering\": " << quoted(reduction->ordering) << ", " << numbers
           << ", \"forecast_mib\": " << list(forecast.data(), ranks, 1) << "},\n";
    }
    file << "  \"stages\": [";
    for (int s = 0; s < count; ++s)
      file << (s ? ",\n    " : "\n    ") << "{\"name\": " << quoted(stages.records()[s].name)
           << ", \"seconds\": " << list(&all[3 * s], ranks, 3 * count)
           << ", \"cpu\": " << list(&all[3 * s + 1], ranks, 3 * count)
           << ", \"peak_mib\": " << list(&all[3 * s + 2], ranks, 3 * count) << "}";
    file << "\n  ]\n}\n";
    if (!directory.empty() && !(std::ofstream(directory / "summary.json") << file.str()).flush())
      throw ComputeError((directory / "summary.json").string() + ": cannot be written (is the disk full?)");

    log_line("\n  stage                  seconds       cpu   peak memory per rank\n");
    for (int s = 0; s < count; ++s) {
      double most[3] = {0, 0, 0}; // of any rank
      for (int r = 0; r < ranks; ++r)
        for (int i = 0; i < 3; ++i) most[i] = std::max(most[i], all[3 * (r * count + s) + i]);
      log_line("  %-20s %9.3f %9.3f %12.0f MiB\n", stages.records()[s].name.c_str(), most[0], most[1], most[2]);
    }
    if (branch) tell(*branch);
  });
}

void note_failure(const std::filesystem::path &directory, const std::string &failure) noexcept {
  const auto path = directory / "summary.json";
  std::error_code error;
  if (std::filesystem::exists(path, error)) return;
  std::ofstream(path) << "{\n  \"end\": \"failed\",\n  \"why\": " << quoted(failure) << ",\n  \"failures\": 1\n}\n";
}

} // namespace dovetail
