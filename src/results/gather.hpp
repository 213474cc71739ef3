#pragma once
// From a results file to the ranks' scaled unknowns, and what ranks have in one place.
#include <vector>

#include "scaling/scaled_model.hpp"
#include "stuck/layout.hpp"

namespace dovetail {

/// Rank 0 gets the values of all ranks, in rank order; the others an empty vector. Collective.
std::vector<double> gather(MPI_Comm comm, const std::vector<double> &own);

/// Throws InputError unless the results file holds a point of a model with this many reduced dofs. Each rank on its
/// own.
void check_start(const std::filesystem::path &results, PetscInt dofs, const TravellingWave &wave);

/// Sets y to the coefficients of that point of a results file (each rank reads its own) whose Omega is nearest to
/// `omega` [rad/s]; harmonics beyond either side's H are dropped or zero. Collective; check_start first.
void start_from(const std::filesystem::path &results, double omega, const Layout &layout, const Scales &scales, Vec y);

} // namespace dovetail
