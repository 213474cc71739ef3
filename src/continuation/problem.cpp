#include "continuation/problem.hpp"

#include <algorithm>
#include <cmath>

#include "support/error.hpp"
#include "support/hash.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "measuring arc length";

// The part of a vector on this rank, without the parameter; read only.
class Own {
public:
  explicit Own(Vec y) : y_(y) {
    PetscInt all;
    check(VecGetSize(y, &all), doing);
    check(VecGetOwnershipRange(y, &first_, &end_), doing);
    has_parameter_ = end_ == all;
    check(VecGetArrayRead(y, &values_), doing);
  }
  ~Own() { VecRestoreArrayRead(y_, &values_); }
  Own(const Own &) = delete;
  Own &operator=(const Own &) = delete;

  PetscInt size() const { return end_ - first_ - (has_parameter_ ? 1 : 0); }
  PetscInt first() const { return first_; }
  double operator[](PetscInt i) const { return values_[i]; }
  double parameter() const { return has_parameter_ ? values_[size()] : 0; } // 0 on other ranks

private:
  Vec y_;
  PetscInt first_, end_;
  bool has_parameter_;
  const double *values_;
};

MPI_Comm comm_of(Vec y) { return PetscObjectComm(reinterpret_cast<PetscObject>(y)); }

// x by the largest met so far, the parameter by its unit.
class PlainMetric : public ArcLengthMetric {
public:
  PlainMetric(double unit, bool weighted) : unit_(weighted ? unit : 1), weighted_(weighted) {}

  double product(Vec a, Vec b) const override {
    const Own x(a), y(b);
    double sum = 0;
    for (PetscInt i = 0; i < x.size(); ++i) sum += x[i] * y[i];
    sum = sum * weight() + x.parameter() * y.parameter() / (unit_ * unit_);
    MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm_of(a));
    return sum;
  }
  void weigh(Vec t, Vec row) const override {
    const double p = parameter_of(t);
    check(VecCopy(t, row), doing);
    check(VecScale(row, weight()), doing);
    set_parameter(row, p / (unit_ * unit_));
  }
  double motion(Vec y) const override {
    const Own x(y);
    double sum = 0;
    for (PetscInt i = 0; i < x.size(); ++i) sum += x[i] * x[i];
    MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm_of(y));
    return std::sqrt(sum);
  }
  double largest_motion() const override { return largest_; }
  void see(Vec y) override { largest_ = std::max(largest_, motion(y)); }

private:
  double weight() const { return weighted_ && largest_ > 0 ? 1 / (largest_ * largest_) : 1; }

  double unit_, largest_ = 0;
  bool weighted_;
};

} // namespace

double ArcLengthMetric::length(Vec t) const { return std::sqrt(product(t, t)); }

std::unique_ptr<ArcLengthMetric> Problem::metric(double unit, bool weighted) const {
  return std::make_unique<PlainMetric>(unit, weighted);
}

std::array<double, Problem::projections> Problem::projected(Vec y) const {
  const Own x(y);
  std::array<double, projections> out{};
  out[0] = x.parameter();
  for (PetscInt i = 0; i < x.size(); ++i)
    for (int k = 1; k < projections; ++k) out[k] += pseudo_random(x.first() + i, 0, k) * x[i];
  MPI_Allreduce(MPI_IN_PLACE, out.data(), projections, MPI_DOUBLE, MPI_SUM, comm_of(y));
  return out;
}

double parameter_of(Vec y) {
  double value = Own(y).parameter();
  int size;
  MPI_Comm_size(comm_of(y), &size);
  MPI_Bcast(&value, 1, MPI_DOUBLE, size - 1, comm_of(y));
  return value;
}

// VecNorm remembers a norm that VecScale scales, which a restart does not know to the last bit.
double plain_length(Vec t) {
  PetscScalar square;
  check(VecDot(t, t, &square), doing);
  return std::sqrt(square);
}

void set_parameter(Vec f, double value) {
  PetscInt all, first, end;
  double *own;
  check(VecGetSize(f, &all), doing);
  check(VecGetOwnershipRange(f, &first, &end), doing);
  check(VecGetArray(f, &own), doing);
  if (end == all) own[end - first - 1] = value;
  check(VecRestoreArray(f, &own), doing);
}

double pseudo_random(std::size_t a, std::size_t b, std::size_t which) {
  return static_cast<double>(mix((a * 4096 + b) * 8 + which + 0x9e3779b97f4a7c15u) >> 11) / (1ll << 52) - 1;
}

} // namespace dovetail
