#include "app/tell_resonances.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr std::size_t shown = 3, in_a_table = 10;

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string in_both_units(const FrequencyUnit &unit, double omega) { return unit.in_hertz(true).text(omega, 6); }

std::string line_of(const char *state, const ResonanceSet &set, const FrequencyUnit &unit) {
  char head[40];
  std::snprintf(head, sizeof head, "resonances %-9s ", state);
  std::string out = head;
  std::size_t told = 0;
  for (std::size_t j = 0; j < set.omega.size() && told < 2 * shown; ++j) {
    if (j >= shown && set.in_sweep[j] == 0) continue;
    out += (told++ ? ", " : "") + std::to_string(j + 1) + ": " + in_both_units(unit, set.omega[j]);
    if (set.in_sweep[j] > 0) out += " in the sweep";
    if (set.in_sweep[j] > 1) out += " by harmonic " + std::to_string(set.in_sweep[j]);
  }
  return out;
}

std::string sweep_in_words(const Case &study) {
  const auto [low, high] = std::minmax(study.omega_from, study.omega_to);
  const std::string first = in_both_units(study.frequency_unit, low);
  return low == high ? first : first + " to " + in_both_units(study.frequency_unit, high);
}

bool none_listed(const Resonances &found) {
  for (const ResonanceSet *set : {&found.stuck, &found.slipping, &found.open})
    for (const int met : set->in_sweep)
      if (met > 0) return false;
  return true;
}

// A resonance of the joint in motion lies between those of the joint slipping and stuck.
bool some_in_sweep(const Resonances &found, const Case &study) {
  const auto [low, high] = std::minmax(study.omega_from, study.omega_to);
  for (const int met : found.open.in_sweep)
    if (met > 0) return true;
  for (const int k : driving_harmonics(study.loads))
    for (std::size_t j = 0; j < found.slipping.omega.size(); ++j) {
      const double upper = j < found.stuck.omega.size() ? found.stuck.omega[j] : INFINITY;
      if (found.slipping.omega[j] <= k * high && upper >= k * low) return true;
    }
  return false;
}

// Of a sweep that was written in Hz, and is read in rad per unit of time.
std::string remedy_by_unit(const Resonances &found, const Case &study) {
  const auto [low, high] = std::minmax(study.omega_from, study.omega_to);
  const FrequencyUnit hertz = study.frequency_unit.in_hertz(true);
  for (const ResonanceSet *set : {&found.stuck, &found.slipping})
    for (const double omega : set->omega)
      if (const double f = omega / hertz.radians(); !study.frequency_unit.hertz && low <= f && f <= high)
        return ". Were these numbers meant in Hz, there would be one, at " + number(f) +
               " Hz: continuation.unit = \"Hz\"";
  return "";
}

double nearest(const Resonances &found, const Case &study) {
  const auto [low, high] = std::minmax(study.omega_from, study.omega_to);
  double best = 0, distance = INFINITY;
  for (const ResonanceSet *set : {&found.stuck, &found.slipping})
    for (const double omega : set->omega) {
      const double off = omega < low ? low - omega : omega - high;
      if (omega > 0 && off < distance) distance = off, best = omega;
    }
  return best;
}

std::string nearest_in_words(const Resonances &found, const Case &study) {
  const double omega = nearest(found, study);
  return omega > 0 ? "the nearest is at " + in_both_units(study.frequency_unit, omega) : "there is none";
}

// Whether a sweep's range is within what is known.
bool all_known(const Resonances &found, const Case &study) {
  const std::vector<int> harmonics = driving_harmonics(study.loads);
  return found.reach >= std::max(study.omega_from, study.omega_to) * (harmonics.empty() ? 1 : harmonics.back());
}

} // namespace

std::optional<Resonances> try_resonances(const PreloadedModel &model, const Case &study, const Voice &voice) {
  try {
    const Resonances found = resonances(model, study);
    if (found.known) return found;
    voice.say("resonances: not known, the reduced mass matrix is not positive definite");
  } catch (const ComputeError &error) {
    voice.say("resonances: not known, " + text_of(error));
  }
  return {};
}

std::vector<std::string> in_lines(const Resonances &found, const Case &study) {
  const FrequencyUnit &unit = study.frequency_unit;
  std::vector<std::string> lines{line_of("stuck", found.stuck, unit), line_of("slipping", found.slipping, unit),
                                 line_of("open", found.open, unit)};
  if (!found.all_stuck.omega.empty())
    lines.push_back(
        line_of("closed", found.all_stuck, unit) + "; all points closed and stuck, as damping.ratios counts (" +
        std::to_string(found.points - found.closed) + " of " + std::to_string(found.points) + " are open at rest)");
  const double high = std::max(study.omega_from, study.omega_to);
  if (found.reach < high)
    lines.push_back("resonances: of " + std::to_string(found.open.omega.size()) + " modes; there are more below " +
                    in_both_units(unit, high));
  return lines;
}

