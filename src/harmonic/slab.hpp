#pragma once
// A slab, many rows of many columns, times a sheaf, few numbers for each column: the products that the stuck-modal form
// spends its time in. A slab is read once per product; on one that fits into the cache, the product with its transpose
// comes almost for nothing.
#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>

namespace dovetail {

/// Numbers in a row of a sheaf of `width`: whole cache lines, the rest is zero.
template <class Real> constexpr int padded(int width) {
  constexpr int line = 64 / sizeof(Real);
  return (width + line - 1) / line * line;
}

/// Zeros, at the beginning of a cache line.
template <class Real> class Aligned {
public:
  Aligned() = default;
  explicit Aligned(std::size_t size) : size_(size) {
    const std::size_t bytes = (size * sizeof(Real) + 63) / 64 * 64;
    values_.reset(static_cast<Real *>(std::aligned_alloc(64, bytes > 0 ? bytes : 64)));
    if (!values_) throw std::bad_alloc();
    clear();
  }
  void clear() { std::fill_n(values_.get(), size_, Real{}); }
  std::size_t size() const { return size_; }
  Real *data() { return values_.get(); }
  const Real *data() const { return values_.get(); }
  Real &operator[](std::size_t i) { return values_[i]; }
  const Real &operator[](std::size_t i) const { return values_[i]; }

private:
  struct Free {
    void operator()(Real *values) const { std::free(values); }
  };
  std::size_t size_ = 0;
  std::unique_ptr<Real[], Free> values_;
};

/// Row-major block whose rows lie `stride` numbers apart: an odd number of cache lines, so that a column of it does not
/// end up in a few places of the cache.
template <class Real> class Slab {
public:
  Slab() = default;
  Slab(std::size_t rows, std::size_t columns)
      : rows_(rows), columns_(columns), stride_(static_cast<std::size_t>(padded<Real>(static_cast<int>(columns)))) {
    constexpr std::size_t line = 64 / sizeof(Real);
    if (stride_ / line % 2 == 0) stride_ += line;
    values_ = Aligned<Real>(rows_ * stride_);
  }

  std::size_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }
  std::size_t stride() const { return stride_; }
  Real *row(std::size_t i) { return values_.data() + i * stride_; }
  const Real *row(std::size_t i) const { return values_.data() + i * stride_; }

private:
  std::size_t rows_ = 0, columns_ = 0, stride_ = 0;
  Aligned<Real> values_;
};

/// out (count, padded) = rows first .. first + count of the slab times b (columns, padded).
void multiply(const Slab<double> &slab, std::size_t first, std::size_t count, const double *b, int padded, double *out);
void multiply(const Slab<float> &slab, std::size_t first, std::size_t count, const float *b, int padded, float *out);

/// out (columns, padded) += (those rows)^T times f (count, padded).
void add_transposed(const Slab<float> &slab, std::size_t first, std::size_t count, const float *f, int padded,
                    float *out);

} // namespace dovetail
