#pragma once
// Steps 4 and 5 of a run of [mode]: scaling by the onset, then the mode over its amplitude.
#include "app/follow.hpp"
#include "stuck/stuck_mode.hpp"

namespace dovetail {

/// As follow(). Collective.
Followed follow_mode(const Case &study, PreloadedModel preloaded, const StuckMode &mode, ResultsFile &results,
                     const SavedRun *earlier, SavedRun begin, Stages &stages, StatusFile &status, const Voice &voice);

} // namespace dovetail
