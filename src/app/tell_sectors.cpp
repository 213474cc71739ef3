#include "app/tell_sectors.hpp"

#include <algorithm>
#include <cstdio>

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

} // namespace dovetail
