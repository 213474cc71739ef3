#include "problems/estimator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/law_traits.hpp"
#include "contact/samples.hpp"
#include "harmonic/dense_model.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "estimating errors";
constexpr double accuracy = 0.2; // of the linear solve, relative; with 1e-2 estimates are the same to a few per cent,
constexpr double accuracy_of_sectors = 1e-2; // where 0.2 left 0.4 of the estimate, with contacts that open (EO 2)
constexpr double few = 2;                    // iterations expected, where few contacts move

// Those of any rank count. Collective.
bool has_cones(const HarmonicSystem &system) {
  const std::vector<ContactPoint> &points = system.scaled().model.contact;
  int some = std::any_of(points.begin(), points.end(), [](const ContactPoint &p) { return shares_slider(p.law); });
  MPI_Allreduce(MPI_IN_PLACE, &some, 1, MPI_INT, MPI_LOR, system.layout().comm);
  return some != 0;
}

// Exact forces; of cones, which have none, from twice as many samples: three quarters of the error, which goes with
// 1/N^2, show.
int finer_samples(const HarmonicSystem &system, int finer) {
  if (!has_cones(system)) return exactly;
  return exactly_with_cones(
      std::max(2 * samples_of_cones(system.samples(), system.harmonics()), enough_samples(finer)));
}

// With one harmonic, two would show nothing of friction that is alike in both directions.
int finer_harmonics(int harmonics) { return std::max(2 * harmonics, harmonics + 2); }

} // namespace

double swing_product(const Layout &layout, Vec a, Vec b) {
  const double *x, *y;
  double sum = 0;
  check(VecGetArrayRead(a, &x), doing);
  check(VecGetArrayRead(b, &y), doing);
  for (PetscInt i = 0; i < layout.own_coefficients(); ++i)
    if (i % layout.width != 0) sum += x[i] * y[i];
  check(VecRestoreArrayRead(b, &y), doing);
  check(VecRestoreArrayRead(a, &x), doing);
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, layout.comm);
  return sum;
}

Estimator::Estimator(const HarmonicSystem &system, double omega_unit, double negligible)
    : omega_unit_(omega_unit), negligible_(negligible), system_(&system) {
  const int finer = finer_harmonics(system.harmonics());
  build(HarmonicSystem::modal(system, finer, finer_samples(system, finer)));
}

void Estimator::match(const HarmonicSystem &system) {
  system_ = &system;
  const int finer = finer_harmonics(system.harmonics());
  build(std::make_unique<HarmonicSystem>(*finer_, finer, finer_samples(system, finer)));
}

void Estimator::build(std::unique_ptr<HarmonicSystem> finer) {
  finer_ = std::move(finer);
  ksp_ = {}, jacobian_ = finer_->matrix();
  for (UniqueVec *v : {&y_, &t_, &row_, &residual_, &correction_}) *v = finer_->unknowns();
  check(KSPCreate(finer_->layout().comm, ksp_.out()), doing);
  finer_->set_up(ksp_, jacobian_);
  check(KSPSetTolerances(ksp_, finer_->is_cyclic() ? accuracy_of_sectors : accuracy, PETSC_DEFAULT, PETSC_DEFAULT,
                         PETSC_DEFAULT),
        doing);
}

ErrorEstimate Estimator::operator()(Vec y, Vec t) {
  const Layout &layout = finer_->layout();
  const PetscInt count = layout.own_coefficients();
  const int n = layout.width, known = system_->layout().width;
  pad(system_->layout(), y, layout, y_);
  pad(system_->layout(), t, layout, t_);
  ErrorEstimate found;
  motion_ = size(y_);
  if (motion_ == 0) {
    found.content.assign(n / 2 + 1, 0.0);
    return found;
  }

  PetscReal residual;
  check(VecSet(residual_, 0), doing);
  finer_->residual(y_, residual_);
  check(VecNorm(residual_, NORM_2, &residual), doing);
  if (residual < negligible_) { // as where contacts stick or are open all round
    measure_content(found);
    return found;
  }

  double *row;
  const double *tangent;
  check(VecGetArrayRead(t_, &tangent), doing);
  check(VecGetArray(row_, &row), doing);
  for (PetscInt i = 0; i < count; ++i) row[i] = i % n == 0 ? 0 : tangent[i] / motion_;
  if (layout.owns_omega()) row[count] = tangent[count] * motion_ / (omega_unit_ * omega_unit_);
  check(VecRestoreArray(row_, &row), doing);
  check(VecRestoreArrayRead(t_, &tangent), doing);

  finer_->begin_solves(jacobian_, few, true);
  finer_->jacobian(y_, row_, jacobian_);
  check(KSPSetOperators(ksp_, jacobian_, jacobian_), doing);
  if (finer_->samples() == exactly && system_->samples() == exactly) {
    found.harmonics = correct();
  } else { // what is left out, then what is wrong in the harmonics that are there: each to its own accuracy
    UniqueVec both = finer_->unknowns();
    check(VecCopy(residual_, both), doing);
    for (const bool left_out : {true, false}) {
      double *r;
      check(VecCopy(both, residual_), doing);
      check(VecGetArray(residual_, &r), doing);
      for (PetscInt i = 0; i < count; ++i)
        if ((i % n >= known) != left_out) r[i] = 0;
      check(VecRestoreArray(residual_, &r), doing);
      (left_out ? found.harmonics : found.sampling) = correct();
    }
  }
  measure_content(found);
  work_ += finer_->take_solver_work(jacobian_), inexact_ += finer_->take_effort(jacobian_, 0).inexact;
  return found;
}

void Estimator::measure_content(ErrorEstimate &found) const {
  const Layout &layout = finer_->layout();
  const int n = layout.width;
  std::vector<double> squares(n / 2 + 1);
  const double *q;
  check(VecGetArrayRead(y_, &q), doing);
  for (PetscInt i = 0; i < layout.own_coefficients(); ++i) squares[(i % n + 1) / 2] += q[i] * q[i];
  check(VecRestoreArrayRead(y_, &q), doing);
  MPI_Allreduce(MPI_IN_PLACE, squares.data(), n / 2 + 1, MPI_DOUBLE, MPI_SUM, layout.comm);
  for (const double square : squares) found.content.push_back(std::sqrt(square) / motion_);
}

double Estimator::correct() {
  KSPConvergedReason reason;
  check(KSPSolve(ksp_, residual_, correction_), doing);
  check(KSPGetConvergedReason(ksp_, &reason), doing);
  check(VecAXPY(y_, -1, correction_), doing);
  if (reason > 0) return std::hypot(size(correction_) / motion_, finer_->parameter_in(correction_) / omega_unit_);
  finer_->recover(ksp_, jacobian_);
  return std::numeric_limits<double>::quiet_NaN();
}

double Estimator::size(Vec y) const { return std::sqrt(swing_product(finer_->layout(), y, y)); }

} // namespace dovetail
