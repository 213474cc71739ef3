#pragma once
// Largest eigenvalues of K^-1 M by block Lanczos with full orthogonalisation and thick restart (Grimes, Lewis and
// Simon, SIAM J. Matrix Anal. Appl. 15 (1994); Wu and Simon, ibid. 22 (2000)).
#include <string>
#include <vector>

#include "reduction/clamped_solver.hpp"
#include "reduction/tall.hpp"

namespace dovetail {

struct LanczosPairs {
  std::vector<double> values; ///< of K^-1 M, largest magnitude first
  Tall vectors;               ///< (n, wanted), M-orthonormal
};

/// `start`: (n, block) without structure. `most`: columns of the basis, at least the lesser of n and wanted + 1 block,
/// and 3 blocks more. Fewer pairs than wanted come back only if M has no more. Collective. InputError if M is not
/// positive where it is met.
LanczosPairs block_lanczos(const ClampedSolver &solver, Mat M, Tall start, PetscInt wanted, PetscInt most,
                           const std::string &model_name);

} // namespace dovetail
