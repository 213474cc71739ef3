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

} // namespace dovetail
