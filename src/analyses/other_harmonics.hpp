#pragma once
// The same point of a response in a system with other harmonics.
#include <memory>
#include <optional>

#include "analyses/response.hpp"
#include "analyses/sweep_range.hpp"

namespace dovetail {

/// y in a system with other harmonics: what it does not have is left out, what it has besides is zero.
UniqueVec padded(const Layout &layout, Vec y, const HarmonicSystem &system);

struct MoveLimits {
  bool same_parameter; ///< the point stays where it is on the range, as a first point does
  int most_newton;     ///< iterations, and no second try with a line search; 0: the settings', and one
};
/// Nothing if there is no solution near, or only one of another branch. Nothing wanted is passed. Collective.
std::optional<CurvePoint> in_other_harmonics(const Response &response, HarmonicSystem &system, const SweepRange &range,
                                             const CurvePoint &here, const MoveLimits &limits);

} // namespace dovetail
