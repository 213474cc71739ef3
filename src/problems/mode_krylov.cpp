#include "problems/mode_krylov.hpp"

#include <cmath>
#include <numeric>

#include "support/dense.hpp"
#include "support/shell.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "solving with the Jacobian of a mode";
constexpr int border = ModeBorder::width;
constexpr double more_damping = 0.05;    // of the preconditioner, as a damping ratio
constexpr double newton_accuracy = 1e-5; // relative
constexpr double inner_accuracy = 1e-4;  // of the preconditioner
constexpr double best_accuracy = 1e-12;  // that is asked for
constexpr int most_iterations = 200;

} // namespace

ModeKrylov::ModeKrylov(NonlinearMode &mode, HarmonicSystem &system)
    : mode_(mode), system_(system), layout_(system.layout()), exact_(system.matrix()), damped_(system.matrix()),
      right_(system.unknowns()), answer_(system.unknowns()), none_(layout_.own_coefficients(), 0.0),
      last_(layout_.own_unknowns(), 0.0) {
  const PetscInt own = layout_.own_coefficients() + (layout_.owns_omega() ? border : 0);
  if (layout_.owns_omega()) last_.back() = 1;
  matrix_ =
      shell_matrix<&ModeKrylov::multiply>(layout_.comm, own, layout_.dofs() * layout_.width + border, this, doing);
  check(KSPCreate(layout_.comm, in_modes_.out()), doing);
  check(KSPSetOptionsPrefix(in_modes_, "hb_mode_inner_"), doing);
  system_.set_up(in_modes_, damped_);
  check(KSPSetTolerances(in_modes_, inner_accuracy, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), doing);
  check(KSPCreate(layout_.comm, krylov_.out()), doing);
  check(KSPSetOptionsPrefix(krylov_, "hb_mode_"), doing);
  check(KSPSetOperators(krylov_, matrix_, matrix_), doing);
  check(KSPSetType(krylov_, KSPFGMRES), doing);
  check(KSPGMRESSetRestart(krylov_, most_iterations), doing);
  check(KSPSetPCSide(krylov_, PC_RIGHT), doing);
  shell_preconditioner<&ModeKrylov::precondition>(krylov_, this, doing);
  check(KSPSetFromOptions(krylov_), doing);
}

void ModeKrylov::set_up(KSP ksp) {
  outer_ = ksp;
  check(KSPSetOperators(ksp, matrix_, matrix_), doing);
  check(KSPSetType(ksp, KSPPREONLY), doing);
  shell_preconditioner<&ModeKrylov::solve>(ksp, this, doing);
}

void ModeKrylov::assemble(Vec y, Vec plane) {
  mode_.evaluate(y);
  border_.take(mode_, plane);
  alpha_ = mode_.state().amplitude;
  const DynamicStiffness damped(system_.scaled().damping, mode_.state().omega, mode_.state().ratio - more_damping);
  system_.fill(exact_, mode_.structure(), none_.data(), last_.data());
  system_.fill(damped_, damped, none_.data(), last_.data());
  eliminated_ = false;
}

std::array<double, 3> ModeKrylov::along_rows(const double *x) const {
  std::array<double, 3> sums{};
  for (int b = 0; b < border; ++b) sums[b] = std::inner_product(border_.rows[b].begin(), border_.rows[b].end(), x, 0.0);
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), border, MPI_DOUBLE, MPI_SUM, layout_.comm);
  return sums;
}

void ModeKrylov::multiply(Vec x, Vec y) {
  const PetscInt count = layout_.own_coefficients();
  const int n = layout_.width;
  const ReadValues in(x);
  double last[border] = {};
  if (layout_.owns_omega()) std::copy_n(in + count, border, last);
  MPI_Bcast(last, border, MPI_DOUBLE, layout_.size - 1, layout_.comm);
  {
    const Values q(right_);
    for (PetscInt i = 0; i < count; ++i) q[i] = in[i] * (i % n ? alpha_ : 1);
    if (layout_.owns_omega()) q[count] = 0;
  }
  check(MatMult(exact_, right_, answer_), doing);
  const ReadValues force(answer_);
  const Values out(y);
  for (PetscInt i = 0; i < count; ++i) {
    out[i] = force[i] / (i % n ? alpha_ : 1);
    for (int b = 0; b < border; ++b) out[i] += border_.columns[b][i] * last[b];
  }
  const std::array<double, 3> sums = along_rows(in);
  for (int b = 0; b < border && layout_.owns_omega(); ++b) out[count + b] = sums[b];
  for (int b = 0; b < border && layout_.owns_omega(); ++b) out[count + border - 1] += border_.corner[b] * last[b];
}

