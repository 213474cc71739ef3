#pragma once
// Block Lanczos with full orthogonalisation and thick restart as a type of SLEPc's EPS (Grimes, Lewis and Simon, SIAM
// J. Matrix Anal. Appl. 15 (1994); Wu and Simon, ibid. 22 (2000)).
#include <slepceps.h>

namespace dovetail {

/// For A x = lambda B x, A symmetric positive definite and B semidefinite, with shift-and-invert about 0: many
/// right-hand sides at once, where factors that are read for each vector alone leave the processor waiting for memory.
/// EPSSetInitialSpace gives the first block, entries in [-1, 1] without structure; the number of its vectors is the
/// width of all blocks. EPS_DIVERGED_BREAKDOWN says that B has no more eigenvalues than have converged; if B is not
/// positive where it is met, the error is that of SLEPc's own inner products.
constexpr const char *block_lanczos = "blocklanczos";

/// Makes the type known to SLEPc; again and again does no harm.
void register_block_lanczos();

constexpr PetscInt lanczos_block = 16; ///< vectors in a block where modes are computed

/// Columns the search for `count` of `n` modes may hold at once, besides three blocks of `width`: -modes_eps_ncv.
PetscInt lanczos_columns(PetscInt count, PetscInt n, PetscInt width = lanczos_block);

} // namespace dovetail
