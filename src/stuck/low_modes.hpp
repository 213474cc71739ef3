#pragma once
// The lowest modes of the reduced structure with springs on its contact dofs: few of them, in little time however many
// contact points there are.
#include <optional>
#include <vector>

#include "stuck/layout.hpp"
#include "stuck/pencil_rows.hpp"

namespace dovetail {

struct LowModes {
  std::vector<double> squares; ///< w^2, ascending, exactly 0 of rigid motions; on every rank
  std::vector<double> shapes;  ///< (modes, own dofs) v with v^T M v = 1
};

/// The `count` lowest, or all. `springs`: (own contact dofs). LAPACK on one rank where there are few dofs, else block
/// Lanczos (block_lanczos.hpp) with one factorisation. Nothing if M is not positive definite. Collective. ComputeError.
std::optional<LowModes> low_modes(const PencilRows &rows, const std::vector<double> &springs, const Layout &layout,
                                  PetscInt count);

/// Those two ways, for tests.
std::optional<LowModes> low_modes_by_lapack(const PencilRows &rows, const std::vector<double> &springs,
                                            const Layout &layout, PetscInt count);
std::optional<LowModes> low_modes_by_lanczos(const PencilRows &rows, const std::vector<double> &springs,
                                             const Layout &layout, PetscInt count);

} // namespace dovetail
