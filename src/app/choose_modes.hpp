#pragma once
// How many modes the reduction keeps, where a tolerance decides and the case does not say.
#include "app/reduce.hpp"
#include "preload/contact_preload.hpp"

namespace dovetail {

/// Begins with the modes of an earlier run's reduced model in the output directory, else with a few. `most`: as many as
/// there are. Each rank on its own.
void first_modes(Case &study, PetscInt most);

/// Modes enough for the tolerance: a trial run along the whole curve, with few harmonics, whose points tell what
/// the modes left out do; where that is too much, a new reduction. Sets study.modes, `most` at most. Collective.
ReducedModel reduced_to_tolerance(MPI_Comm comm, Case &study, PetscInt most, const std::filesystem::path &file,
                                  const std::vector<ContactPoint> &contact, const std::vector<double> &initial,
                                  Stages &stages, const Voice &voice, std::optional<ReductionFigures> &figures);

} // namespace dovetail
