#pragma once
// What an earlier run left in the output directory: continued, or kept out of harm's way.
#include "app/voice.hpp"
#include "case/case.hpp"
#include "harmonic/harmonic_system.hpp"
#include "results/state_file.hpp"

namespace dovetail {

inline std::filesystem::path results_of(const Case &study) { return study.directory / "results.h5"; }
inline std::filesystem::path state_of(const Case &study) { return study.directory / "state.h5"; }

/// The run that --restart continues. Throws InputError if there is none, if it was another problem, or if its results
/// are not there. Each rank on its own.
SavedRun earlier_run(const Case &study, const std::vector<ContactPoint> &points, PetscInt dofs);

/// True if that run had come to a good end, and the case asks for no more.
bool nothing_left(const Case &study, const SavedRun &run);

/// Throws InputError unless the place where the run stood is a solution of `system`, which is so only for the same
/// model. Collective.
void check_place(HarmonicSystem &system, const Case &study, const BranchState &state);

/// Clears the output directory for a new run. Results of a run that was cut off are renamed, and this said: they may be
/// hours of work, and --restart forgotten. Rank 0 alone.
void clear_output(const Case &study, const Voice &voice);

} // namespace dovetail
