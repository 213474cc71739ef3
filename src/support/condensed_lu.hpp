#pragma once
// Direct solves on one rank where LAPACK beats MUMPS: after the linear modes, which couple with themselves only, one
// harmonic at a time, are eliminated, a few hundred unknowns are left, for which MUMPS's preparations outweigh its
// work.
#include "support/handle.hpp"

namespace dovetail {

/// Makes `ksp` solve with A, on one rank, in two steps: the first `leading` unknowns are eliminated, which A couples
/// among themselves only in pairs, and every `width`-th, from 0, not at all (an odd number: mean, cosine, sine, ...);
/// the rest is dense and factored by LAPACK. Pivots are not sought among the former. Call before SetFromOptions.
void factor_condensed(KSP ksp, Mat A, PetscInt leading, PetscInt width);

/// Whether that is how `ksp` solves; an option may have said otherwise since.
bool is_condensed(KSP ksp);

/// Sign of the determinant of the matrix factored last: +1 or -1; 0 if that failed.
int condensed_determinant_sign(KSP ksp);

} // namespace dovetail
