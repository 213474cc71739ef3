#pragma once
// Contact points side by side: one per lane of a vector of doubles. The compiler maps the lanes to what the machine
// has.
#include <cstddef>
#include <cstdint>
#include <vector>

namespace dovetail {

/// Marks a function that is compiled once per generation of processor, the right one chosen when the program starts.
/// What it calls is compiled into it: vectors are passed differently from one generation to the next. Without
/// optimisation nothing is inlined, and address sanitizers start later than the choice is made.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && defined(__OPTIMIZE__) &&  \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define DOVETAIL_WIDE __attribute__((target_clones("avx512f", "fma", "default"), flatten))
/// The same for kernels on vectors: NAME(...) calls NAME_parts<Width>(...), with as many numbers at a time as a
/// register holds.
#define DOVETAIL_WIDE_PARTS(NAME, PARAMETERS, ARGUMENTS)                                                               \
  __attribute__((target("avx512f"), flatten)) void NAME PARAMETERS { NAME##_parts<8> ARGUMENTS; }                      \
  __attribute__((target("fma"), flatten)) void NAME PARAMETERS { NAME##_parts<4> ARGUMENTS; }                          \
  __attribute__((target("default"), flatten)) void NAME PARAMETERS { NAME##_parts<2> ARGUMENTS; }
#else
#define DOVETAIL_WIDE
#define DOVETAIL_WIDE_PARTS(NAME, PARAMETERS, ARGUMENTS)                                                               \
  void NAME PARAMETERS { NAME##_parts<2> ARGUMENTS; }
#endif
#pragma GCC diagnostic ignored "-Wpsabi" // no vector is passed by value between translation units

constexpr int lane_count = 8;
constexpr int at_a_time = 4; ///< vectors, where sums side by side hide how long each addition takes
typedef double Lanes __attribute__((vector_size(64), aligned(64))); // aligned alike on every generation
typedef std::uint64_t LaneBits __attribute__((vector_size(64), aligned(64)));

/// Array of lanes; Element is double or std::uint64_t. (Standard containers forget the alignment of a vector type.)
template <class Element> class LaneArray {
public:
  typedef Element Vector __attribute__((vector_size(64), aligned(64)));

  explicit LaneArray(std::size_t size) : lines_(size) {}

  std::size_t size() const { return lines_.size(); }
  Vector *data() { return reinterpret_cast<Vector *>(lines_.data()); }
  const Vector *data() const { return reinterpret_cast<const Vector *>(lines_.data()); }
  Vector &operator[](std::size_t i) { return data()[i]; }
  const Vector &operator[](std::size_t i) const { return data()[i]; }
  Element *values() { return reinterpret_cast<Element *>(lines_.data()); } ///< all lanes in a row
  const Element *values() const { return reinterpret_cast<const Element *>(lines_.data()); }
  Vector *begin() { return data(); }
  Vector *end() { return data() + size(); }

private:
  struct alignas(64) Line {
    Element lanes[lane_count]{};
  };
  std::vector<Line> lines_;
};

/// The first, second, ... `Width` lanes of every element of an array of lanes.
template <int Width> struct Vector {
  typedef double Real __attribute__((vector_size(8 * Width)));
  typedef std::uint64_t Bits __attribute__((vector_size(8 * Width)));
};
template <class V> struct Part {
  static constexpr std::ptrdiff_t stride = sizeof(Lanes) / sizeof(V);
  V *first;
  template <class L> Part(L *lanes, int part) : first(reinterpret_cast<V *>(lanes) + part) {}
  explicit Part(V *at) : first(at) {}
  V &operator[](std::ptrdiff_t i) const { return first[i * stride]; }
  Part operator+(std::ptrdiff_t i) const { return Part(first + i * stride); }
};

/// A vector V from and to where no vector needs to begin.
template <class V, class Real> inline V load(const Real *from) {
  V out;
  __builtin_memcpy(&out, from, sizeof out);
  return out;
}
template <class V, class Real> inline void store(const V &value, Real *to) {
  __builtin_memcpy(to, &value, sizeof value);
}
template <class Real = double, class V> inline Real sum_of(const V &value) { // pairwise, in registers
  if constexpr (sizeof(V) > 16) {
    typedef Real Half __attribute__((vector_size(sizeof(V) / 2)));
    Half low, high;
    __builtin_memcpy(&low, &value, sizeof low);
    __builtin_memcpy(&high, reinterpret_cast<const char *>(&value) + sizeof low, sizeof high);
    return sum_of<Real>(Half(low + high));
  } else {
    Real part[sizeof(V) / sizeof(Real)];
    __builtin_memcpy(part, &value, sizeof value);
    for (std::size_t half = sizeof(V) / sizeof(Real) / 2; half > 0; half /= 2)
      for (std::size_t i = 0; i < half; ++i) part[i] += part[i + half];
    return part[0];
  }
}

} // namespace dovetail
