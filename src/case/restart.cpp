#include "case/restart.hpp"

#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <set>
#include <sstream>

#include "case/keys.hpp"
#include "case/number_text.hpp"
#include "support/error.hpp"
#include "support/hash.hpp"

namespace dovetail {
namespace {

const std::set<std::string> limits = {"continuation.max_points", "continuation.stop_after_peaks",
                                      "continuation.stop_at_amplitude", "newton.max_iterations"};
// Neither what is computed nor how far; the model is compared by what it does (check_state).
const std::set<std::string> no_matter = {
    "title",           "model",   "reduced", "reduction.check_modes", "reduction.memory", "continuation.unit",
    "continuation.at", "path.at", "mode.at", "continuation.start",    "output.directory", "output.motion"};

std::uint64_t number_of(double value) {
  std::uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

// The contact parameters of all points in one number.
std::string fingerprint(const std::vector<ContactPoint> &points) {
  std::uint64_t hash = 0;
  const auto take = [&](double value) { hash = mix(hash + number_of(value) + 1); };
  for (const ContactPoint &point : points) {
    for (const double value : {static_cast<double>(point.law), point.kn, point.gap}) take(value);
    for (int d = 0; d < 2; ++d) take(point.kt[d]), take(point.mu[d]);
  }
  char text[24];
  std::snprintf(text, sizeof text, "%016" PRIx64, hash);
  return text;
}

// With the digits that a change of unit leaves alone.
std::string rounded(double omega) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.14g", omega);
  return digits;
}

constexpr const char *advice = "; put it back to continue, or begin anew without --restart";

std::string line(const std::string &key, const std::string &value) { return key + " = " + value + "\n"; }

} // namespace

std::string problem_of(const Case &study, const std::vector<ContactPoint> &points) {
  std::string text;
  for (const Key &key : keys()) {
    const bool which = study.follows_peaks() && key.name == std::string("continuation.stop_after_peaks"); // peak
    if (!key.text || (limits.count(key.name) && !which) || no_matter.count(key.name)) continue;
    const CurveRange range = study.range();
    if (key.name == std::string(range.key)) // the end may move
      text += line(std::string(range.key) + ", from", rounded(range.from)) +
              line(std::string(range.key) + ", direction", range.to < range.from ? "down" : "up");
    else if (study.path && !study.path->peak && key.name == std::string("path.omega"))
      text += line(key.name, rounded(study.omega_from));
    else
      text += line(key.name, key.text(study));
  }
  return text + line("contact", fingerprint(points));
}

std::string limits_of(const Case &study) {
  std::string text = line(std::string(study.range().key) + ", to", number_text(study.range().to));
  for (const Key &key : keys())
    if (limits.count(key.name)) text += line(key.name, key.text(study));
  return text;
}

void refuse_other_problem(const Case &study, const std::vector<ContactPoint> &points, const std::string &saved) {
  const std::string along = study.range().key, begins = ", from = ";
  const bool elsewhere = saved.find(begins) != std::string::npos && saved.find(along + begins) == std::string::npos;
  if (elsewhere) // or a key would be named that this alone changes
    throw InputError(study.file.string() + ": follows a curve over " + along +
                     ", and this run began over something else" + advice);
  std::istringstream before(saved), now(problem_of(study, points));
  for (std::string old_line, new_line; std::getline(now, new_line);) {
    std::getline(before, old_line);
    if (old_line == new_line) continue;
    const std::string key = new_line.substr(0, new_line.find(" = ")), name = key.substr(0, key.find(','));
    const auto found = study.given.find(name);
    const std::string place = found == study.given.end() ? study.file.string() : found->second;
    if (name == "contact") throw InputError(place + ": [contact] is not what it was when this run began" + advice);
    const bool frequency = name == "continuation.omega" || name == "path.omega";
    const std::string unit = frequency && study.frequency_unit.hertz ? " [" + study.frequency_unit.omega + "]" : "";
    throw InputError(place + ": " + key + unit + " = " + new_line.substr(key.size() + 3) + ": this run began with " +
                     (old_line.rfind(key + " = ", 0) == 0 ? old_line.substr(key.size() + 3) : "another version") +
                     advice);
  }
}

} // namespace dovetail
