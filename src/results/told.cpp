#include "results/told.hpp"

#include <cstdio>

namespace dovetail {

std::string Told::amplitude(int unknown, double amplitude) const {
  char number[32];
  std::snprintf(number, sizeof number, "%.7g", amplitude);
  return name(unknown) + ": " + number + behind_number(unit(unknown));
}

} // namespace dovetail
