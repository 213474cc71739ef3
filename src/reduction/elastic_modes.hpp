#pragma once
// Fixed-interface modes (eq 15) with the factorisation of K_ee that is already there.
#include <string>
#include <vector>

#include "reduction/block_lanczos.hpp"
#include "reduction/clamped_solver.hpp"
#include "reduction/tall.hpp"

namespace dovetail {

struct ElasticModes {
  std::vector<double> squares; ///< (N_a) w^2, ascending [rad^2/s^2]
  Tall shapes;                 ///< (n_e, N_a) Phi^T M_ee Phi = I, largest entry positive
};

/// The `count` lowest modes of K_ee Phi = M_ee Phi diag(w^2), by the EPS of SLEPc that the options -modes_ choose.
/// `names` are numbers of the own rows that do not depend on how rows are spread over ranks. Collective.
/// InputError if a rigid-body motion is among them or M_ee is not positive.
ElasticModes elastic_modes(const ClampedSolver &solver, Mat K_ee, Mat M_ee, const std::vector<long> &names,
                           PetscInt count, const std::string &model_name);

/// Turns a mode so that its largest entry is positive; among equals, that of the row with the lowest name. `names` as
/// above, v their entries. Collective.
void fix_sign(MPI_Comm comm, const std::vector<long> &names, double *v);

/// How many w^2 of K_ee v = w^2 M_ee v lie below `square`: the negative pivots of K_ee - square M_ee. Collective.
PetscInt modes_below(Mat K_ee, Mat M_ee, double square);

/// Throws ComputeError if there are more modes below the last of `squares` than in it. Collective.
void check_none_missed(Mat K_ee, Mat M_ee, const std::vector<double> &squares);

} // namespace dovetail
