#include "problems/needed_harmonics.hpp"

#include <petscsys.h>

#include <petscblaslapack.h>

#include <cmath>

#include "support/error.hpp"

namespace dovetail {

double closed_contact_frequency(const DenseModel &model) {
  PetscBLASInt n = model.dofs(), kind = 1, room = -1, info = 0;
  if (model.points == 0) return 0;
  std::vector<double> K = model.K, M = model.M, squares(n), work(1);
  for (int p = 0; p < model.points; ++p)
    for (int d = 0; d < 3; ++d) {
      const ContactPoint &point = model.contact[p];
      const std::size_t i = model.modes + 3 * p + d;
      K[i * n + i] += d == 2 ? point.kn : has_friction(point.law) ? point.kt[d] : 0;
    }
  for (const bool ask : {true, false}) {
    LAPACKsygv_(&kind, "V", "L", &n, K.data(), &n, M.data(), &n, squares.data(), work.data(), &room, &info);
    if (info != 0) return 0; // a mass matrix that is not positive definite has been refused before
    if (ask) room = static_cast<PetscBLASInt>(work[0]), work.resize(room);
  }
  for (int mode = n - 1; mode >= 0; --mode) { // K now holds the eigenvectors, M-normalised, one after the other
    const double *v = &K[static_cast<std::size_t>(mode) * n];
    double normal = 0; // share of the kinetic energy
    for (int p = 0; p < model.points; ++p) {
      const std::size_t i = model.modes + 3 * p + 2;
      for (int j = 0; j < n; ++j) normal += v[i] * model.M[i * n + j] * v[j];
    }
    if (normal > 0.5) return std::sqrt(std::max(0.0, squares[mode]));
  }
  return 0;
}

} // namespace dovetail
