#include "app/tell_sectors.hpp"

#include <algorithm>
#include <cstdio>
#include <set>

#include "case/travelling_wave.hpp"
#include "stuck/resonances.hpp"

namespace dovetail {

std::string in_table(const std::string &heading, const SectorFrequencies &found, const Units &units,
                     std::size_t shown) {
  std::string out = heading + "\n  nodal diameter";
  char cell[32];
  for (std::size_t j = 0; j < std::min(shown, found[0].size()); ++j) {
    std::snprintf(cell, sizeof cell, " %11s", ("mode " + std::to_string(j + 1)).c_str());
    out += cell;
  }
  for (std::size_t h = 0; h < found.size(); ++h) {
    std::snprintf(cell, sizeof cell, "\n%16zu", h);
    out += cell;
    for (std::size_t j = 0; j < std::min(shown, found[h].size()); ++j) {
      std::snprintf(cell, sizeof cell, " %11.6g", units.hertz(found[h][j]));
      out += cell;
    }
  }
  return out;
}

std::vector<Warning> warnings_of_wave(const Case &study, int sectors) {
  std::vector<Warning> out;
  const std::vector<int> harmonics = driving_harmonics(study.loads);
  const TravellingWave wave = study.wave(sectors);
  const int order = wave.engine_order;
  if (sectors == 0 || order == 0 || harmonics.empty()) return out;
  const int k = study.mode ? 1 : harmonics.front(), h = wave.index(k);
  const auto stands = [&](int harmonic) { return wave.index(harmonic) == 0 || 2 * wave.index(harmonic) == sectors; };
  std::set<std::string> patterns;
  for (const LoadCourse &load : study.loads)
    if (std::any_of(load.fourier.begin() + std::min<std::size_t>(1, load.fourier.size()), load.fourier.end(),
                    [](double value) { return value != 0; }))
      patterns.insert(load.pattern);
  if (!stands(k) || !std::all_of(harmonics.begin(), harmonics.end(), stands) || patterns.size() != 1) return out;
  out.push_back({"standing_wave", "harmonic " + std::to_string(k) + " of the load is engine order " +
                                      std::to_string(k * order) + ", which on " + std::to_string(sectors) +
                                      " sectors is nodal diameter " + std::to_string(h) + ": a standing wave, " +
                                      (h == 0 ? "all sectors alike" : "neighbours in opposite phase") +
                                      "; engine orders " + std::to_string(order) + " and " + std::to_string(-order) +
                                      " have the same response"});
  return out;
}

} // namespace dovetail
