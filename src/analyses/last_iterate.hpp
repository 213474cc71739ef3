#pragma once
// What Newton's method tells by where it stopped.
#include <string>

#include "problems/response_curve.hpp"

namespace dovetail {

/// Which contact point did something else at the last iterate than at the last point, in words that go on a sentence;
/// empty if none did. Collective.
std::string difference(const HarmonicSystem &system, const CurvePoint &here);

} // namespace dovetail
