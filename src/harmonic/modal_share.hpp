#pragma once
// Which modal unknowns a rank works with when GMRES solves in the stuck modes. Where a rank's rows of Phi_c are many,
// vectors cost little beside the products with them: every rank then keeps whole vectors, and does the same with them
// as all others do. An iteration waits for the other ranks once, for the sum of their products. With more ranks than
// that pays for, each has a share of the unknowns, and an iteration waits five times. So it is where ranks do not
// compute alike: with whole vectors, a last bit could let one of them go on while another has ended.
#include "harmonic/layout.hpp"
#include "harmonic/stuck_basis.hpp"
#include "support/blas_kernel.hpp"

namespace dovetail {

struct ModalShare {
  /// Dampers that are not diagonal in the modes have rows of the own share only. Collective.
  ModalShare(const StuckBases &bases, const Layout &layout)
      : everywhere(layout.size > 1 && bases.mean().dampers_are_diagonal() &&
                   3 * layout.points >= least_rows * layout.width * layout.size && compute_alike(layout.comm)),
        own(everywhere ? Range{0, layout.dofs()} : own_share(layout.comm, layout.dofs())),
        comm(everywhere ? MPI_COMM_SELF : layout.comm), holds_last(everywhere || layout.owns_omega()) {}

  bool everywhere;
  Range own;
  MPI_Comm comm;   ///< of those who have different unknowns
  bool holds_last; ///< Omega, the last unknown

private:
  static constexpr PetscInt least_rows = 4; // of Phi_c on a rank, by coefficient: in eight iterations vectors take as
                                            // many bytes as so many rows
};

} // namespace dovetail
