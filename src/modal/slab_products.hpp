#pragma once
// A slab, many rows of many columns, times few columns, and its transpose: the products that the stuck-modal form
// spends its time in. Each of the few columns lies by itself, a strand, and many numbers of a row are taken at a time:
// no width is filled up with zeros, and both products read the slab as it lies.
#include "stuck/slab.hpp"

namespace dovetail {

/// Some rows of a slab. Strands have its `stride`.
template <class Real> struct SlabRows {
  const Real *first;
  std::size_t count, stride;
  std::size_t length; ///< columns, rounded up to whole cache lines
  std::size_t ahead;  ///< from a row to one that is wanted next: it is fetched meanwhile
};

/// out (count, strands) = rows first .. first + count of the slab times b (strands, slab.stride()).
void multiply(const Slab<double> &slab, std::size_t first, std::size_t count, const double *b, int strands,
              double *out);
void multiply(const Slab<float> &slab, std::size_t first, std::size_t count, const float *b, int strands, float *out);

/// out (strands, slab.stride()) += (those rows)^T times f (count, strands). Fetches as many rows that follow.
void add_transposed(const Slab<float> &slab, std::size_t first, std::size_t count, const float *f, int strands,
                    float *out);

template <class Real> SlabRows<Real> rows_of(const Slab<Real> &slab, std::size_t first, std::size_t count) {
  return {slab.row(first), count, slab.stride(),
          static_cast<std::size_t>(padded<Real>(static_cast<int>(slab.columns()))),
          first + 2 * count <= slab.rows() ? count * slab.stride() : 0};
}

/// Strands that slabs of the same stride are applied to.
template <class Real> class Bundle {
public:
  Bundle(const Slab<Real> &slab, int strands)
      : strands_(strands), stride_(slab.stride()), values_(strands * slab.stride()) {}

  int strands() const { return strands_; }
  Real &at(std::size_t row, int strand) { return values_[strand * stride_ + row]; }
  Real at(std::size_t row, int strand) const { return values_[strand * stride_ + row]; }
  void clear() { values_.clear(); }

  /// out (count, strands) = rows of the slab times this.
  void multiplied(const Slab<Real> &slab, std::size_t first, std::size_t count, Real *out) const {
    multiply(slab, first, count, values_.data(), strands_, out);
  }
  /// This += their transpose times f (count, strands).
  void add_transposed_of(const Slab<Real> &slab, std::size_t first, std::size_t count, const Real *f) {
    add_transposed(slab, first, count, f, strands_, values_.data());
  }

private:
  int strands_;
  std::size_t stride_;
  Aligned<Real> values_;
};

} // namespace dovetail
