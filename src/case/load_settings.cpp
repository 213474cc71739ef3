#include "case/load_settings.hpp"

#include <algorithm>
#include <map>

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *constant_alone =
    "is constant alone, nothing would vibrate; write [0, 1] for a cosine, and static loads into /preload of the model";

std::vector<double> without_last_zeros(std::vector<double> values) {
  while (!values.empty() && values.back() == 0) values.pop_back();
  return values;
}

// Courses of the loads, and the entries that name them.
std::vector<Entry> read_loads(const Document &document, Case &study) {
  const Entry fourier = document["excitation.fourier"], loads = document["excitation.load"];
  if (!fourier && !loads)
    document.missing("excitation.fourier", "fourier = [0, 1] for a cosine, [0, 0, 1] for a sine,");
  if (fourier && loads)
    throw InputError(loads.where() + ": excitation.fourier is given as well, in line " +
                     std::to_string(fourier.line()) + "; keep one of the two");
  if (fourier) {
    study.loads = {{force_pattern, without_last_zeros(fourier.numbers()), fourier.where() + " = " + fourier.source()}};
    if (study.loads[0].fourier.empty())
      fourier.refuse("nothing would move; write [0, 1] for a cosine, [0, 0, 1] for a sine");
    if (study.loads[0].fourier.size() == 1) fourier.refuse(constant_alone);
    return {fourier};
  }
  std::vector<Entry> series;
  std::map<std::string, size_t> lines;
  bool moving = false, vibrating = false;
  study.loads.clear();
  for (const Entry &load : loads.tables("[[excitation.load]], in double brackets, once for each load pattern")) {
    const Entry pattern = load["pattern"], course = load["fourier"];
    if (!pattern)
      throw InputError(load.place() + ": excitation.load.pattern is missing: write pattern = \"force\" for "
                                      "the dataset /force of the model, or a name in its group /forces");
    if (!course)
      throw InputError(load.place() + ": excitation.load.fourier is missing: write fourier = [0, 1] for a "
                                      "cosine, [0, 0, 1] for a sine");
    const std::string name = pattern.words();
    if (const auto [before, first] = lines.emplace(name, pattern.line()); !first)
      pattern.refuse("has its course in line " + std::to_string(before->second) +
                     " already; add the coefficients of the two");
    study.loads.push_back({name, without_last_zeros(course.numbers()), pattern.where() + " = " + pattern.source()});
    moving = moving || !study.loads.back().fourier.empty();
    vibrating = vibrating || study.loads.back().fourier.size() > 1;
    series.push_back(course);
  }
  if (!moving)
    throw InputError(loads.where() + ": all coefficients are zero, nothing would move; write fourier = [0, 1] for a "
                                     "cosine, [0, 0, 1] for a sine");
  if (!vibrating) throw InputError(loads.where() + ": " + constant_alone);
  return series;
}

} // namespace

void read_excitation(const Document &document, Case &study) {
  if (const Entry order = document["excitation.engine_order"]) study.engine_order = order.whole();
  const std::vector<Entry> series = read_loads(document, study);
  for (const LoadCourse &load : study.loads) // [a0, a1, b1, ...]
    if (study.tolerance > 0) study.harmonics = std::max(study.harmonics, static_cast<int>(load.fourier.size() / 2));
  for (size_t i = 0; i < series.size(); ++i) {
    std::vector<double> &fourier = study.loads[i].fourier;
    const size_t highest = fourier.size() / 2;
    if (highest > static_cast<size_t>(study.harmonics))
      series[i].refuse("the force has harmonic " + std::to_string(highest) + ", but harmonic_balance.harmonics = " +
                       std::to_string(study.harmonics) + "; write at least " + std::to_string(highest) + " there");
    fourier.resize(2 * static_cast<size_t>(study.harmonics) + 1);
  }
}

void check_patterns(const Case &study, const std::vector<std::string> &patterns, const std::filesystem::path &file) {
  for (const LoadCourse &load : study.loads) {
    if (std::find(patterns.begin(), patterns.end(), load.pattern) != patterns.end()) continue;
    std::string names;
    for (const std::string &name : patterns) names += (names.empty() ? "\"" : ", \"") + name + '"';
    const bool in_short = study.given.count("excitation.fourier") > 0;
    throw InputError(load.where + ": " +
                     (in_short ? "is the course of the load pattern \"force\", which " : "no such load pattern in ") +
                     file.string() + (in_short ? " has not; write [[excitation.load]] with one of " : "; it has ") +
                     names);
  }
}

} // namespace dovetail
