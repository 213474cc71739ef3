#include "continuation/arc_norm.hpp"

#include <algorithm>
#include <cmath>

#include "support/error.hpp"

namespace dovetail {

ArcNorm::ArcNorm(const Layout &layout, double omega_unit, bool weighted)
    : own_coefficients_(layout.own_coefficients()), owns_omega_(layout.owns_omega()), weighted_(weighted),
      omega_(omega_unit), comm_(layout.comm) {}

double ArcNorm::motion(Vec y) const {
  const double *own;
  check(VecGetArrayRead(y, &own), "measuring arc length");
  double sum = 0;
  for (PetscInt i = 0; i < own_coefficients_; ++i) sum += own[i] * own[i];
  check(VecRestoreArrayRead(y, &own), "measuring arc length");
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm_);
  return std::sqrt(sum);
}

void ArcNorm::see(Vec y) { motion_ = std::max(motion_, motion(y)); }

void ArcNorm::weigh(Vec t, Vec row) const {
  check(VecCopy(t, row), "measuring arc length");
  if (!weighted_) return;
  const double motion = motion_ > 0 ? 1 / (motion_ * motion_) : 1;
  double *own;
  check(VecGetArray(row, &own), "measuring arc length");
  for (PetscInt i = 0; i < own_coefficients_; ++i) own[i] *= motion;
  if (owns_omega_) own[own_coefficients_] /= omega_ * omega_;
  check(VecRestoreArray(row, &own), "measuring arc length");
}

double ArcNorm::product(Vec a, Vec b) const {
  const double *x, *y;
  check(VecGetArrayRead(a, &x), "measuring arc length");
  check(VecGetArrayRead(b, &y), "measuring arc length");
  double parts[2] = {0, 0};
  for (PetscInt i = 0; i < own_coefficients_; ++i) parts[0] += x[i] * y[i];
  if (owns_omega_) parts[1] = x[own_coefficients_] * y[own_coefficients_];
  check(VecRestoreArrayRead(b, &y), "measuring arc length");
  check(VecRestoreArrayRead(a, &x), "measuring arc length");
  MPI_Allreduce(MPI_IN_PLACE, parts, 2, MPI_DOUBLE, MPI_SUM, comm_);
  if (!weighted_) return parts[0] + parts[1];
  return (motion_ > 0 ? parts[0] / (motion_ * motion_) : parts[0]) + parts[1] / (omega_ * omega_);
}

double ArcNorm::length(Vec t) const { return std::sqrt(product(t, t)); }

} // namespace dovetail