// x = J^-1 r with more damping, both in units of Psi; (own coefficients).
void ModeKrylov::solve_damped(const double *r, double *x) {
  const PetscInt count = layout_.own_coefficients();
  const int n = layout_.width;
  {
    const Values right(right_);
    for (PetscInt i = 0; i < count; ++i) right[i] = r[i] * (i % n ? alpha_ : 1);
    if (layout_.owns_omega()) right[count] = 0;
  }
  check(KSPSolve(in_modes_, right_, answer_), doing);
  const ReadValues q(answer_);
  for (PetscInt i = 0; i < count; ++i) x[i] = q[i] / (i % n ? alpha_ : 1);
}

// What the border's unknowns are left with: (corner - rows J^-1 columns)^-1.
void ModeKrylov::eliminate() {
  Dense left(border, border);
  for (int b = 0; b < border; ++b) {
    answers_[b].resize(layout_.own_coefficients());
    solve_damped(border_.columns[b].data(), answers_[b].data());
    const std::array<double, 3> sums = along_rows(answers_[b].data());
    for (int a = 0; a < border; ++a) left(a, b) = (a == border - 1 ? border_.corner[b] : 0) - sums[a];
  }
  eliminated_ = true;
  inverse_ = {};
  Factors factors;
  if (!factors.factor(left)) { // the preconditioner goes without the border
    ++effort_.inexact;
    return;
  }
  for (int b = 0; b < border; ++b) {
    std::vector<double> unit(border, 0.0);
    unit[b] = 1;
    factors.solve(unit.data());
    for (int a = 0; a < border; ++a) inverse_[a][b] = unit[a];
  }
}

void ModeKrylov::precondition(Vec r, Vec x) {
  const PetscInt count = layout_.own_coefficients();
  const ReadValues in(r);
  const Values out(x);
  double right[border] = {}, last[border] = {};
  if (layout_.owns_omega()) std::copy_n(in + count, border, right);
  MPI_Bcast(right, border, MPI_DOUBLE, layout_.size - 1, layout_.comm);
  solve_damped(in, out);
  const std::array<double, 3> sums = along_rows(out);
  for (int a = 0; a < border; ++a)
    for (int b = 0; b < border; ++b) last[a] += inverse_[a][b] * (right[b] - sums[b]);
  for (PetscInt i = 0; i < count; ++i)
    for (int b = 0; b < border; ++b) out[i] -= answers_[b][i] * last[b];
  if (layout_.owns_omega()) std::copy_n(last, border, out + count);
}

void ModeKrylov::solve(Vec r, Vec x) {
  PetscReal asked;
  PetscInt count;
  KSPConvergedReason reason;
  check(KSPGetTolerances(outer_, &asked, nullptr, nullptr, nullptr), doing);
  if (asked >= 0.5) asked = newton_accuracy; // Newton's method leaves it open
  if (!eliminated_) eliminate();
  check(KSPSetTolerances(krylov_, std::max(asked, best_accuracy), 0, 1e30, most_iterations), doing);
  check(KSPSolve(krylov_, r, x), doing);
  check(KSPGetIterationNumber(krylov_, &count), doing);
  check(KSPGetConvergedReason(krylov_, &reason), doing);
  effort_.iterations += static_cast<int>(count);
  if (reason <= 0) ++effort_.inexact;
}

LinearEffort ModeKrylov::take_effort(int) {
  system_.take_effort(damped_, 0);
  return std::exchange(effort_, {});
}

} // namespace dovetail
