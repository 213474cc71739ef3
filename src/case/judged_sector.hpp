#pragma once
// How large a sector may be whose travelling waves are judged for their stability.
#include "case/case.hpp"

namespace dovetail {

constexpr int most_judged_of_sector = 2500; ///< unknowns of contact points, 3 N_x (2H+1): 100 MB

/// InputError where the case wants stability of a larger one.
void check_stability(const Case &study, int points, int sectors);

} // namespace dovetail
