#pragma once
// SLEPc's EPS on K v = w^2 M v with the factors of K that are already there; options prefix modes_.
#include <string>
#include <vector>

#include "reduction/clamped_solver.hpp"
#include "reduction/elastic_modes.hpp"

namespace dovetail {

/// The `wanted` pairs with the lowest w^2, ascending, of any sign and length. `names` as in elastic_modes. Collective.
/// InputError if options contradict what is sought, or M is not positive; ComputeError if not all pairs converge.
ElasticModes lowest_pairs(const ClampedSolver &solver, Mat K, Mat M, const std::vector<long> &names, PetscInt wanted,
                          const std::string &model_name);

} // namespace dovetail
