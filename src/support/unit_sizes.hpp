#pragma once
#include <optional>
#include <string>

namespace dovetail {

/// How large the units of a label are, in those of the SI.
struct UnitSizes {
  double metres, kilograms, seconds;
};

/// Nothing where units_of(label) is nothing.
std::optional<UnitSizes> unit_sizes_of(const std::string &label);

} // namespace dovetail
