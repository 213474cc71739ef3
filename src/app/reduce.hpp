#pragma once
// Steps 1 and 2 of a run: from the model in the case to the reduced model.
#include <functional>
#include <optional>

#include "app/voice.hpp"
#include "model/full_model.hpp"
#include "reduction/reduced_model.hpp"
#include "results/summary.hpp"

namespace dovetail {

/// The reduced model, from the file the case names, from `file` if that still fits the case, or computed and written
/// there; `figures` are set in the last case. Collective. InputError, where a force is needed also if no load of the
/// case pushes anywhere; ComputeError.
ReducedModel reduced_model(MPI_Comm comm, const Case &study, const std::filesystem::path &file, Stages &stages,
                           const Voice &voice, std::optional<ReductionFigures> &figures, bool need_force = true);

/// As many modes as the model has, of a sector in each nodal diameter. Each rank on its own. InputError.
PetscInt most_modes(const Case &study, const ModelHeader &header);

/// The reduced model that the case names. Collective. InputError, also where no load of the case pushes anywhere.
ReducedModel given_reduced_model(MPI_Comm comm, const Case &study);

/// Where the reduced file goes that results in its folder were computed from, when another takes its place.
std::filesystem::path old_reduced(const std::filesystem::path &file);

/// In words, what the reduction of the case's model will take. Reads the model and analyses its K_ee. `kept`: the
/// reduced model in `file`, if that still fits the case. `look` is shown the model. Collective. InputError;
/// ComputeError if it cannot fit.
std::string forecast_reduction(
    MPI_Comm comm, const Case &study, const std::filesystem::path &file, std::optional<ReducedModel> &kept,
    const std::function<void(const FullModel &)> &look = [](const FullModel &) {});

} // namespace dovetail
