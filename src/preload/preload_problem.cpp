#include "preload/preload_problem.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "support/mumps.hpp"

namespace dovetail {
namespace {

constexpr double holding_friction = 1000; // times its own, with which closed points stick
constexpr double smallest_ratio = 1.001;  // of friction, from one step to the next

} // namespace

PreloadProblem::PreloadProblem(const ReducedModel &model, const std::vector<ContactPoint> &contact)
    : model_(model), contact_(contact) {
  const PetscInt own = model.own_contact_dofs(), all = model.contact_dofs(), first = 3 * model.own_points.begin;
  std::vector<PetscInt> columns(all);
  for (PetscInt j = 0; j < all; ++j) columns[j] = j;
  for (UniqueMat *A : {&stiffness_, &jacobian_}) {
    check(MatCreateAIJ(model.comm, own, own, all, all, all, nullptr, all, nullptr, A->out()), "contact preload");
    check(MatSetOption(*A, MAT_IGNORE_OFF_PROC_ENTRIES, PETSC_TRUE), "contact preload");
    for (PetscInt i = 0; i < own; ++i) {
      const PetscInt row = first + i;
      check(
          MatSetValues(*A, 1, &row, all, columns.data(), &model.kxx[static_cast<std::size_t>(i) * all], INSERT_VALUES),
          "contact preload");
    }
    check(MatAssemblyBegin(*A, MAT_FINAL_ASSEMBLY), "contact preload");
    check(MatAssemblyEnd(*A, MAT_FINAL_ASSEMBLY), "contact preload");
  }
  check(MatCreateVecs(stiffness_, residual_.out(), nullptr), "contact preload");
  check(SNESCreate(model.comm, snes_.out()), "contact preload");
  check(SNESSetOptionsPrefix(snes_, "preload_"), "contact preload");
  check(SNESSetFunction(snes_, residual_, &residual, this), "contact preload");
  check(SNESSetJacobian(snes_, jacobian_, jacobian_, &jacobian, this), "contact preload");
  check(SNESSetTolerances(snes_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, 60, 10000), "contact preload");
  check(SNESSetConvergenceTest(snes_, &converged, this, nullptr), "contact preload");
  KSP ksp;
  check(SNESGetKSP(snes_, &ksp), "contact preload");
  factor_by_lu(ksp, jacobian_);
  SNESLineSearch search;
  check(SNESGetLineSearch(snes_, &search), "contact preload");
  check(SNESLineSearchSetType(search, SNESLINESEARCHBASIC), "contact preload");
  check(SNESSetFromOptions(snes_), "contact preload");
}

UniqueVec PreloadProblem::unknown() const {
  UniqueVec x;
  check(VecDuplicate(residual_, x.out()), "contact preload");
  return x;
}

// Newton from x, which is left alone unless it converges. The tolerance is relative to the forces at work.
bool PreloadProblem::solve(Vec x, double load, bool stuck) {
  load_ = load, stuck_ = stuck, before_ = INFINITY;
  UniqueVec trial = unknown();
  check(VecCopy(x, trial), "contact preload");
  const PetscErrorCode code = SNESSolve(snes_, nullptr, trial);
  courier_.rethrow();
  check(code, "contact preload");
  SNESConvergedReason reason;
  check(SNESGetConvergedReason(snes_, &reason), "contact preload");
  if (reason == SNES_DIVERGED_LINEAR_SOLVE) {
    KSP ksp;
    check(SNESGetKSP(snes_, &ksp), "contact preload");
    recover_lu(ksp, jacobian_);
  }
  if (reason > 0) check(VecCopy(trial, x), "contact preload");
  return reason > 0;
}

// At the tolerance, or where round-off holds the residual above it: there Newton repeats itself.
PetscErrorCode PreloadProblem::converged(SNES, PetscInt, PetscReal, PetscReal, PetscReal f, SNESConvergedReason *reason,
                                         void *context) {
  auto &self = *static_cast<PreloadProblem *>(context);
  const double before = std::exchange(self.before_, f);
  *reason = SNES_CONVERGED_ITERATING;
  if (!std::isfinite(f))
    *reason = SNES_DIVERGED_FNORM_NAN;
  else if (f <= 1e-13 * self.force_ || (f <= 1e-10 * self.force_ && f > before / 2))
    *reason = SNES_CONVERGED_FNORM_ABS;
  return 0;
}

PetscErrorCode PreloadProblem::residual(SNES, Vec x, Vec f, void *context) {
  auto &self = *static_cast<PreloadProblem *>(context);
  return self.courier_.run([&] {
    check(MatMult(self.stiffness_, x, f), "contact preload");
    const double *at;
    double *out, force = 0; // of R, and of the springs of the points that are closed
    check(VecGetArrayRead(x, &at), "contact preload");
    check(VecGetArray(f, &out), "contact preload");
    for (std::size_t p = 0; p < self.contact_.size(); ++p) {
      const StaticForce g = self.law(p, at + 3 * p);
      for (int d = 0; d < 3; ++d) {
        const double load = self.load_ * self.model_.r[3 * p + d];
        out[3 * p + d] += g.force[d] + load;
        force += load * load;
      }
      // An open point's spring is not at work, however far it is from closing.
      if (g.slope[2][2] > 0) force += std::pow(self.contact_[p].kn * self.contact_[p].gap, 2);
    }
    MPI_Allreduce(MPI_IN_PLACE, &force, 1, MPI_DOUBLE, MPI_SUM, self.model_.comm);
    self.force_ = std::max(std::sqrt(force), 1e-287);
    check(VecRestoreArray(f, &out), "contact preload");
    check(VecRestoreArrayRead(x, &at), "contact preload");
  });
}

PetscErrorCode PreloadProblem::jacobian(SNES, Vec x, Mat J, Mat, void *context) {
  auto &self = *static_cast<PreloadProblem *>(context);
  return self.courier_.run([&] {
    check(MatCopy(self.stiffness_, J, SAME_NONZERO_PATTERN), "contact preload");
    const double *at;
    check(VecGetArrayRead(x, &at), "contact preload");
    for (std::size_t p = 0; p < self.contact_.size(); ++p) {
      const StaticForce g = self.law(p, at + 3 * p);
      const PetscInt first = 3 * (self.model_.own_points.begin + static_cast<PetscInt>(p));
      const PetscInt rows[] = {first, first + 1, first + 2};
      check(MatSetValues(J, 3, rows, 3, rows, g.slope[0].data(), ADD_VALUES), "contact preload");
    }
    check(VecRestoreArrayRead(x, &at), "contact preload");
    check(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY), "contact preload");
    check(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY), "contact preload");
  });
}

