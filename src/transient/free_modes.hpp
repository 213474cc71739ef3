#pragma once
// The structure without its contacts in its own modes, in which K, M and with them b K + a M are diagonal.
#include "harmonic/dense_model.hpp"

namespace dovetail {

/// q = shapes eta, shapes^T M shapes = 1, shapes^T K shapes = diag(w2), all of them kept: nothing is approximated.
///   eta'' + (b w2 + a) eta' + viscous eta' + w2 eta = sum of the loads - contact g
struct FreeModes {
  int count = 0;                ///< n
  std::vector<double> w2;       ///< (n) squares of the frequencies; 0 for a body held by its joint alone
  std::vector<double> shapes;   ///< (n modes, n dofs): q = sum of eta_i times row i
  std::vector<double> contact;  ///< (n modes, 3 points): the same, contact dofs only
  std::vector<LoadCase> loads;  ///< by mode
  std::vector<double> viscous;  ///< (n, n) shapes^T C shapes of what is not proportional, or empty
  std::vector<double> momentum; ///< (n modes, n dofs) shapes^T M: eta = momentum q
};

/// InputError if the mass matrix is not positive definite. ComputeError if damping is not viscous.
FreeModes free_modes(const DenseModel &model);

} // namespace dovetail
