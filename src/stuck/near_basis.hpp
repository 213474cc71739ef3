#pragma once
// In place of all modes of the stuck structure, where these are so many that their eigenproblem takes hours and more
// memory than K and M: the lowest modes, and beside them motions of which K_s makes as much of one as of another.
//
// With K_s = R^T R and the modes Phi_l of the squares Lambda_l, U = R Phi_l Lambda_l^-1/2 has orthonormal columns, and
// Householder's Q has them first. R^-1 Q then are the modes, each over its frequency, and motions that are orthonormal
// in K_s and orthogonal to the modes in M. What these have of mass beside each other is not diagonal, but small: it is
// at most 1 over the first square that was left out. They are given the middle of what it may be.
#include <optional>

#include "stuck/stuck_basis.hpp"

namespace dovetail {

constexpr PetscInt many_dofs = 12000; ///< all modes of so many take longer than a curve does

/// A basis in which K_s is diagonal, and M but for that: `near` is set, `exact` empty. Collective.
/// `reach`: the highest frequency of all harmonics; its modes are found to some times that. Nothing where K_s is not
/// positive definite. InputError: M is not.
std::optional<StuckBasis> near_basis(const PencilRows &rows, const std::vector<double> &springs, const Layout &layout,
                                     double reach);

} // namespace dovetail
