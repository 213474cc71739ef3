#include "harmonic/strands.hpp"

#include "contact/wide.hpp"

namespace dovetail {
namespace {

constexpr int most = 4; // strands at a time

// `together` rows times `strands` strands, `length` numbers each.
template <class V, int strands, int together, class Real>
inline void rows_times(const Real *__restrict slab, std::size_t length, const Real *__restrict b, int room,
                       Real *__restrict out) {
  constexpr std::size_t width = sizeof(V) / sizeof(Real);
  V sum[together][strands]{};
  for (std::size_t j = 0; j < length; j += width) {
    V column[strands];
    for (int c = 0; c < strands; ++c) column[c] = load<V>(b + c * length + j);
    for (int r = 0; r < together; ++r) {
      const V row = load<V>(slab + r * length + j);
      for (int c = 0; c < strands; ++c) sum[r][c] += row * column[c];
    }
  }
  for (int r = 0; r < together; ++r)
    for (int c = 0; c < strands; ++c) out[r * room + c] = sum_of<Real>(sum[r][c]);
}

template <class V, int strands, class Real>
inline void multiply_part(const Real *slab, std::size_t length, std::size_t rows, const Real *b, int room, Real *out) {
  constexpr int together = (sizeof(V) == 64 ? 24 : 8) / strands; // sums that fit into the registers
  std::size_t i = 0;
  for (; i + together <= rows; i += together)
    rows_times<V, strands, together>(slab + i * length, length, b, room, out + i * room);
  for (; i < rows; ++i) rows_times<V, strands, 1>(slab + i * length, length, b, room, out + i * room);
}

// `vectors` vectors of every strand.
template <class V, int strands, int vectors, class Real>
inline void columns_times(const Real *__restrict slab, std::size_t length, std::size_t rows, const Real *__restrict f,
                          int room, Real *__restrict out) {
  constexpr std::size_t width = sizeof(V) / sizeof(Real);
  V sum[strands][vectors];
  for (int c = 0; c < strands; ++c)
    for (int v = 0; v < vectors; ++v) sum[c][v] = load<V>(out + c * length + v * width);
  for (std::size_t i = 0; i < rows; ++i) {
    V row[vectors];
    for (int v = 0; v < vectors; ++v) row[v] = load<V>(slab + i * length + v * width);
    for (int c = 0; c < strands; ++c) {
      const Real factor = f[i * room + c];
      for (int v = 0; v < vectors; ++v) sum[c][v] += factor * row[v];
    }
  }
  for (int c = 0; c < strands; ++c)
    for (int v = 0; v < vectors; ++v) store(sum[c][v], out + c * length + v * width);
}

template <class V, int strands, class Real>
inline void transposed_part(const Real *slab, std::size_t length, std::size_t rows, const Real *f, int room,
                            Real *out) {
  constexpr std::size_t width = sizeof(V) / sizeof(Real);
  constexpr int vectors = (sizeof(V) == 64 ? 16 : 8) / strands;
  std::size_t j = 0;
  for (; j + vectors * width <= length; j += vectors * width)
    columns_times<V, strands, vectors>(slab + j, length, rows, f, room, out + j);
  for (; j < length; j += width) columns_times<V, strands, 1>(slab + j, length, rows, f, room, out + j);
}

template <int Width, class Real>
inline void times_parts(const Real *slab, std::size_t length, std::size_t rows, const Real *b, int strands, Real *out) {
  typedef Real V __attribute__((vector_size(8 * Width)));
  for (int c = 0; c < strands;) {
    const int left = strands - c;
    const Real *from = b + c * length;
    if (left >= most)
      multiply_part<V, most>(slab, length, rows, from, strands, out + c), c += most;
    else if (left >= 2)
      multiply_part<V, 2>(slab, length, rows, from, strands, out + c), c += 2;
    else
      multiply_part<V, 1>(slab, length, rows, from, strands, out + c), ++c;
  }
}

template <int Width, class Real>
inline void turned_parts(const Real *slab, std::size_t length, std::size_t rows, const Real *f, int strands,
                         Real *out) {
  typedef Real V __attribute__((vector_size(8 * Width)));
  for (int c = 0; c < strands;) {
    const int left = strands - c;
    Real *to = out + c * length;
    if (left >= most)
      transposed_part<V, most>(slab, length, rows, f + c, strands, to), c += most;
    else if (left >= 2)
      transposed_part<V, 2>(slab, length, rows, f + c, strands, to), c += 2;
    else
      transposed_part<V, 1>(slab, length, rows, f + c, strands, to), ++c;
  }
}

#define DOVETAIL_STRANDS(NAME, REAL)                                                                                   \
  DOVETAIL_WIDE_PARTS(NAME,                                                                                            \
                      (const REAL *slab, std::size_t length, std::size_t rows, const REAL *b, int strands, REAL *out), \
                      (slab, length, rows, b, strands, out))
DOVETAIL_STRANDS(times, double)
DOVETAIL_STRANDS(times, float)
DOVETAIL_STRANDS(turned, float)

} // namespace

void multiply_strands(const Slab<double> &slab, std::size_t first, std::size_t count, const double *b, int strands,
                      double *out) {
  times(slab.row(first), slab.stride(), count, b, strands, out);
}
void multiply_strands(const Slab<float> &slab, std::size_t first, std::size_t count, const float *b, int strands,
                      float *out) {
  times(slab.row(first), slab.stride(), count, b, strands, out);
}

void add_transposed_strands(const Slab<float> &slab, std::size_t first, std::size_t count, const float *f, int strands,
                            float *out) {
  turned(slab.row(first), slab.stride(), count, f, strands, out);
}

} // namespace dovetail
