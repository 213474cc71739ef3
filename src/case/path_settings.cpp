#include "case/path_settings.hpp"

#include <algorithm>
#include <cmath>

#include "case/number_text.hpp"
#include "contact/samples.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

// Which contact points the parameter is of.
void read_points(const Document &document, Path &path) {
  const Entry joint = document["path.joint"], points = document["path.points"];
  for (const Entry *entry : {&joint, &points})
    if (*entry && !has_points(*path.parameter))
      entry->refuse(std::string("path.parameter = \"") + path.parameter->name +
                    "\" is of no contact points; leave it out");
  if (joint && points) points.refuse("path.joint is given as well; delete one of the two");
  if (joint) path.joint = joint.words();
  if (!points) return;
  if (!points.is_list()) points.refuse("must be a list of contact points, [3] or [1, 2, 5], numbered from 1");
  for (const Entry &item : points.items()) {
    path.points.push_back(item.whole());
    if (std::count(path.points.begin(), path.points.end(), path.points.back()) > 1) item.refuse("is there already");
  }
  if (path.points.empty()) points.refuse("names no contact point; leave it out for all of them");
}

// What goes with a path over peaks, and what does not; what is looked for, from the one word.
PeakKind read_peak(const Document &document, const Entry &peak, const Case &study) {
  const std::string word = peak.word();
  const std::pair<const char *, const char *> unwanted[] = {
      {"path.omega", "is the frequency of a path at one frequency, but path.peak follows a peak to where it goes; "
                     "continuation.omega = [from, to] is where the first one is sought. Delete one of the two"},
      {"continuation.at", "[path] is given as well; what it passes exactly is path.at. Delete one of the two"},
      {"continuation.stop_at_amplitude", "is for sweeps and paths at one frequency; path.peak has no use for it"},
      {"accuracy.tolerance", "path.peak keeps the number of harmonics; give harmonic_balance.harmonics instead"},
  };
  for (const auto &[key, why] : unwanted)
    if (const Entry entry = document[key]) entry.refuse(why);
  if (study.samples != exactly)
    document["harmonic_balance.samples"].refuse("path.peak wants exact contact forces: samples make steps, and "
                                                "maxima of their own; write \"exact\"");
  for (const char *key : {"stability.enabled", "accuracy.estimates"})
    if (const Entry entry = document[key]; entry && entry.truth())
      entry.refuse("is not there for peaks over a parameter; delete this key, or path.peak");
  if (const Entry entry = document["continuation.adaptive"]; entry && !entry.truth())
    entry.refuse("peaks over a parameter are followed with adaptive steps only; delete this key, or path.peak");
  if (!document["continuation.watch"])
    document.missing("continuation.watch", "whose peak it is, watch = \"x1.t1\" for example,");
  return word == "phase" ? PeakKind::phase : PeakKind::amplitude;
}

} // namespace

void read_wanted(const Entry &at, const CurveRange &range, Case &study) {
  if (!at) return;
  const double unit = range.is_sweep() ? range.unit.radians() : 1;
  const auto number = [&](double value) { return range.is_sweep() ? range.unit.number(value) : number_text(value); };
  const auto [low, high] = std::minmax(range.from, range.to);
  for (const auto &item : at.items()) {
    const double wanted = item.number() * unit;
    if (wanted < low || wanted > high)
      item.refuse("outside " + std::string(range.key) + " = [" + number(range.from) + ", " + number(range.to) + "]" +
                  (range.is_sweep() ? std::string(" ") + range.unit.name() : ""));
    if (!study.at.empty() && (range.to < range.from ? wanted >= study.at.back() : wanted <= study.at.back()))
      item.refuse("must come in the order of the sweep, each once; the entry before is " + number(study.at.back()));
    study.at.push_back(wanted);
  }
}

void read_path(const Document &document, Case &study) {
  const Entry parameter = document["path.parameter"], range = document["path.range"], omega = document["path.omega"],
              at = document["path.at"], peak = document["path.peak"], joint = document["path.joint"],
              points = document["path.points"];
  if (!parameter) {
    for (const Entry *entry : {&range, &omega, &at, &peak, &joint, &points})
      if (*entry)
        entry->refuse("path.parameter is not given; write what is varied: " +
                      key_named("path.parameter")->value.words_text());
    return;
  }
  Path path;
  path.parameter = parameter_named(parameter.word("; a sweep over the frequency is continuation.omega"));
  for (const char *key : {"continuation.omega", "continuation.at"})
    if (const Entry entry = document[key]; entry && !peak)
      entry.refuse("[path] is given as well; its frequency is path.omega, and what it passes exactly path.at. Delete "
                   "one of the two");
  if (!range) document.missing("path.range", "range = [from, to], factors on the value that the case has,");
  if (!range.is_list()) range.refuse("must be [from, to]");
  const auto ends = range.numbers();
  if (ends.size() != 2) range.refuse("must be two numbers, [from, to], not " + std::to_string(ends.size()));
  if (std::abs(ends[1] - ends[0]) <= 1e-12 * std::max(std::abs(ends[0]), std::abs(ends[1])))
    range.refuse("the ends are the same; for one point, write continuation.omega with the same number twice");
  if (path.parameter->positive() && std::min(ends[0], ends[1]) <= 0)
    range.refuse("is a factor on the value that the case has: both ends must be greater than 0");
  path.from = ends[0], path.to = ends[1];
  read_points(document, path);
  if (peak) {
    path.peak = read_peak(document, peak, study);
    study.estimates = false, study.stability = false;
  } else {
    if (!omega)
      document.missing("path.omega", std::string("the frequency, omega = 1.5 in ") + study.frequency_unit.name() +
                                         ", or peak = \"amplitude\" to follow a peak,");
    study.omega_from = study.omega_to = omega.number() * study.frequency_unit.radians();
  }
  study.path = path;
  read_wanted(at, study.range(), study);
}

} // namespace dovetail
