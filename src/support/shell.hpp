#pragma once
// Member functions where PETSc wants a matrix or a preconditioner. What they throw goes through `self->run` (Courier).
#include "support/error.hpp"
#include "support/handle.hpp"

namespace dovetail {

/// A matrix whose product with x is (self->*work)(x, y). Collective.
template <auto work, class Self>
UniqueMat shell_matrix(MPI_Comm comm, PetscInt own, PetscInt all, Self *self, const char *doing) {
  UniqueMat A;
  check(MatCreateShell(comm, own, own, all, all, self, A.out()), doing);
  const auto product = +[](Mat shell, Vec x, Vec y) -> PetscErrorCode {
    void *context;
    MatShellGetContext(shell, &context);
    auto &owner = *static_cast<Self *>(context);
    return owner.run([&] { (owner.*work)(x, y); });
  };
  check(MatShellSetOperation(A, MATOP_MULT, reinterpret_cast<void (*)()>(product)), doing);
  return A;
}

/// Makes (self->*work)(r, x) the preconditioner of `ksp`.
template <auto work, class Self> void shell_preconditioner(KSP ksp, Self *self, const char *doing) {
  PC pc;
  check(KSPGetPC(ksp, &pc), doing);
  check(PCSetType(pc, PCSHELL), doing);
  check(PCShellSetContext(pc, self), doing);
  const auto apply = +[](PC shell, Vec r, Vec x) -> PetscErrorCode {
    void *context;
    PCShellGetContext(shell, &context);
    auto &owner = *static_cast<Self *>(context);
    return owner.run([&] { (owner.*work)(r, x); });
  };
  check(PCShellSetApply(pc, apply), doing);
}

/// Makes (self->*work)(r, x) all that `ksp` does to solve with that matrix.
template <auto work, class Self> void shell_solver(KSP ksp, Mat matrix, Self *self, const char *doing) {
  check(KSPSetOperators(ksp, matrix, matrix), doing);
  check(KSPSetType(ksp, KSPPREONLY), doing);
  shell_preconditioner<work>(ksp, self, doing);
}

/// The numbers of a vector that this rank owns, while it lives.
class Values {
public:
  explicit Values(Vec v) : v_(v) { check(VecGetArray(v_, &values_), "reaching a vector"); }
  Values(const Values &) = delete;
  ~Values() { VecRestoreArray(v_, &values_); }
  operator double *() const { return values_; }

private:
  Vec v_;
  double *values_;
};

class ReadValues {
public:
  explicit ReadValues(Vec v) : v_(v) { check(VecGetArrayRead(v_, &values_), "reaching a vector"); }
  ReadValues(const ReadValues &) = delete;
  ~ReadValues() { VecRestoreArrayRead(v_, &values_); }
  operator const double *() const { return values_; }

private:
  Vec v_;
  const double *values_;
};

} // namespace dovetail
