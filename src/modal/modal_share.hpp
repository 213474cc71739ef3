#pragma once
// Which modal unknowns a rank works with when GMRES solves in the stuck modes. Where vectors are short, every rank
// keeps whole ones, and does the same with them as all others do. An iteration waits for the other ranks once, for the
// sum of their products. Where they are long, each has a share of the unknowns, and an iteration waits five times. So
// it is where ranks do not compute alike: with whole vectors, a last bit could let one of them go on while another has
// ended.
#include "stuck/layout.hpp"
#include "stuck/stuck_basis.hpp"

namespace dovetail {

struct ModalShare {
  /// Dampers that are not diagonal in the modes have rows of the own share only. Collective.
  ModalShare(const StuckBases &bases, const Layout &layout);

  PetscInt few; ///< motions of the coarse space at most, of a basis; 0: there is none
  bool everywhere;
  Range own;
  MPI_Comm comm;   ///< of those who have different unknowns
  bool holds_last; ///< Omega, the last unknown
};

} // namespace dovetail
