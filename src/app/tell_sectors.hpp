#pragma once
// A sector in words: frequencies over nodal diameters, and what to look at.
#include "case/case.hpp"
#include "results/summary.hpp"
#include "stuck/sector_frequencies.hpp"
#include "support/units.hpp"

namespace dovetail {

/// A row for each nodal diameter with its lowest `shown` frequencies [Hz] under that heading.
std::string in_table(const std::string &heading, const SectorFrequencies &found, const Units &units,
                     std::size_t shown = 8);

/// A load of an engine order that is a standing wave after all.
std::vector<Warning> warnings_of_wave(const Case &study, int sectors);

} // namespace dovetail
