#include "modal/index_groups.hpp"

#include <cstdlib>

namespace dovetail {

std::vector<IndexGroup> groups_of(const TravellingWave &wave, int width) {
  std::vector<IndexGroup> groups;
  for (int h = 0; h <= wave.sectors / 2; ++h) {
    IndexGroup group;
    group.index = h, group.complex = h != 0;
    for (int k = 0; k <= width / 2; ++k) {
      const int index = wave.index(k), column = group.columns();
      if (std::abs(index) != h) continue;
      if (k == 0) {
        group.coefficients.push_back(0), group.partners.push_back(0), group.turns.push_back(0);
        continue;
      }
      const double sign = index < 0 ? -1 : 1;
      group.coefficients.insert(group.coefficients.end(), {cosine(k), sine(k)});
      group.partners.insert(group.partners.end(), {column + 1, column});
      group.turns.insert(group.turns.end(), {sign, -sign});
    }
    group.whole = !group.complex && group.columns() == width;
    if (group.columns() > 0) groups.push_back(std::move(group));
  }
  return groups;
}

} // namespace dovetail
