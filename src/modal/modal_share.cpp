#include "modal/modal_share.hpp"

#include <algorithm>
#include <cmath>

#include "support/blas_kernel.hpp"

namespace dovetail {
namespace {

constexpr PetscInt least = 250;   // dofs: with fewer an iteration costs next to nothing
constexpr double iterations = 8;  // that factoring may cost
constexpr PetscInt brief = 20000; // unknowns: whole vectors of as many cost an iteration less than four messages

// For a rank's contact dof an iteration takes 4 n (2H+1) operations, the matrix of c motions 2 c^2 (2H+1)^2. Its
// factors, 2/3 c^3 (2H+1)^3, are made on every rank.
PetscInt worth_factoring(const Layout &layout) {
  const double n = layout.dofs(), w = layout.width;
  if (n < least) return 0;
  return static_cast<PetscInt>(std::min(std::sqrt(2 * iterations * n / w),
                                        std::cbrt(6 * iterations * n * 3.0 * layout.points / layout.size / (w * w))));
}

bool whole_vectors_pay(const Layout &layout) {
  PetscInt most = brief;
  check(PetscOptionsGetInt(nullptr, "hb_modal_", "-whole", &most, nullptr), "reading options");
  return layout.unknowns() <= most;
}

} // namespace

ModalShare::ModalShare(const StuckBases &bases, const Layout &layout)
    : few(worth_factoring(layout)), everywhere(layout.size > 1 && bases.mean().dampers_are_diagonal() &&
                                               whole_vectors_pay(layout) && compute_alike(layout.comm)),
      own(everywhere ? Range{0, layout.dofs()} : own_share(layout.comm, layout.dofs())),
      comm(everywhere ? MPI_COMM_SELF : layout.comm), holds_last(everywhere || layout.owns_omega()) {}

} // namespace dovetail
