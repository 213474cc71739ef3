#include "problems/nonlinear_mode.hpp"

#include <cmath>

#include "problems/mode_jacobian.hpp"
#include "problems/mode_krylov.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "evaluating a mode";

} // namespace

NonlinearMode::NonlinearMode(HarmonicSystem &system)
    : system_(system), layout_(system.layout()), reference_(2 * layout_.own_dofs(), 0.0),
      q_(layout_.own_coefficients(), 0.0) {
  system_.damp_mass();
}

UniqueVec NonlinearMode::unknowns() const {
  UniqueVec y;
  check(VecCreateMPI(layout_.comm, layout_.own_coefficients() + (layout_.owns_omega() ? extra : 0),
                     layout_.dofs() * layout_.width + extra, y.out()),
        doing);
  check(VecSet(y, 0), doing);
  return y;
}

double NonlinearMode::sum(double own) const {
  MPI_Allreduce(MPI_IN_PLACE, &own, 1, MPI_DOUBLE, MPI_SUM, layout_.comm);
  return own;
}

ModeState NonlinearMode::evaluate(Vec y) {
  const double *own;
  check(VecGetArrayRead(y, &own), doing);
  double last[extra] = {};
  if (layout_.owns_omega()) std::copy_n(own + layout_.own_coefficients(), extra, last);
  MPI_Bcast(last, extra, MPI_DOUBLE, layout_.size - 1, layout_.comm);
  state_ = {last[0], last[1], std::pow(10, last[2])};
  for (std::size_t i = 0; i < q_.size(); ++i) q_[i] = own[i] * (i % layout_.width == 0 ? 1 : state_.amplitude);
  check(VecRestoreArrayRead(y, &own), doing);
  system_.evaluate(q_.data());
  return state_;
}

void NonlinearMode::motion(Vec x) const {
  double *own;
  check(VecGetArray(x, &own), doing);
  std::copy(q_.begin(), q_.end(), own);
  if (layout_.owns_omega()) own[layout_.own_coefficients()] = state_.omega;
  check(VecRestoreArray(x, &own), doing);
}

void NonlinearMode::residual(Vec y, Vec f) {
  evaluate(y);
  const double alpha = state_.amplitude;
  const std::vector<double> &heavy = system_.inertia_force();
  const int n = layout_.width, c = cosine(1), s = sine(1);
  double *out;
  double rows[2] = {0, 0}; // length of Psi_1, phase
  check(VecGetArray(f, &out), doing);
  system_.balance(structure(), 1, 0, out);
  for (PetscInt d = 0; d < layout_.own_dofs(); ++d) {
    for (int i = 1; i < n; ++i) out[d * n + i] /= alpha;
    rows[0] += (q_[d * n + c] * heavy[d * n + c] + q_[d * n + s] * heavy[d * n + s]) / (alpha * alpha);
    rows[1] += (reference_[2 * d] * q_[d * n + s] - reference_[2 * d + 1] * q_[d * n + c]) / alpha;
  }
  MPI_Allreduce(MPI_IN_PLACE, rows, 2, MPI_DOUBLE, MPI_SUM, layout_.comm);
  if (layout_.owns_omega()) {
    double *last = out + layout_.own_coefficients();
    last[0] = rows[0] - 1, last[1] = rows[1];
  }
  check(VecRestoreArray(f, &out), doing);
}

void NonlinearMode::refer_to(Vec y) {
  evaluate(y);
  const int n = layout_.width, c = cosine(1), s = sine(1);
  double square = 0;
  for (PetscInt d = 0; d < layout_.own_dofs(); ++d) {
    reference_[2 * d] = system_.inertia_force()[d * n + c];
    reference_[2 * d + 1] = system_.is_cyclic() ? system_.inertia_force()[d * n + s] : 0;
    square += reference_[2 * d] * q_[d * n + c] + reference_[2 * d + 1] * q_[d * n + s];
  }
  const double length = std::sqrt(sum(square));
  for (double &value : reference_) value /= length;
}

double NonlinearMode::along_reference(Vec y) {
  evaluate(y);
  const int n = layout_.width, c = cosine(1), s = sine(1);
  double along = 0, square = 0;
  for (PetscInt d = 0; d < layout_.own_dofs(); ++d) {
    along += reference_[2 * d] * q_[d * n + c] + reference_[2 * d + 1] * q_[d * n + s];
    square += system_.inertia_force()[d * n + c] * q_[d * n + c];
    if (system_.is_cyclic()) square += system_.inertia_force()[d * n + s] * q_[d * n + s];
  }
  return sum(along) / std::sqrt(sum(square));
}

std::unique_ptr<BorderedJacobian> NonlinearMode::jacobian() {
  if (system_.form() == LinearForm::modal) return std::make_unique<ModeKrylov>(*this, system_);
  return std::make_unique<ModeJacobian>(*this, system_);
}

} // namespace dovetail
