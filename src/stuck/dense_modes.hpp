#pragma once
// All modes of a symmetric pencil of the reduced model's size: K Phi = M Phi diag(lambda), Phi^T M Phi = 1. Matrices
// are given, and modes returned, by the rows of the own dofs (Layout::number), n numbers each.
#include <vector>

#include "stuck/own_rows.hpp"

namespace dovetail {

/// Of the mode dofs only the diagonals are looked at, so M's rows of the contact dofs hold their coupling. `K` becomes
/// the rows of Phi and `M` empty. Returns lambda (n), ascending, on every rank. By LAPACK on rank 0. Collective.
/// Empty, and so are K and M, if M is not positive definite.
std::vector<double> dense_modes_on_one_rank(const Layout &layout, std::vector<double> &K, std::vector<double> &M);

/// The same by ScaLAPACK on all ranks, none of which holds more than its share (spread_modes.cpp).
std::vector<double> dense_modes_on_all_ranks(const Layout &layout, std::vector<double> &K, std::vector<double> &M);

} // namespace dovetail
