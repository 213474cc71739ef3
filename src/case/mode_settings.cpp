#include "case/mode_settings.hpp"

#include "case/path_settings.hpp"

namespace dovetail {
void read_mode(const Document &document, Case &study) {
  const Entry number = document["mode.number"], near = document["mode.near"], amplitude = document["mode.amplitude"],
              at = document["mode.at"], to_force = document["mode.to_force"];
  if (!number && !near) {
    for (const Entry *entry : {&amplitude, &at, &to_force})
      if (*entry)
        entry->refuse("which mode is not said; write number = 1, or near = 12.3, a frequency in " +
                      std::string(study.frequency_unit.name()));
    return;
  }
  if (number && near) near.refuse("mode.number is given as well; keep one of the two");
  for (const char *key : {"continuation.omega", "continuation.at", "path.parameter", "path.range", "path.omega",
                          "path.peak", "path.at", "path.joint", "path.points"})
    if (const Entry entry = document[key])
      entry.refuse("[mode] is given as well: a mode is followed over its amplitude, mode.amplitude, and what it passes "
                   "exactly is mode.at. Delete one of the two");
  ModeWish mode;
  if (number) mode.number = number.whole();
  if (near) mode.near = near.number() * study.frequency_unit.radians();
  if (!amplitude) document.missing("mode.amplitude", "amplitude = [from, to], modal amplitudes such as [1e-3, 10.0],");
  if (!amplitude.is_list()) amplitude.refuse("must be [from, to]");
  const auto ends = amplitude.numbers();
  if (ends.size() != 2) amplitude.refuse("must be two numbers, [from, to], not " + std::to_string(ends.size()));
  if (ends[1] <= ends[0] * (1 + 1e-9))
    amplitude.refuse("must rise: a mode begins where its contacts stick, at small amplitudes");
  mode.from = ends[0], mode.to = ends[1];
  if (to_force) mode.to_force = to_force.number();
  study.mode = mode;
  read_wanted(at, study.range(), study);
}

void refuse_beside_mode(const Document &document, Case &study) {
  const auto refuse = [&](const char *key, const std::string &why) {
    if (const Entry entry = document[key]) entry.refuse("[mode] is given, and " + why);
  };
  refuse("continuation.start", "a mode begins with the stuck structure; delete this key");
  for (const char *key : {"continuation.stop_after_peaks", "continuation.stop_at_amplitude"})
    refuse(key, "a mode ends with mode.amplitude or mode.to_force; delete this key");
  refuse("sensitivity.of", "sensitivities are of peaks over the frequency; delete one of the two");
  refuse("accuracy.tolerance", "a mode has the harmonics that the case gives; write harmonic_balance.harmonics, and "
                               "reduction.modes");
  for (const char *key : {"recovery.strategies", "recovery.allow_branch_change", "recovery.work"})
    refuse(key, "a mode is followed by plain arc length; delete this key");
  if (study.samples != exactly)
    refuse("harmonic_balance.samples", "a mode takes exact contact forces; delete this key");
  if (!study.adaptive) refuse("continuation.adaptive", "a mode chooses its steps; delete this key");
  if (study.estimates) refuse("accuracy.estimates", "errors of a mode are not estimated; delete this key");
  if (study.stability.value_or(false)) refuse("stability.enabled", "a mode has no stability; delete this key");
  study.estimates = false, study.stability = false;
}

} // namespace dovetail
