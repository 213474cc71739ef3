#pragma once
// Steps 4 and 5: scaling (docs/theory/equations.md, section 7), then the response curve, point by point into the file
// and on the screen.
#include <memory>

#include "app/voice.hpp"
#include "case/case.hpp"
#include "preload/contact_preload.hpp"
#include "results/state_file.hpp"
#include "results/status_file.hpp"
#include "results/summary.hpp"

namespace dovetail {

struct Followed {
  BranchStory story;
  int signal;         ///< that interrupted it, or 0
  bool kept = false;  ///< in results.h5: not so if there is no point, and an earlier run's results
  StateKeeper keeper; ///< still to be told that the run has ended: after the summary is written
};

/// The equations of the case, over what its curve is followed over. Collective.
std::unique_ptr<HarmonicSystem> harmonic_system(const Case &study, PreloadedModel preloaded, const Scales &scales,
                                                int harmonics, int samples);

/// What the case asks of the branch, in scaled numbers.
BranchSettings settings_of(const Case &study, const HarmonicSystem &system);

/// `earlier`: where to go on from, or null; `begin`: what the state file says of this run before its first step.
/// Collective.
Followed follow(const Case &study, PreloadedModel preloaded, ResultsFile &results, const SavedRun *earlier,
                SavedRun begin, Stages &stages, StatusFile &status, const Voice &voice);

} // namespace dovetail
