#pragma once
// Numbers made of numbers: for fingerprints, and for noise that is the same wherever it is made.
#include <cstdint>

namespace dovetail {

/// The finaliser of splitmix64: a bijection without structure.
inline std::uint64_t mix(std::uint64_t x) {
  x ^= x >> 30, x *= 0xbf58476d1ce4e5b9u;
  x ^= x >> 27, x *= 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// In [-1, 1).
inline double noise(std::uint64_t seed) { return static_cast<double>(mix(seed) >> 11) * 0x1p-52 - 1; }

inline constexpr std::uint64_t first_seed = 0x9e3779b97f4a7c15u; ///< of a row of them: mix(0) is 0

} // namespace dovetail