StaticForce PreloadProblem::law(std::size_t p, const double *x) const {
  ContactPoint point = contact_[p];
  for (double &mu : point.mu) mu *= friction_;
  if (!stuck_) return static_force(point, x);
  StaticForce g;
  for (int d = 0; d < 2 && has_friction(point.law); ++d) g.force[d] = point.kt[d] * x[d], g.slope[d][d] = point.kt[d];
  g.force[2] = point.kn * (x[2] - point.gap), g.slope[2][2] = point.kn;
  return g;
}

bool PreloadProblem::load_in_steps(Vec x, double load) { // x: solution with the joint stuck, scaled along
  double reached = 0, step = 0.1;
  bool first = true;
  UniqueVec trial = unknown();
  while (reached < 1 && step > 1e-4) {
    const double next = std::min(1.0, reached + step);
    check(VecCopy(x, trial), "contact preload");
    if (first) check(VecScale(trial, next), "contact preload");
    if (solve(trial, next * load, false)) {
      check(VecCopy(trial, x), "contact preload");
      reached = next, step *= 2, first = false;
    } else {
      step /= 4;
    }
  }
  return reached == 1;
}

bool PreloadProblem::lower_friction(Vec x, double load) { // x: solution with the joint stuck
  double ratio = 4;
  friction_ = holding_friction;
  bool found = solve(x, load, false);
  while (found && friction_ > 1 && ratio > smallest_ratio) {
    const double before = std::exchange(friction_, std::max(1.0, friction_ / ratio));
    const bool on = solve(x, load, false);
    ratio = on ? ratio * ratio : std::sqrt(ratio);
    if (!on) friction_ = before;
  }
  found = found && friction_ == 1;
  friction_ = 1;
  return found;
}

bool PreloadProblem::find(Vec x, double load, std::string &note) {
  if (solve(x, load, false)) return true;
  UniqueVec stuck = unknown(), trial = unknown();
  check(VecCopy(x, stuck), "contact preload");
  if (!solve(stuck, load, true)) return false;
  const std::pair<const char *, std::function<bool()>> ways[] = {
      {"started again from the closed and sticking joint", [&] { return solve(trial, load, false); }},
      {"loaded in steps", [&] { return load_in_steps(trial, load); }},
      {"friction lowered in steps", [&] { return lower_friction(trial, load); }}};
  for (const auto &[how, finds] : ways) {
    check(VecCopy(stuck, trial), "contact preload");
    if (!finds()) continue;
    note = std::string("contact preload: plain Newton failed, ") + how;
    check(VecCopy(trial, x), "contact preload");
    return true;
  }
  return false;
}

void PreloadProblem::follow(Vec x, Vec change, Vec dx) {
  KSP ksp;
  check(SNESGetKSP(snes_, &ksp), "contact preload");
  check(jacobian(snes_, x, jacobian_, jacobian_, this), "contact preload");
  courier_.rethrow();
  check(KSPSetOperators(ksp, jacobian_, jacobian_), "contact preload");
  check(KSPSolve(ksp, change, dx), "contact preload");
  check(VecScale(dx, -1), "contact preload");
}

} // namespace dovetail
