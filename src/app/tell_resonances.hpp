#pragma once
// Resonances in words: three lines of a run, the table of `dovetail modes`, and what is warned of.
#include <optional>
#include <string>
#include <vector>

#include "app/voice.hpp"
#include "results/summary.hpp"
#include "stuck/resonances.hpp"

namespace dovetail {

/// Of the model at its preload state; nothing, and why in words, where they cannot be computed. Collective.
std::optional<Resonances> try_resonances(const PreloadedModel &model, const Case &study, const Voice &voice);

/// A line for each state of the joint.
std::vector<std::string> in_lines(const Resonances &found, const Case &study);

/// The first ten modes of each.
std::string in_table(const Resonances &found, const Case &study);

/// What is wrong with the case, as far as the resonances tell.
std::vector<Warning> warnings_of(const Resonances &found, const Case &study);

/// What to say of a curve without a peak. Nothing where a resonance lies in the sweep, or `warnings_of` has said so.
std::optional<Warning> no_peak(const Resonances &found, const Case &study);

/// What is wrong with a curve, by its results file; `finished`: it came to a good end. Of one rank alone.
std::vector<Warning> warnings_of_curve(const std::optional<Resonances> &found, const Case &study,
                                       const std::vector<ContactPoint> &contact, bool finished);

} // namespace dovetail
