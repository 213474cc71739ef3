#pragma once
// Direct solves by MUMPS through PETSc, set up the way every room here needs them.
#include <string>

#include "support/handle.hpp"

namespace dovetail {

/// Has SCOTCH, when MUMPS asks it for an ordering, work with one thread: with several it finds another each time, and
/// no sooner. Call before anything else runs.
void order_the_same_way();

/// Makes `ksp` one LU factorisation of A by MUMPS and one solve, with an analysis that looks at the pattern only: it is
/// done once and stays good for all later values, also when the first ones are singular. Call before SetFromOptions.
void factor_by_lu(KSP ksp, Mat A);

/// After a factorisation that failed. PETSc 3.18 takes MUMPS's error for one of the analysis and would skip every later
/// factorisation without a word; this starts afresh, analysis included, and with twice the workspace if that was short.
/// Returns what went wrong, in words.
std::string recover_lu(KSP ksp, Mat A);

/// Sign of the determinant of the matrix factored last: +1 or -1; 0 where the solver in use does not tell.
int determinant_sign(KSP ksp);

/// The factor inside a KSP set up for MUMPS.
Mat mumps_factor(KSP ksp);

} // namespace dovetail
