#include "problems/mode_krylov.hpp"

#include <cmath>

#include "support/shell.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "solving with the Jacobian of a mode";
constexpr double more_damping = 0.05;    // of the preconditioner, as a damping ratio
constexpr double newton_accuracy = 1e-5; // relative
constexpr double inner_accuracy = 1e-4;  // of the preconditioner
constexpr double best_accuracy = 1e-12;  // that is asked for
constexpr int most_iterations = 200;

} // namespace

ModeKrylov::ModeKrylov(NonlinearMode &mode, HarmonicSystem &system)
    : mode_(mode), system_(system), layout_(system.layout()), border_(layout_), exact_(system.matrix()),
      damped_(system.matrix()), right_(system.unknowns()), answer_(system.unknowns()),
      none_(layout_.own_coefficients(), 0.0), last_(layout_.own_unknowns(), 0.0) {
  if (layout_.owns_omega()) last_.back() = 1;
  matrix_ = shell_matrix<&ModeKrylov::multiply>(layout_.comm, border_.own(), border_.all(), this, doing);
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
  shell_solver<&ModeKrylov::solve>(ksp, matrix_, this, doing);
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

void ModeKrylov::multiply(Vec x, Vec y) {
  const PetscInt count = layout_.own_coefficients();
  const int n = layout_.width;
  const ReadValues in(x);
  {
    const Values q(right_);
    for (PetscInt i = 0; i < count; ++i) q[i] = in[i] * (i % n ? alpha_ : 1);
    if (layout_.owns_omega()) q[count] = 0;
  }
  check(MatMult(exact_, right_, answer_), doing);
  const ReadValues force(answer_);
  const Values out(y);
  for (PetscInt i = 0; i < count; ++i) out[i] = force[i] / (i % n ? alpha_ : 1);
  border_.multiply(in, border_.last_of(in), out);
}

// x = J^-1 r with more damping, both in units of Psi; (own coefficients).
bool ModeKrylov::solve_damped(const double *r, double *x) {
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
  return true;
}

void ModeKrylov::precondition(Vec r, Vec x) {
  const ReadValues in(r);
  const Values out(x);
  border_.solve([this](const double *of, double *answer) { return solve_damped(of, answer); }, in, out);
}

void ModeKrylov::solve(Vec r, Vec x) {
  PetscReal asked;
  PetscInt count;
  KSPConvergedReason reason;
  check(KSPGetTolerances(outer_, &asked, nullptr, nullptr, nullptr), doing);
  if (asked >= 0.5) asked = newton_accuracy; // Newton's method leaves it open
  if (!std::exchange(eliminated_, true) &&
      !border_.eliminate([this](const double *of, double *answer) { return solve_damped(of, answer); }))
    ++effort_.inexact; // the preconditioner goes without the border
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
