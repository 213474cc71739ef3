#pragma once
// Frequencies over nodal diameters in words.
#include "case/case.hpp"
#include "harmonic/sector_frequencies.hpp"
#include "support/units.hpp"

namespace dovetail {

/// A row for each nodal diameter with its lowest `shown` frequencies [Hz] under that heading.
std::string in_table(const std::string &heading, const SectorFrequencies &found, const Units &units,
                     std::size_t shown = 8);

} // namespace dovetail