std::string in_table(const Resonances &found, const Case &study) {
  const FrequencyUnit &unit = study.frequency_unit;
  const FrequencyUnit hertz = unit.in_hertz(true);
  char columns[120];
  std::snprintf(columns, sizeof columns, "       %12s %12s    %12s %12s    %12s %12s\n", "Hz", unit.omega.c_str(), "Hz",
                unit.omega.c_str(), "Hz", unit.omega.c_str());
  std::string out = "joint at rest: " + std::to_string(found.closed) + " of " + std::to_string(found.points) +
                    " contact points closed, pressed with " + number(found.clamping) +
                    behind_number(study.units.force) + " in all\n\n" +
                    "  mode             stuck                     slipping                       open\n" + columns;
  const ResonanceSet *sets[] = {&found.stuck, &found.slipping, &found.open};
  bool marked = false;
  const auto cell = [&](const ResonanceSet &set, std::size_t j) {
    char text[64];
    if (j >= set.omega.size()) return std::string(29, ' ');
    std::snprintf(text, sizeof text, " %12.6g %12.6g %-2s", set.omega[j] / hertz.radians(), set.omega[j],
                  set.in_sweep[j] > 0 ? "*" : "");
    marked = marked || set.in_sweep[j] > 0;
    return std::string(text);
  };
  for (std::size_t j = 0; j < std::min(in_a_table, found.stuck.omega.size()); ++j) {
    char head[32];
    std::snprintf(head, sizeof head, "%6zu", j + 1);
    std::string row = head;
    for (const ResonanceSet *set : sets) row += cell(*set, j);
    out += row.substr(0, row.find_last_not_of(' ') + 1) + "\n";
  }
  if (!study.mode) {
    out += "\nsweep: " + sweep_in_words(study);
    if (marked)
      out += "; * lies in it";
    else if (study.omega_from != study.omega_to && none_listed(found))
      out += "; none of these lies in it, " + nearest_in_words(found, study);
  }
  std::string harmonics;
  for (const int k : driving_harmonics(study.loads))
    if (k > 1) harmonics += (harmonics.empty() ? "" : ", ") + std::to_string(k);
  if (marked && !harmonics.empty()) out += ", or in its " + harmonics + "-fold, where the load's harmonics are";
  if (!found.all_stuck.omega.empty()) {
    out += "\nall points closed and stuck, as damping.ratios counts:";
    for (std::size_t j = 0; j < std::min(in_a_table, found.all_stuck.omega.size()); ++j)
      out += (j ? ", " : " ") + in_both_units(unit, found.all_stuck.omega[j]);
  }
  return out;
}

std::vector<Warning> warnings_of(const Resonances &found, const Case &study) {
  std::vector<Warning> out;
  if (study.omega_from != study.omega_to && all_known(found, study) && !some_in_sweep(found, study))
    out.push_back({"no_resonance", "no resonance lies in the sweep, " + sweep_in_words(study) + "; " +
                                       nearest_in_words(found, study) + remedy_by_unit(found, study)});
  if (found.may_lift > 0 && !(found.clamping > 0))
    out.push_back({"not_pressed", "nothing presses the joint: at rest no contact point bears a normal force. Check the "
                                  "sign of /preload and of the normals (positive x_n closes), and contact.gap "
                                  "(positive is a clearance)"});
  if (found.sliding.without_bound())
    out.push_back(
        {"slides", "a body that the joint alone keeps from sliding is pushed with " + number(found.sliding.force) +
                       behind_number(study.units.force) + ", and friction at rest holds " + number(found.sliding.held) +
                       behind_number(study.units.force) + " (mu times the clamping): it slides as a whole, and " +
                       "nothing but its inertia bounds the motion"});
  return out;
}

std::optional<Warning> no_peak(const Resonances &found, const Case &study) {
  if (study.path || study.mode || study.omega_from == study.omega_to || !all_known(found, study) ||
      !none_listed(found) || !some_in_sweep(found, study))
    return {};
  return Warning{"no_resonance", "the curve has no peak, and no resonance of the joint stuck, slipping or open lies in "
                                 "the sweep, " +
                                     sweep_in_words(study) + "; " + nearest_in_words(found, study)};
}

} // namespace dovetail
