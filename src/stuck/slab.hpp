#pragma once
// A slab: many rows of many columns, one after the other. What is done with it: slab_products.hpp.
#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <memory>

namespace dovetail {

/// `width` numbers, rounded up to whole cache lines.
template <class Real> constexpr int padded(int width) {
  constexpr int line = 64 / sizeof(Real);
  return (width + line - 1) / line * line;
}

/// Memory from the beginning of a cache line on, to be given back by std::free.
/// bad_alloc: there is none.
void *allocate_lines(std::size_t bytes);

/// Zeros, at the beginning of a cache line.
template <class Real> class Aligned {
public:
  Aligned() = default;
  explicit Aligned(std::size_t size) : size_(size), values_(static_cast<Real *>(allocate_lines(size * sizeof(Real)))) {
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

} // namespace dovetail
