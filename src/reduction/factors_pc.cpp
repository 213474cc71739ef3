#include "reduction/factors_pc.hpp"

#include <algorithm>

#include "support/shell.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "solving with K_ee";

Inverse &inverse_of(PC pc) {
  Inverse *inverse = nullptr;
  PCShellGetContext(pc, &inverse);
  return *inverse;
}

PetscErrorCode solve_columns(PC pc, Mat B, Mat X) {
  Inverse &inverse = inverse_of(pc);
  return inverse.courier.run([&] {
    PetscInt rows, columns, from, to;
    const double *b;
    double *x;
    check(MatGetLocalSize(B, &rows, nullptr), doing);
    check(MatGetSize(B, nullptr, &columns), doing);
    check(MatDenseGetLDA(B, &from), doing);
    check(MatDenseGetLDA(X, &to), doing);
    Tall sides(rows, columns);
    check(MatDenseGetArrayRead(B, &b), doing);
    for (PetscInt j = 0; j < columns; ++j) std::copy_n(b + j * from, rows, sides.column(j));
    check(MatDenseRestoreArrayRead(B, &b), doing);
    const Tall solution = inverse.solver.solve(sides);
    check(MatDenseGetArrayWrite(X, &x), doing);
    for (PetscInt j = 0; j < columns; ++j) std::copy_n(solution.column(j), rows, x + j * to);
    check(MatDenseRestoreArrayWrite(X, &x), doing);
  });
}

PetscErrorCode solve_column(PC pc, Vec b, Vec x) {
  Inverse &inverse = inverse_of(pc);
  return inverse.courier.run([&] {
    PetscInt rows;
    check(VecGetLocalSize(b, &rows), doing);
    Tall side(rows, 1);
    std::copy_n(static_cast<const double *>(ReadValues(b)), rows, side.column(0));
    const Tall solution = inverse.solver.solve(side);
    std::copy_n(solution.column(0), rows, static_cast<double *>(Values(x)));
  });
}

} // namespace

void precondition_by(Inverse &inverse, PC pc) {
  check(PCSetType(pc, PCSHELL), doing);
  check(PCShellSetName(pc, "the factors of K_ee"), doing);
  check(PCShellSetContext(pc, &inverse), doing);
  check(PCShellSetApply(pc, solve_column), doing);
  check(PCShellSetMatApply(pc, solve_columns), doing);
}

} // namespace dovetail
