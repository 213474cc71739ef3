#include "harmonic/slab.hpp"

#include "contact/wide.hpp"

namespace dovetail {
namespace {

// Vectors of a sheaf's row taken at a time, and rows (or columns) side by side, such that the sums fill the registers:
// 24 of 32 with 512 bits, 12 of 16 below.
template <int Bytes> constexpr int sums = Bytes == 64 ? 24 : 12;

// `together` rows times `vectors` vectors of the sheaf.
template <class V, int vectors, int together, class Real>
inline void rows_times(const Real *__restrict slab, std::size_t stride, std::size_t columns, const Real *__restrict b,
                       int padded, Real *__restrict out) {
  constexpr int width = sizeof(V) / sizeof(Real);
  V sum[together][vectors]{};
  for (std::size_t j = 0; j < columns; ++j) {
    V row[vectors];
    for (int v = 0; v < vectors; ++v) row[v] = load<V>(b + j * padded + v * width);
    for (int r = 0; r < together; ++r) {
      const Real factor = slab[r * stride + j];
      for (int v = 0; v < vectors; ++v) sum[r][v] += factor * row[v];
    }
  }
  for (int r = 0; r < together; ++r)
    for (int v = 0; v < vectors; ++v) store(sum[r][v], out + r * padded + v * width);
}

// `together` columns, as rows of the transpose, times the same.
template <class V, int vectors, int together, class Real>
inline void columns_times(const Real *__restrict slab, std::size_t stride, std::size_t rows, const Real *__restrict f,
                          int padded, Real *__restrict out) {
  constexpr int width = sizeof(V) / sizeof(Real);
  V sum[together][vectors];
  for (int c = 0; c < together; ++c)
    for (int v = 0; v < vectors; ++v) sum[c][v] = load<V>(out + c * padded + v * width);
  for (std::size_t i = 0; i < rows; ++i) {
    V row[vectors];
    for (int v = 0; v < vectors; ++v) row[v] = load<V>(f + i * padded + v * width);
    for (int c = 0; c < together; ++c) {
      const Real factor = slab[i * stride + c];
      for (int v = 0; v < vectors; ++v) sum[c][v] += factor * row[v];
    }
  }
  for (int c = 0; c < together; ++c)
    for (int v = 0; v < vectors; ++v) store(sum[c][v], out + c * padded + v * width);
}

template <class V, int vectors, class Real>
inline void multiply_part(const Real *slab, std::size_t stride, std::size_t rows, std::size_t columns, const Real *b,
                          int padded, Real *out) {
  constexpr int together = sums<sizeof(V)> / vectors;
  std::size_t i = 0;
  for (; i + together <= rows; i += together)
    rows_times<V, vectors, together>(slab + i * stride, stride, columns, b, padded, out + i * padded);
  for (; i + 3 <= rows; i += 3) // a contact point
    rows_times<V, vectors, 3>(slab + i * stride, stride, columns, b, padded, out + i * padded);
  for (; i < rows; ++i) rows_times<V, vectors, 1>(slab + i * stride, stride, columns, b, padded, out + i * padded);
}

template <class V, int vectors, class Real>
inline void transposed_part(const Real *slab, std::size_t stride, std::size_t rows, std::size_t columns, const Real *f,
                            int padded, Real *out) {
  constexpr int together = sums<sizeof(V)> / vectors >= 8 ? 8 : 4;
  std::size_t j = 0;
  for (; j + together <= columns; j += together)
    columns_times<V, vectors, together>(slab + j, stride, rows, f, padded, out + j * padded);
  for (; j < columns; ++j) columns_times<V, vectors, 1>(slab + j, stride, rows, f, padded, out + j * padded);
}

template <int Width, class Real>
inline void times_parts(const Real *slab, std::size_t stride, std::size_t rows, std::size_t columns, const Real *b,
                        int padded, Real *out) {
  typedef Real V __attribute__((vector_size(8 * Width)));
  constexpr int width = sizeof(V) / sizeof(Real);
  for (int at = 0; at < padded;)
    if (padded - at >= 3 * width)
      multiply_part<V, 3>(slab, stride, rows, columns, b + at, padded, out + at), at += 3 * width;
    else if (padded - at >= 2 * width)
      multiply_part<V, 2>(slab, stride, rows, columns, b + at, padded, out + at), at += 2 * width;
    else
      multiply_part<V, 1>(slab, stride, rows, columns, b + at, padded, out + at), at += width;
}

template <int Width, class Real>
inline void turned_parts(const Real *slab, std::size_t stride, std::size_t rows, std::size_t columns, const Real *f,
                         int padded, Real *out) {
  typedef Real V __attribute__((vector_size(8 * Width)));
  constexpr int width = sizeof(V) / sizeof(Real);
  for (int at = 0; at < padded;)
    if (padded - at >= 3 * width)
      transposed_part<V, 3>(slab, stride, rows, columns, f + at, padded, out + at), at += 3 * width;
    else if (padded - at >= 2 * width)
      transposed_part<V, 2>(slab, stride, rows, columns, f + at, padded, out + at), at += 2 * width;
    else
      transposed_part<V, 1>(slab, stride, rows, columns, f + at, padded, out + at), at += width;
}

#define DOVETAIL_SLAB(NAME, REAL)                                                                                      \
  DOVETAIL_WIDE_PARTS(NAME,                                                                                            \
                      (const REAL *slab, std::size_t stride, std::size_t rows, std::size_t columns, const REAL *b,     \
                       int padded, REAL *out),                                                                         \
                      (slab, stride, rows, columns, b, padded, out))
DOVETAIL_SLAB(times, double)
DOVETAIL_SLAB(times, float)
DOVETAIL_SLAB(turned, float)

} // namespace

void multiply(const Slab<double> &slab, std::size_t first, std::size_t count, const double *b, int padded,
              double *out) {
  times(slab.row(first), slab.stride(), count, slab.columns(), b, padded, out);
}
void multiply(const Slab<float> &slab, std::size_t first, std::size_t count, const float *b, int padded, float *out) {
  times(slab.row(first), slab.stride(), count, slab.columns(), b, padded, out);
}

void add_transposed(const Slab<float> &slab, std::size_t first, std::size_t count, const float *f, int padded,
                    float *out) {
  turned(slab.row(first), slab.stride(), count, slab.columns(), f, padded, out);
}

} // namespace dovetail
