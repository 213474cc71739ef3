#include "continuation/problem.hpp"

#include <petsc/private/petscimpl.h> // data kept with an object

#include <algorithm>
#include <cmath>

#include "support/error.hpp"
#include "support/hash.hpp"
#include "support/shell.hpp"

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

std::vector<double> added_up(std::vector<double> sums, MPI_Comm comm) {
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, comm);
  return sums;
}

// x by the largest met so far, the parameter by its unit.
class PlainMetric : public ArcLengthMetric {
public:
  PlainMetric(double unit, bool weighted) : unit_(weighted ? unit : 1), weighted_(weighted) {}

  std::vector<double> products(const std::vector<Pair> &pairs, const std::vector<Vec> &moving,
                               const std::vector<Vec> &known) const override {
    std::vector<double> sums;
    for (const auto &[a, b] : pairs) {
      const Own x(a), y(b);
      double sum = 0;
      for (PetscInt i = 0; i < x.size(); ++i) sum += x[i] * y[i];
      sums.push_back(sum * weight() + x.parameter() * y.parameter() / (unit_ * unit_));
    }
    for (const Vec y : moving) sums.push_back(square(y));
    for (const Vec y : known) sums.push_back(Own(y).parameter());
    sums = added_up(std::move(sums), comm_of(pairs[0][0]));
    for (std::size_t i = 0; i < known.size(); ++i) note_parameter(known[i], sums[pairs.size() + moving.size() + i]);
    return sums;
  }
  void weigh(Vec t, Vec row) const override {
    const double p = parameter_of(t);
    check(VecCopy(t, row), doing);
    check(VecScale(row, weight()), doing);
    set_parameter(row, p / (unit_ * unit_));
  }
  double largest_motion() const override { return largest_; }
  void see(Vec y) override { largest_ = std::max(largest_, std::sqrt(added_up({square(y)}, comm_of(y))[0])); }

private:
  static double square(Vec y) { // of this rank's part of x
    const Own x(y);
    double sum = 0;
    for (PetscInt i = 0; i < x.size(); ++i) sum += x[i] * x[i];
    return sum;
  }
  double weight() const { return weighted_ && largest_ > 0 ? 1 / (largest_ * largest_) : 1; }

  double unit_, largest_ = 0;
  bool weighted_;
};

// What PETSc keeps with a vector until that changes, on all ranks alike.
class Kept {
public:
  // The number, if it is known: NaN is none.
  bool find(Vec y, double &value) {
    PetscBool known;
    check(PetscObjectComposedDataGetReal(reinterpret_cast<PetscObject>(y), place(), value, known), doing);
    return known && std::isfinite(value);
  }
  void note(Vec y, double value) {
    check(PetscObjectComposedDataSetReal(reinterpret_cast<PetscObject>(y), place(), value), doing);
  }
  void forget(Vec y) { note(y, std::nan("")); }

private:
  PetscInt place() {
    if (place_ < 0) check(PetscObjectComposedDataRegister(&place_), doing);
    return place_;
  }
  PetscInt place_ = -1;
} kept_parameter, kept_length;

} // namespace

double ArcLengthMetric::length(Vec t) const { return std::sqrt(product(t, t)); }

std::unique_ptr<ArcLengthMetric> Problem::metric(double unit, bool weighted) const {
  return std::make_unique<PlainMetric>(unit, weighted);
}

double Problem::residual_and_plane(Vec y, Vec f, Vec border) {
  double along;
  residual(y, f);
  check(VecDot(border, y, &along), "evaluating the arc-length equation");
  return along;
}

std::vector<Problem::Projected> Problem::projected(const std::vector<Vec> &of) const {
  std::vector<Projected> all = own_projected(of);
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(of.size()) * projections, MPI_DOUBLE, MPI_SUM,
                comm_of(of[0]));
  return all;
}

std::vector<Problem::Projected> Problem::own_projected(const std::vector<Vec> &of) const {
  std::vector<Projected> out(of.size());
  for (std::size_t v = 0; v < of.size(); ++v) {
    const Own x(of[v]);
    out[v][0] = x.parameter();
    for (PetscInt i = 0; i < x.size(); ++i)
      for (int k = 1; k < projections; ++k) out[v][k] += pseudo_random(x.first() + i, 0, k) * x[i];
  }
  return out;
}

void note_parameter(Vec y, double value) { kept_parameter.note(y, value); }

void scale_known(Vec y, double factor) {
  const double value = parameter_of(y);
  double length;
  const bool measured = kept_length.find(y, length);
  check(VecScale(y, factor), doing);
  note_parameter(y, factor * value);
  if (measured) note_plain_length(y, std::abs(factor) * length);
}

double parameter_of(Vec y) {
  double value;
  if (kept_parameter.find(y, value)) return value;
  value = Own(y).parameter();
  int size;
  MPI_Comm_size(comm_of(y), &size);
  MPI_Bcast(&value, 1, MPI_DOUBLE, size - 1, comm_of(y));
  note_parameter(y, value);
  return value;
}

void note_plain_length(Vec t, double length) { kept_length.note(t, length); }
void forget_plain_length(Vec t) { kept_length.forget(t); }

double plain_length(Vec t) {
  double length;
  if (kept_length.find(t, length)) return length;
  PetscScalar square;
  check(VecDot(t, t, &square), doing);
  length = std::sqrt(square);
  note_plain_length(t, length);
  return length;
}

void set_parameter(Vec f, double value) {
  PetscInt all, first, end;
  check(VecGetSize(f, &all), doing);
  check(VecGetOwnershipRange(f, &first, &end), doing);
  const Values own(f);
  if (end == all) own[end - first - 1] = value;
}

double pseudo_random(std::size_t a, std::size_t b, std::size_t which) {
  return static_cast<double>(mix((a * 4096 + b) * 8 + which + 0x9e3779b97f4a7c15u) >> 11) / (1ll << 52) - 1;
}

} // namespace dovetail
