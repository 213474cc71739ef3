#include "problems/response_metric.hpp"

#include <algorithm>
#include <cmath>

#include "support/error.hpp"

namespace dovetail {

constexpr double least_motion = 0.02; // of the largest dof's: what moves less is weighed as if it moved so much

ResponseMetric::ResponseMetric(const Layout &layout, double omega_unit, bool weighted)
    : comm_(layout.comm), width_(layout.width), own_coefficients_(layout.own_coefficients()),
      owns_omega_(layout.owns_omega()), weighted_(weighted), omega_(omega_unit), dofs_(layout.own_dofs(), 0.0),
      weights_(layout.own_dofs(), 1.0) {}

double ResponseMetric::motion(Vec y) const {
  const double *own;
  check(VecGetArrayRead(y, &own), "measuring arc length");
  double sum = 0;
  for (PetscInt i = 0; i < own_coefficients_; ++i) sum += own[i] * own[i];
  check(VecRestoreArrayRead(y, &own), "measuring arc length");
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm_);
  return std::sqrt(sum);
}

void ResponseMetric::see(Vec y) {
  const double *own;
  check(VecGetArrayRead(y, &own), "measuring arc length");
  for (std::size_t d = 0; d < dofs_.size(); ++d) {
    double sum = 0;
    for (int i = 0; i < width_; ++i) sum += own[d * width_ + i] * own[d * width_ + i];
    dofs_[d] = std::max(dofs_[d], std::sqrt(sum));
  }
  check(VecRestoreArrayRead(y, &own), "measuring arc length");
  motion_ = std::max(motion_, motion(y));
  choose_weights();
}

void ResponseMetric::restore(double motion, std::vector<double> dofs) {
  motion_ = motion, dofs_ = std::move(dofs);
  choose_weights();
}

void ResponseMetric::choose_weights() {
  double largest = 0, count = static_cast<double>(dofs_.size());
  for (const double dof : dofs_) largest = std::max(largest, dof);
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, comm_);
  MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_DOUBLE, MPI_SUM, comm_);
  if (!weighted_ || motion_ == 0) return;
  for (std::size_t d = 0; d < dofs_.size(); ++d) {
    const double own = std::max(dofs_[d], least_motion * largest);
    weights_[d] = 0.5 / (motion_ * motion_) + 0.5 / (count * own * own);
  }
}

void ResponseMetric::weigh(Vec t, Vec row) const {
  check(VecCopy(t, row), "measuring arc length");
  if (!weighted_) return;
  double *own;
  check(VecGetArray(row, &own), "measuring arc length");
  for (PetscInt i = 0; i < own_coefficients_; ++i) own[i] *= weights_[i / width_];
  if (owns_omega_) own[own_coefficients_] /= omega_ * omega_;
  check(VecRestoreArray(row, &own), "measuring arc length");
}

double ResponseMetric::swing(Vec t) const {
  const double *own;
  check(VecGetArrayRead(t, &own), "measuring arc length");
  double sum = 0;
  for (PetscInt i = 0; i < own_coefficients_; ++i)
    if (i % width_ > 0) sum += weights_[i / width_] * own[i] * own[i];
  if (owns_omega_) sum += own[own_coefficients_] * own[own_coefficients_] / (weighted_ ? omega_ * omega_ : 1);
  check(VecRestoreArrayRead(t, &own), "measuring arc length");
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm_);
  return std::sqrt(sum);
}

double ResponseMetric::product(Vec a, Vec b) const {
  const double *x, *y;
  check(VecGetArrayRead(a, &x), "measuring arc length");
  check(VecGetArrayRead(b, &y), "measuring arc length");
  double parts[2] = {0, 0};
  for (PetscInt i = 0; i < own_coefficients_; ++i) parts[0] += weights_[i / width_] * x[i] * y[i];
  if (owns_omega_) parts[1] = x[own_coefficients_] * y[own_coefficients_];
  check(VecRestoreArrayRead(b, &y), "measuring arc length");
  check(VecRestoreArrayRead(a, &x), "measuring arc length");
  MPI_Allreduce(MPI_IN_PLACE, parts, 2, MPI_DOUBLE, MPI_SUM, comm_);
  return parts[0] + (weighted_ ? parts[1] / (omega_ * omega_) : parts[1]);
}

} // namespace dovetail
