#pragma once
// The factors of K_ee as a preconditioner of PETSc: by way of it SLEPc solves with them, a block at a time where it
// can.
#include "reduction/clamped_solver.hpp"
#include "support/error.hpp"

namespace dovetail {

struct Inverse {
  const ClampedSolver &solver;
  Courier courier; ///< of what the solves throw: rethrow() when SLEPc has returned
};

/// `inverse` must live as long as `pc` is used.
void precondition_by(Inverse &inverse, PC pc);

} // namespace dovetail
