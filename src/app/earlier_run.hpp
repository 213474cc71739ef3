#pragma once
// What an earlier run left in the output directory: continued, or kept out of harm's way.
#include "app/voice.hpp"
#include "case/case.hpp"
#include "problems/nonlinear_mode.hpp"
#include "results/state_file.hpp"

namespace dovetail {

inline std::filesystem::path results_of(const Case &study) { return study.directory / "results.h5"; }
inline std::filesystem::path state_of(const Case &study) { return study.directory / "state.h5"; }

/// The run that --restart continues. Throws InputError if there is none, if it was another problem, or if its results
/// are not there. Each rank on its own.
SavedRun earlier_run(const Case &study, const std::vector<ContactPoint> &points, PetscInt dofs);

/// Where it stands, in the user's units of what its curve is followed over.
double place_of(const Case &study, const SavedRun &run);

/// True if that run had come to a good end, and the case asks for no more.
bool nothing_left(const Case &study, const SavedRun &run);

/// Throws InputError unless the place where the run stood is a solution of `system`, which is so only for the same
/// model. Collective.
void check_place(HarmonicSystem &system, const Case &study, const BranchState &state);
/// The same of a nonlinear mode.
void check_place(NonlinearMode &mode, const Case &study, const BranchState &state);

/// What a new run finds in its folder. Results without a point go; others stay until make_room(), and where
/// their run was cut off, it is said what becomes of them: they may be hours of work, and --restart forgotten. Rank 0
/// alone.
void look_around(const Case &study, const Voice &voice);

/// To be called when the first point of a new run is about to take the place of what was there: results of a run that
/// was cut off, or is not known to have ended, are renamed. Rank 0 alone.
void make_room(const Case &study);

} // namespace dovetail
