#pragma once
// What a case may have changed in when a run is continued (--restart), and what not.
#include <string>
#include <vector>

#include "case/case.hpp"

namespace dovetail {

/// The settings that say what is computed, one "key = value" a line: the same for two cases that pose the same problem,
/// however they are written. Without the model itself, whose file may have moved.
std::string problem_of(const Case &study, const std::vector<ContactPoint> &points);

/// The settings that say how far a run goes, likewise. They may change; while they do not, a run that had come to a
/// good end has nothing left to do.
std::string limits_of(const Case &study);

/// Throws InputError naming the first setting in which the problem is not `saved`, as problem_of() gave it.
void refuse_other_problem(const Case &study, const std::vector<ContactPoint> &points, const std::string &saved);

} // namespace dovetail
