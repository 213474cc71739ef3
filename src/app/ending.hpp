#pragma once
// How a sweep ended, in words for the user.
#include <string>

#include "analyses/branch.hpp"
#include "case/case.hpp"

namespace dovetail {

/// Empty when it arrived. `signal`: the one that interrupted it, or 0.
std::string in_words(const BranchSummary &summary, const Case &study, const Units &units, double frequency_scale,
                     int signal);

} // namespace dovetail
