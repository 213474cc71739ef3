#pragma once
// A small problem whose linear solver tells what it is asked for, and fails when it is told to.
#include <petscpc.h>

#include <vector>

#include "small_problems.hpp"

namespace dovetail::testing {

struct Told {
  std::vector<double> asked; ///< accuracies, of each solve
  std::vector<double> begun; ///< memories
  int solves = 0, recoveries = 0;
  double memory = 0;
  int fail_at = -1, fail_until = -1; ///< factorisations, from 0 on
  int spoil_at = -1;                 ///< solve, from 1 on, whose solution is not finite
  PCFailedReason reason = PC_FACTOR_OUTMEMORY;
  int factorisations = 0, pending = 0;
};

/// Each solve takes three iterations and is inexact, as it says.
class ToldJacobian : public SmallJacobian {
public:
  ToldJacobian(const Equations &equations, Told &told) : SmallJacobian(equations), told_(told) {}
  void set_up(KSP ksp) override {
    PC pc;
    check(KSPSetOperators(ksp, matrix_, matrix_), "");
    check(KSPSetType(ksp, KSPPREONLY), "");
    check(KSPSetPreSolve(ksp, &ToldJacobian::asked, this), "");
    check(KSPGetPC(ksp, &pc), "");
    check(PCSetType(pc, PCSHELL), "");
    check(PCShellSetContext(pc, this), "");
    check(PCShellSetSetUp(pc, &ToldJacobian::factor), "");
    check(PCShellSetApply(pc, &ToldJacobian::apply), "");
  }
  std::string recover(KSP) override {
    ++told_.recoveries;
    return "told to fail";
  }
  LinearEffort take_effort(int) override {
    const int solves = std::exchange(told_.pending, 0);
    return {3 * solves, solves};
  }
  double memory() const override { return told_.memory; }
  void begin(double memory, bool) override { told_.begun.push_back(memory); }

private:
  static PetscErrorCode asked(KSP ksp, Vec, Vec, void *context) {
    Told &told = static_cast<ToldJacobian *>(context)->told_;
    PetscReal accuracy;
    ++told.solves, ++told.pending;
    const PetscErrorCode code = KSPGetTolerances(ksp, &accuracy, nullptr, nullptr, nullptr);
    told.asked.push_back(accuracy);
    return code;
  }
  static ToldJacobian &of(PC pc) {
    void *context;
    PCShellGetContext(pc, &context);
    return *static_cast<ToldJacobian *>(context);
  }
  static PetscErrorCode factor(PC pc) {
    Told &told = of(pc).told_;
    const int now = told.factorisations++;
    return PCSetFailedReason(pc, now >= told.fail_at && now < told.fail_until ? told.reason : PC_NOERROR);
  }
  static PetscErrorCode apply(PC pc, Vec b, Vec x) {
    double *at;
    PetscErrorCode code = VecCopy(b, x);
    if (!code) code = VecGetArray(x, &at);
    if (code) return code;
    of(pc).factors_.solve(at);
    if (of(pc).told_.solves == of(pc).told_.spoil_at) at[0] = std::nan("");
    return VecRestoreArray(x, &at);
  }

  Told &told_;
};

class ToldProblem : public SmallProblem {
public:
  explicit ToldProblem(Equations equations) : SmallProblem(std::move(equations)) {}
  std::unique_ptr<BorderedJacobian> jacobian() override { return std::make_unique<ToldJacobian>(equations_, told); }
  /// [x; p]
  UniqueVec vector(const std::vector<double> &entries) const {
    UniqueVec y = unknowns();
    for (std::size_t i = 0; i < entries.size(); ++i)
      check(VecSetValue(y, static_cast<PetscInt>(i), entries[i], INSERT_VALUES), "");
    check(VecAssemblyBegin(y), ""), check(VecAssemblyEnd(y), "");
    return y;
  }

  Told told;
};

/// Changes an entry behind PETSc's back: what is known without a look stays.
inline void change_secretly(Vec y, int i, double value) {
  const double *at;
  check(VecGetArrayRead(y, &at), "");
  const_cast<double *>(at)[i] = value;
  check(VecRestoreArrayRead(y, &at), "");
}

} // namespace dovetail::testing
