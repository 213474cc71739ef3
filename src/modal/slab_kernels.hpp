#pragma once
// The products of slab_products.hpp, with vectors of `Width` doubles. Compiled for a generation of processors by
// DOVETAIL_WIDE_PARTS. Both take numbers of a row side by side, as they lie. Slab times strands sums vectors up over
// the columns, and their lanes at the end; the transpose adds rows to strands.
#include "contact/wide.hpp"
#include "modal/slab_products.hpp"

namespace dovetail {

// Sums side by side, such that they and what is multiplied fill the registers: 32 of 512 bits, or 16. Without fused
// multiply-adds products need registers, too.
template <class V> constexpr int sums = sizeof(V) == 64 ? 24 : sizeof(V) == 32 ? 12 : 10;
template <class V> constexpr int rows_at_once = sizeof(V) == 64 ? 4 : sizeof(V) == 32 ? 3 : 2;
constexpr int fewest_vectors = 2;   // of a row at a time, so that a number of the other factor serves more than once
constexpr std::size_t piece = 4096; // bytes of a strand at a time: with as many of six they stay in the first cache
constexpr std::size_t rows_of_block = 24; // their pieces, and the next ones, stay in the second cache
constexpr std::size_t line = 64;

// `together` rows times `strands` strands; added to what is there if `add`. Fetches what is wanted next, if `fetch`.
template <class V, int together, int strands, bool fetch, class Real>
inline void rows_times(const SlabRows<Real> &rows, std::size_t i, const Real *__restrict b, int room, bool add,
                       Real *__restrict out) {
  constexpr std::size_t width = sizeof(V) / sizeof(Real);
  const Real *const slab = rows.first + i * rows.stride;
  const std::size_t stride = rows.stride, length = rows.length;
  V sum[together][strands]{};
  for (std::size_t j = 0; j < length; j += width) {
    V row[together];
    for (int r = 0; r < together; ++r) {
      row[r] = load<V>(slab + r * stride + j);
      if (fetch && j * sizeof(Real) % line == 0) __builtin_prefetch(slab + r * stride + j + rows.ahead, 0, 2);
    }
    for (int c = 0; c < strands; ++c) {
      const V strand = load<V>(b + c * stride + j);
      for (int r = 0; r < together; ++r) sum[r][c] += row[r] * strand;
    }
  }
  for (int r = 0; r < together; ++r)
    for (int c = 0; c < strands; ++c) {
      Real &to = out[(i + r) * room + c];
      to = sum_of<Real>(sum[r][c]) + (add ? to : Real{});
    }
}

// `count` strands, at most `most`.
template <class V, int most, bool fetch, class Real>
inline void times_few(int count, const SlabRows<Real> &rows, const Real *b, int room, bool add, Real *out) {
  if constexpr (most > 1)
    if (count < most) return times_few<V, most - 1, fetch>(count, rows, b, room, add, out);
  constexpr int together = rows_at_once<V>;
  std::size_t i = 0;
  for (; i + together <= rows.count; i += together) rows_times<V, together, most, fetch>(rows, i, b, room, add, out);
  for (; i < rows.count; ++i) rows_times<V, 1, most, fetch>(rows, i, b, room, add, out);
}

// `vectors` vectors of every strand, from column j on.
template <class V, int strands, int vectors, class Real>
inline void columns_times(const SlabRows<Real> &rows, std::size_t j, const Real *__restrict f, int room,
                          Real *__restrict out) {
  constexpr std::size_t width = sizeof(V) / sizeof(Real);
  const Real *slab = rows.first + j;
  const std::size_t stride = rows.stride, ahead = rows.ahead;
  V sum[strands][vectors];
  for (int c = 0; c < strands; ++c)
    for (int v = 0; v < vectors; ++v) sum[c][v] = load<V>(out + c * stride + j + v * width);
  for (std::size_t i = 0; i < rows.count; ++i, slab += stride) {
    V row[vectors];
    for (int v = 0; v < vectors; ++v) {
      row[v] = load<V>(slab + v * width);
      if (v * sizeof(V) % line == 0) __builtin_prefetch(slab + ahead + v * width, 0, 2);
    }
    for (int c = 0; c < strands; ++c) {
      const Real factor = f[i * room + c];
      for (int v = 0; v < vectors; ++v) sum[c][v] += factor * row[v];
    }
  }
  for (int c = 0; c < strands; ++c)
    for (int v = 0; v < vectors; ++v) store(sum[c][v], out + c * stride + j + v * width);
}

template <class V, int most, class Real>
inline void turned_few(int count, const SlabRows<Real> &rows, const Real *f, int room, Real *out) {
  if constexpr (most > 1)
    if (count < most) return turned_few<V, most - 1>(count, rows, f, room, out);
  constexpr std::size_t width = sizeof(V) / sizeof(Real);
  constexpr int vectors = sums<V> / most;
  std::size_t j = 0;
  for (; j + vectors * width <= rows.length; j += vectors * width)
    columns_times<V, most, vectors>(rows, j, f, room, out);
  for (; j < rows.length; j += width) columns_times<V, most, 1>(rows, j, f, room, out);
}

// Calls `work` for all strands, with the first and the number of each part: as equal as can be, at most `most`.
template <int most, class Work> inline void in_parts(int strands, const Work &work) {
  for (int first = 0, parts = (strands + most - 1) / most; parts > 0; --parts) {
    const int count = (strands - first + parts - 1) / parts;
    work(first, count);
    first += count;
  }
}

template <int Width, class Real>
inline void times_parts(const SlabRows<Real> &rows, const Real *b, int strands, Real *out) {
  typedef Real V __attribute__((vector_size(8 * Width)));
  constexpr int most = sums<V> / rows_at_once<V>;
  constexpr std::size_t step = piece / sizeof(Real);
  for (std::size_t i = 0; i < rows.count; i += rows_of_block)
    for (std::size_t j = 0; j < rows.length; j += step) {
      const std::size_t here = std::min(rows_of_block, rows.count - i);
      std::size_t ahead = step; // the next piece, or the first one of the rows that follow
      if (j + step >= rows.length) ahead = i + 2 * here <= rows.count || rows.ahead > 0 ? here * rows.stride - j : 0;
      const SlabRows<Real> part{rows.first + i * rows.stride + j, here, rows.stride, std::min(step, rows.length - j),
                                ahead};
      in_parts<most>(strands, [&](int first, int count) {
        const Real *const from = b + first * rows.stride + j;
        Real *const to = out + i * strands + first;
        if (first == 0)
          times_few<V, most, true>(count, part, from, strands, j > 0, to);
        else
          times_few<V, most, false>(count, part, from, strands, j > 0, to);
      });
    }
}

template <int Width, class Real>
inline void turned_parts(const SlabRows<Real> &rows, const Real *f, int strands, Real *out) {
  typedef Real V __attribute__((vector_size(8 * Width)));
  constexpr int most = sums<V> / fewest_vectors;
  in_parts<most>(strands, [&](int first, int count) {
    turned_few<V, most>(count, rows, f + first, strands, out + first * rows.stride);
  });
}

} // namespace dovetail
