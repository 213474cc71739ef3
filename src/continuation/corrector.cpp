#include "continuation/corrector.hpp"

#include <algorithm>
#include <cmath>

#include "support/shell.hpp"

namespace dovetail {
namespace {

// Relative, of Newton's steps where the solver iterates: from this on it chooses itself.
constexpr double newton_accuracy = 0.5;
constexpr double rough_accuracy = 0.2; // relative, of corrections
constexpr const char *doing = "measuring rounding errors";
constexpr double falling = 0.5;    // of the residual before: one that does not may have come to its rounding errors
constexpr double room = 30;        // times those of last bits: the largest that rounding is held to leave,
constexpr double most_left = 1e-6; // and of the load: near a pole without damping any motion leaves more in the end
constexpr double again = 0.02;     // relative, residual and correction that were met before in the same solve

const char *in_words(SNESConvergedReason reason) {
  switch (reason) {
  case SNES_DIVERGED_MAX_IT:
    return "Newton did not converge within newton.max_iterations";
  case SNES_DIVERGED_FNORM_NAN:
    return "the residual became NaN or infinite";
  case SNES_DIVERGED_LINE_SEARCH:
    return "the line search found no descent";
  case SNES_DIVERGED_DTOL:
    return "Newton diverged";
  default:
    return SNESConvergedReasons[reason];
  }
}

} // namespace

Corrector::Corrector(Problem &problem, const NewtonSettings &settings)
    : problem_(problem), settings_(settings), jacobian_(problem.jacobian()), residual_(problem.unknowns()),
      trial_(problem.unknowns()), unit_(problem.unknowns()) {
  const Mat J = jacobian_->matrix();
  check(SNESCreate(PetscObjectComm(reinterpret_cast<PetscObject>(J)), snes_.out()), "setting up Newton");
  check(SNESSetOptionsPrefix(snes_, "hb_"), "setting up Newton");
  check(SNESSetFunction(snes_, residual_, &Corrector::residual, this), "setting up Newton");
  check(SNESSetJacobian(snes_, J, J, &Corrector::jacobian, this), "setting up Newton");
  check(SNESSetTolerances(snes_, 0, 0, 0, settings.max_iterations, 100000000), "setting up Newton");
  check(SNESSetConvergenceTest(snes_, &Corrector::converged, this, nullptr), "setting up Newton");
  KSP ksp;
  check(SNESGetKSP(snes_, &ksp), "setting up Newton");
  jacobian_->set_up(ksp);
  check(KSPSetTolerances(ksp, newton_accuracy, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "setting up Newton");
  SNESLineSearch search;
  SNESLineSearchType type;
  check(SNESGetLineSearch(snes_, &search), "setting up Newton");
  check(SNESLineSearchSetType(search, SNESLINESEARCHBASIC), "setting up Newton");
  check(SNESSetFromOptions(snes_), "setting up Newton");
  check(SNESLineSearchGetType(search, &type), "setting up Newton");
  usual_search_ = type;
  set_parameter(unit_, 1);
}

PetscErrorCode Corrector::residual(SNES, Vec y, Vec f, void *context) {
  auto &self = *static_cast<Corrector *>(context);
  return self.courier_.run(
      [&] { set_parameter(f, self.problem_.residual_and_plane(y, f, self.border_) - self.target_); });
}

PetscErrorCode Corrector::jacobian(SNES, Vec y, Mat, Mat, void *context) {
  auto &self = *static_cast<Corrector *>(context);
  return self.courier_.run([&] { self.jacobian_->assemble(y, self.border_); });
}

PetscErrorCode Corrector::converged(SNES, PetscInt it, PetscReal y, PetscReal dy, PetscReal f,
                                    SNESConvergedReason *reason, void *context) {
  auto &self = *static_cast<Corrector *>(context);
  const NewtonSettings &settings = self.settings_;
  const LinearEffort spent = self.jacobian_->take_effort(0);
  self.spent_.iterations += spent.iterations, self.spent_.inexact += spent.inexact;
  return self.courier_.run([&] {
    *reason = SNES_CONVERGED_ITERATING;
    if (dy < settings.step_tolerance * y && (f < settings.residual_tolerance || self.is_rounding(f)))
      *reason = SNES_CONVERGED_SNORM_RELATIVE;
    else if ((self.given_up_ = self.why_give_up(it, {f, dy})))
      *reason = SNES_DIVERGED_MAX_IT;
    self.iterates_.push_back({f, dy});
  });
}

// No more iterations lower it.
bool Corrector::is_rounding(double residual) {
  return residual < most_left && residual > falling * iterates_.back().residual && residual < room * rounding();
}

const char *Corrector::why_give_up(PetscInt iterations, const Iterate &now) const {
  if (effort_.most > 0 && iterations >= effort_.most) return "too many Newton iterations";
  if (effort_.exact && spent_.inexact > 0) return "linear solves leave more than was asked";
  if (effort_.steady && grows(now.residual)) return "Newton runs astray";
  if (effort_.reach > 0 && now.correction > effort_.reach) return "Newton runs far away";
  const auto met = [&now](const Iterate &then) {
    return std::abs(now.residual - then.residual) < again * now.residual &&
           std::abs(now.correction - then.correction) < again * now.correction;
  };
  return !effort_.line_search && std::any_of(iterates_.begin(), iterates_.end(), met) ? "Newton runs in a circle"
                                                                                      : nullptr;
}

// Twice in a row; the first iteration often leads out of rest.
bool Corrector::grows(double residual) const {
  const std::size_t known = iterates_.size();
  return known > 2 && residual > iterates_[known - 1].residual &&
         iterates_[known - 1].residual > iterates_[known - 2].residual;
}

// A factorisation without room gets more of it, and the solve a second chance: a wanted frequency has but one.
Corrector::Outcome Corrector::solve(Vec y, Vec border, double target, const NewtonEffort &effort) {
  bool lacked_memory = false;
  const Outcome first = solve_once(y, border, target, effort, lacked_memory);
  if (!lacked_memory) return first;
  Outcome second = solve_once(y, border, target, effort, lacked_memory);
  second.newton += first.newton, second.linear += first.linear, second.inexact += first.inexact;
  return second;
}

Corrector::Outcome Corrector::solve_once(Vec y, Vec border, double target, const NewtonEffort &effort,
                                         bool &lacked_memory) {
  border_ = border, target_ = target, effort_ = effort;
  iterates_.clear(), given_up_ = nullptr, spent_ = {};
  recall(memory());
  SNESLineSearch search;
  check(SNESGetLineSearch(snes_, &search), "Newton");
  if (effort.line_search) check(SNESLineSearchSetType(search, SNESLINESEARCHBT), "Newton");
  check(VecCopy(y, trial_), "Newton");
  const PetscErrorCode code = SNESSolve(snes_, nullptr, trial_);
  courier_.rethrow();
  check(code, "Newton");
  if (effort.line_search) check(SNESLineSearchSetType(search, usual_search_.c_str()), "Newton");
  Outcome outcome;
  SNESConvergedReason reason;
  PetscInt newton, linear;
  check(SNESGetConvergedReason(snes_, &reason), "Newton");
  check(SNESGetIterationNumber(snes_, &newton), "Newton");
  check(SNESGetLinearSolveIterations(snes_, &linear), "Newton");
  check(SNESGetFunctionNorm(snes_, &outcome.residual), "Newton");
  if (reason == SNES_DIVERGED_LINEAR_SOLVE) {
    KSP ksp;
    PC pc;
    PCFailedReason failed;
    check(SNESGetKSP(snes_, &ksp), "Newton");
    check(KSPGetPC(ksp, &pc), "Newton");
    check(PCGetFailedReason(pc, &failed), "Newton");
    lacked_memory = failed == PC_FACTOR_OUTMEMORY;
    outcome.why = jacobian_->recover(ksp);
  }
  outcome.converged = reason == SNES_CONVERGED_SNORM_RELATIVE;
  outcome.newton = static_cast<int>(newton);
  const LinearEffort spent = jacobian_->take_effort(static_cast<int>(linear));
  outcome.linear = spent.iterations + spent_.iterations, outcome.inexact = spent.inexact + spent_.inexact;
  if (outcome.converged)
    check(VecCopy(trial_, y), "Newton");
  else if (outcome.why.empty())
    outcome.why = given_up_ ? given_up_ : in_words(reason);
  return outcome;
}

double Corrector::rounding() {
  const UniqueVec moved = problem_.unknowns(), f = problem_.unknowns(), other = problem_.unknowns();
  PetscInt first, end;
  check(VecGetOwnershipRange(moved, &first, &end), doing);
  double largest = 0;
  problem_.residual_and_plane(trial_, f, border_);
  set_parameter(f, 0);
  for (const int turn : {1, 2, 4}) { // signs without order, and others where these cancel
    check(VecCopy(trial_, moved), doing);
    const Values own(moved);
    for (PetscInt i = first; i < end; ++i)
      own[i - first] = std::nextafter(own[i - first], std::copysign(PETSC_INFINITY, std::sin(turn * (i + 1))));
    problem_.residual_and_plane(moved, other, border_);
    set_parameter(other, 0);
    check(VecAXPY(other, -1, f), doing);
    PetscReal size;
    check(VecNorm(other, NORM_2, &size), doing);
    largest = std::max(largest, size);
  }
  problem_.residual_and_plane(trial_, f, border_); // Newton's method may go on from there
  return largest;
}

// One more solve with the factors of the last iteration.
Corrector::Direction Corrector::solve_again(Vec r, Vec x, double accuracy) {
  KSP ksp;
  KSPConvergedReason reason;
  PetscReal newtons;
  check(SNESGetKSP(snes_, &ksp), "computing a tangent");
  check(KSPGetTolerances(ksp, &newtons, nullptr, nullptr, nullptr), "computing a tangent");
  check(KSPSetTolerances(ksp, accuracy, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "computing a tangent");
  check(KSPSolve(ksp, r, x), "computing a tangent");
  check(KSPSetTolerances(ksp, newtons, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT), "computing a tangent");
  check(KSPGetConvergedReason(ksp, &reason), "computing a tangent");
  const LinearEffort effort = jacobian_->take_effort(0);
  return {reason > 0, 0, effort.iterations, effort.inexact};
}

Corrector::Direction Corrector::tangent(Vec t) {
  Direction direction = solve_again(unit_, t, tangent_accuracy);
  KSP ksp;
  check(SNESGetKSP(snes_, &ksp), "computing a tangent");
  if (direction.found) direction.sign = jacobian_->determinant_sign(ksp);
  return direction;
}

Corrector::Direction Corrector::correct(Vec r, Vec c) {
  const Direction direction = solve_again(r, c, rough_accuracy);
  if (direction.found) return direction;
  KSP ksp;
  check(SNESGetKSP(snes_, &ksp), "computing a correction");
  jacobian_->recover(ksp);
  return direction;
}

void Corrector::assemble(Vec y, Vec border) {
  KSP ksp;
  jacobian_->assemble(y, border);
  check(SNESGetKSP(snes_, &ksp), "taking a Jacobian");
  check(KSPSetOperators(ksp, jacobian_->matrix(), jacobian_->matrix()), "taking a Jacobian");
}

void Corrector::for_corrections(Vec y, Vec border) {
  jacobian_->begin(memory(), true);
  assemble(y, border);
}

Corrector::Direction Corrector::tangent_at(Vec y, Vec border, Vec t) {
  KSP ksp;
  check(SNESGetKSP(snes_, &ksp), "computing a tangent");
  assemble(y, border);
  const Direction direction = tangent(t);
  if (!direction.found) jacobian_->recover(ksp);
  return direction;
}

} // namespace dovetail
