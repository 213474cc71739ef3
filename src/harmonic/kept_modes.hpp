#pragma once
// The modes of the stuck structure in a file of their own: of a thousand contact points they take many seconds, and the
// next run of a study that changes loads or friction wants the same.
#include <cstdint>
#include <filesystem>
#include <vector>

namespace dovetail {

/// Number made of the lower halves of two matrices (n, n), by columns.
std::uint64_t fingerprint(const std::vector<double> &K, const std::vector<double> &M, std::size_t n);

/// Eigenvalues (n) and modes (n, n), one after the other, if the file holds those with this fingerprint; false, and
/// nothing changed, if it does not, or is no such file.
bool read_modes(const std::filesystem::path &file, std::uint64_t fingerprint, std::vector<double> &lambda,
                std::vector<double> &modes);

/// Replaces the file, whole or not at all; one of other origin stays. A disk that is full or read-only is no error: the
/// next run computes again.
void keep_modes(const std::filesystem::path &file, std::uint64_t fingerprint, const std::vector<double> &lambda,
                const std::vector<double> &modes);

} // namespace dovetail
