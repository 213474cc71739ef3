#pragma once
// The harmonic of the load that drives a mode, and that a phase is measured against.
#include "harmonic/load_case.hpp"

namespace dovetail {

/// The lowest harmonic in which any load acts, 0 if all are constant.
inline int lowest_harmonic(const std::vector<LoadCase> &loads) {
  std::size_t lowest = 0;
  for (const LoadCase &load : loads)
    for (std::size_t place = 1; place < load.fourier.size(); ++place)
      if (const std::size_t k = (place + 1) / 2; load.fourier[place] != 0 && (lowest == 0 || k < lowest)) lowest = k;
  return static_cast<int>(lowest);
}

} // namespace dovetail
