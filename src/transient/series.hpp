#pragma once
// Power series in time over one step, and where one of them first becomes negative.
#include <array>

namespace dovetail {

/// Terms up to t^order: some 2.5 radians of an oscillation to 1e-12, with the least work per radian.
constexpr int series_order = 20;
using Series = std::array<double, series_order + 1>;

/// Sum of c_k t^k.
double value(const Series &c, double t);

/// First t in [0, 1] where the sum of c_k t^k is below zero, however shortly; 2, or none before `limit`, if there is
/// none before it.
double first_below_zero(const Series &c, double limit = 2);

} // namespace dovetail
