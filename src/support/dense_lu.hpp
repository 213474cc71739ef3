#pragma once
// Direct solves by LAPACK on one rank: for a few hundred unknowns, where the work of preparing MUMPS's factorisation
// outweighs the factorisation.
#include "support/handle.hpp"

namespace dovetail {

/// Makes `ksp` one dense LU factorisation of A, on one rank, and one solve. Call before SetFromOptions.
void factor_densely(KSP ksp, Mat A);

/// Whether that is how `ksp` solves; an option may have said otherwise since.
bool factored_densely(KSP ksp);

/// Sign of the determinant of the matrix factored last: +1 or -1; 0 if that failed.
int dense_determinant_sign(KSP ksp);

} // namespace dovetail
