#include "problems/response_metric.hpp"

#include <algorithm>
#include <cmath>

#include "support/error.hpp"

namespace dovetail {

constexpr double least_motion = 0.02; // of the largest dof's: what moves less is weighed as if it moved so much

ResponseMetric::ResponseMetric(const Layout &layout, double omega_unit, bool weighted)
    : comm_(layout.comm), width_(layout.width), own_coefficients_(layout.own_coefficients()), all_dofs_(layout.dofs()),
      owns_omega_(layout.owns_omega()), weighted_(weighted), omega_(omega_unit), dofs_(layout.own_dofs(), 0.0),
      weights_(layout.own_dofs(), 1.0) {}

double ResponseMetric::square(Vec y) const {
  const double *own;
  check(VecGetArrayRead(y, &own), "measuring arc length");
  double sum = 0;
  for (PetscInt i = 0; i < own_coefficients_; ++i) sum += own[i] * own[i];
  check(VecRestoreArrayRead(y, &own), "measuring arc length");
  return sum;
}

void ResponseMetric::see(Vec y) {
  std::vector<Problem::Projected> none;
  see(y, nullptr, none);
}

// Sums and a maximum by one message: what all ranks have, on all.
ResponseMetric::Lengths ResponseMetric::see(Vec y, Vec way, std::vector<Problem::Projected> &sums) {
  note(y);
  const std::array<double, 2> squares = way ? squares_of(way) : std::array<double, 2>{};
  std::vector<double> own{largest_of_own(), square(y), squares[0], squares[1]};
  for (const Problem::Projected &of : sums) own.insert(own.end(), of.begin(), of.end());
  std::vector<double> sum = own;
  int size;
  MPI_Comm_size(comm_, &size);
  std::vector<double> all(size * own.size());
  const int count = static_cast<int>(own.size());
  MPI_Allgather(own.data(), count, MPI_DOUBLE, all.data(), count, MPI_DOUBLE, comm_);
  for (std::size_t i = 0; i < own.size(); ++i) {
    sum[i] = 0;
    for (int r = 0; r < size; ++r) sum[i] = i == 0 ? std::max(sum[i], all[r * count]) : sum[i] + all[r * count + i];
  }
  auto from = sum.begin() + 4;
  for (Problem::Projected &of : sums) std::copy_n(from, of.size(), of.begin()), from += of.size();
  motion_ = std::max(motion_, std::sqrt(sum[1]));
  choose_weights(sum[0]);
  return {std::sqrt(sum[2] + sum[3]), std::sqrt(sum[3])};
}

double ResponseMetric::largest_of_own() const {
  return dofs_.empty() ? 0 : *std::max_element(dofs_.begin(), dofs_.end());
}

// The largest motion of each own dof.
void ResponseMetric::note(Vec y) {
  const double *own;
  check(VecGetArrayRead(y, &own), "measuring arc length");
  for (std::size_t d = 0; d < dofs_.size(); ++d) {
    double sum = 0;
    for (int i = 0; i < width_; ++i) sum += own[d * width_ + i] * own[d * width_ + i];
    dofs_[d] = std::max(dofs_[d], std::sqrt(sum));
  }
  check(VecRestoreArrayRead(y, &own), "measuring arc length");
}

void ResponseMetric::restore(double motion, std::vector<double> dofs) {
  motion_ = motion, dofs_ = std::move(dofs);
  double largest = largest_of_own();
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, comm_);
  choose_weights(largest);
}

// `largest`: motion of any dof.
void ResponseMetric::choose_weights(double largest) {
  if (!weighted_ || motion_ == 0) return;
  for (std::size_t d = 0; d < dofs_.size(); ++d) {
    const double own_motion = std::max(dofs_[d], least_motion * largest);
    weights_[d] = 0.5 / (motion_ * motion_) + 0.5 / (static_cast<double>(all_dofs_) * own_motion * own_motion);
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

// Of a way: of mean values, of the rest; this rank's part.
std::array<double, 2> ResponseMetric::squares_of(Vec way) const {
  const double *own;
  check(VecGetArrayRead(way, &own), "measuring arc length");
  std::array<double, 2> sums{};
  for (PetscInt i = 0; i < own_coefficients_; ++i) sums[i % width_ > 0] += weights_[i / width_] * own[i] * own[i];
  if (owns_omega_) sums[1] += own[own_coefficients_] * own[own_coefficients_] / square_of_unit();
  check(VecRestoreArrayRead(way, &own), "measuring arc length");
  return sums;
}

std::vector<double> ResponseMetric::products(const std::vector<Pair> &pairs, const std::vector<Vec> &moving,
                                             const std::vector<Vec> &known) const {
  std::vector<double> sums;
  for (const auto &[a, b] : pairs) {
    const double *x, *y;
    check(VecGetArrayRead(a, &x), "measuring arc length");
    check(VecGetArrayRead(b, &y), "measuring arc length");
    double sum = 0;
    for (PetscInt i = 0; i < own_coefficients_; ++i) sum += weights_[i / width_] * x[i] * y[i];
    if (owns_omega_) sum += x[own_coefficients_] * y[own_coefficients_] / square_of_unit();
    check(VecRestoreArrayRead(b, &y), "measuring arc length");
    check(VecRestoreArrayRead(a, &x), "measuring arc length");
    sums.push_back(sum);
  }
  for (const Vec y : moving) sums.push_back(square(y));
  for (const Vec y : known) {
    const double *own;
    check(VecGetArrayRead(y, &own), "measuring arc length");
    sums.push_back(owns_omega_ ? own[own_coefficients_] : 0);
    check(VecRestoreArrayRead(y, &own), "measuring arc length");
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, comm_);
  for (std::size_t i = 0; i < known.size(); ++i) note_parameter(known[i], sums[pairs.size() + moving.size() + i]);
  return sums;
}

} // namespace dovetail
