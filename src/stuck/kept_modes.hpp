#pragma once
// The modes of the stuck structure in a file of their own: of a thousand contact points they take many seconds, and the
// next run of a study that changes loads or friction wants the same. All collective.
#include <cstdint>
#include <filesystem>
#include <vector>

#include "stuck/layout.hpp"

namespace dovetail {

/// Number made of two matrices (n, n), of which each rank has the rows of its own dofs; the same on any number of
/// ranks.
std::uint64_t fingerprint(const Layout &layout, const std::vector<double> &K, const std::vector<double> &M);

/// Eigenvalues (n) and the own rows of the modes (own dofs, n), if the file holds those with this fingerprint; false,
/// and nothing changed, if it does not, or is no such file.
bool read_modes(const Layout &layout, const std::filesystem::path &file, std::uint64_t fingerprint,
                std::vector<double> &lambda, std::vector<double> &modes);

/// Replaces the file, whole or not at all; one of other origin stays. A disk that is full or read-only is no error: the
/// next run computes again.
void keep_modes(const Layout &layout, const std::filesystem::path &file, std::uint64_t fingerprint,
                const std::vector<double> &lambda, const std::vector<double> &modes);

} // namespace dovetail
