#pragma once
// A slab (slab.hpp) times very few columns, fewer than a register holds numbers: each column lies by itself, a strand,
// and many numbers of a row are taken at a time. So a harmonic that has a slab of its own costs its two columns.
#include "harmonic/slab.hpp"

namespace dovetail {

/// out (count, strands) = rows first .. first + count of the slab times b (strands, slab.stride()).
void multiply_strands(const Slab<double> &slab, std::size_t first, std::size_t count, const double *b, int strands,
                      double *out);
void multiply_strands(const Slab<float> &slab, std::size_t first, std::size_t count, const float *b, int strands,
                      float *out);

/// out (strands, slab.stride()) += (those rows)^T times f (count, strands).
void add_transposed_strands(const Slab<float> &slab, std::size_t first, std::size_t count, const float *f, int strands,
                            float *out);

/// Columns that slabs of the same columns are applied to: a sheaf where they are `wide`, strands where they are few.
template <class Real> class Bundle {
public:
  Bundle(const Slab<Real> &slab, int columns, bool wide)
      : columns_(columns), wide_(wide), row_(wide ? padded<Real>(columns) : 1), column_(wide ? 1 : slab.stride()),
        values_(wide ? slab.columns() * row_ : columns * column_) {}

  int room() const {
    return wide_ ? static_cast<int>(row_) : columns_;
  } ///< numbers in a row of what comes out, goes in
  Real &at(std::size_t row, int column) { return values_[row * row_ + column * column_]; }
  Real at(std::size_t row, int column) const { return values_[row * row_ + column * column_]; }
  void clear() { values_.clear(); }

  /// out (count, room) = rows of the slab times this.
  void multiplied(const Slab<Real> &slab, std::size_t first, std::size_t count, Real *out) const {
    if (wide_)
      multiply(slab, first, count, values_.data(), room(), out);
    else
      multiply_strands(slab, first, count, values_.data(), columns_, out);
  }
  /// This += their transpose times f (count, room).
  void add_transposed_of(const Slab<Real> &slab, std::size_t first, std::size_t count, const Real *f) {
    if (wide_)
      add_transposed(slab, first, count, f, room(), values_.data());
    else
      add_transposed_strands(slab, first, count, f, columns_, values_.data());
  }

private:
  int columns_;
  bool wide_;
  std::size_t row_, column_; // numbers from one to the next
  Aligned<Real> values_;
};

} // namespace dovetail
