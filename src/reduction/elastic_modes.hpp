#pragma once
// Fixed-interface modes (eq 15) by SLEPc, with the factorisation of K_ee that is already there.
#include <vector>

#include "reduction/clamped_solver.hpp"

namespace dovetail {

struct ElasticModes {
  std::vector<double> squares;   ///< (N_a) w^2, ascending [rad^2/s^2]
  std::vector<UniqueVec> shapes; ///< (N_a) of (n_e), Phi^T M_ee Phi = I, largest entry positive
};

/// The `count` lowest modes. Collective. InputError if a rigid-body motion is among them.
ElasticModes elastic_modes(const ClampedSolver &solver, Mat K_ee, Mat M_ee, PetscInt count,
                           const std::string &model_name);

} // namespace dovetail
