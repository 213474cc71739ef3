// Products of slabs with few columns, against sums written out in double precision.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <new>

#include "product_forms.hpp"

using namespace dovetail;

namespace {

template <class Real> Slab<Real> waves(std::size_t rows, std::size_t columns) {
  Slab<Real> slab(rows, columns);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) slab.row(i)[j] = static_cast<Real>(std::sin(1.0 + 0.7 * i + 1.3 * j));
  return slab;
}

template <class Real> Real other_wave(std::size_t i, int c) { return static_cast<Real>(std::cos(0.3 * i - 1.9 * c)); }

// (width, stride), zero beyond `columns`.
template <class Real> Aligned<Real> strands(const Slab<Real> &slab, int width) {
  Aligned<Real> values(width * slab.stride());
  for (int c = 0; c < width; ++c)
    for (std::size_t j = 0; j < slab.columns(); ++j) values[c * slab.stride() + j] = other_wave<Real>(j, c);
  return values;
}

constexpr std::size_t first = 2; // row of those taken

// Largest error of rows of a slab times strands.
template <class Real, class Product>
double error_of_product(const Slab<Real> &slab, std::size_t count, int width, const Product &product) {
  const auto b = strands(slab, width);
  std::vector<Real> out(count * width + 1, Real{7}); // overwritten, but for the last one
  product(rows_of(slab, first, count), b.data(), width, out.data());
  double error = std::abs(out.back() - 7);
  for (std::size_t i = 0; i < count; ++i)
    for (int c = 0; c < width; ++c) {
      double sum = 0;
      for (std::size_t j = 0; j < slab.columns(); ++j) sum += double(slab.row(first + i)[j]) * b[c * slab.stride() + j];
      error = std::max(error, std::abs(sum - out[i * width + c]));
    }
  return error;
}

// Of their transpose, added to strands.
double error_of_transposed(const Slab<float> &slab, std::size_t count, int width, const ProductForm &form) {
  std::vector<float> f(count * width);
  for (std::size_t i = 0; i < count; ++i)
    for (int c = 0; c < width; ++c) f[i * width + c] = other_wave<float>(i, c);
  const auto before = strands(slab, width);
  auto out = strands(slab, width);
  form.add_transposed(rows_of(slab, first, count), f.data(), width, out.data());
  double error = 0;
  for (int c = 0; c < width; ++c)
    for (std::size_t j = 0; j < slab.stride(); ++j) {
      double sum = before[c * slab.stride() + j];
      for (std::size_t i = 0; i < count && j < slab.columns(); ++i)
        sum += double(slab.row(first + i)[j]) * f[i * width + c];
      error = std::max(error, std::abs(sum - out[c * slab.stride() + j]));
    }
  return error;
}

} // namespace

TEST(SlabProducts, are_sums_in_every_width_and_form) {
  const std::size_t columns = 37, count = 11;
  const auto slab = waves<float>(first + count, columns);
  const auto exact = waves<double>(first + count, columns);
  for (const ProductForm &form : product_forms())
    for (int width = 1; width <= 81; ++width) {
      EXPECT_LT(error_of_product(slab, count, width, form.multiply), 2e-5) << form.name << ", width " << width;
      EXPECT_LT(error_of_product(exact, count, width, form.multiply_double), 1e-13) << form.name << ", width " << width;
      EXPECT_LT(error_of_transposed(slab, count, width, form), 2e-5) << form.name << ", width " << width;
    }
}

TEST(SlabProducts, are_sums_of_any_numbers_of_rows_and_columns) { // several pieces of a strand, and what is left over
  for (const std::size_t count : {0, 1, 3, 24, 31})
    for (const std::size_t columns : {1, 17, 130, 1100}) {
      const auto slab = waves<float>(first + count, columns);
      for (const ProductForm &form : product_forms())
        for (const int width : {1, 11, 21}) {
          EXPECT_LT(error_of_product(slab, count, width, form.multiply), 1e-6 * (columns + 10))
              << form.name << ", " << count << " rows, " << columns << " columns, width " << width;
          EXPECT_LT(error_of_transposed(slab, count, width, form), 1e-6 * (count + 10))
              << form.name << ", " << count << " rows, " << columns << " columns, width " << width;
        }
    }
}

TEST(SlabProducts, of_the_program_are_sums_as_well) {
  const std::size_t columns = 130, count = 23;
  const int width = 11;
  const auto slab = waves<float>(first + count, columns);
  Bundle<float> b(slab, width), turned(slab, width);
  for (int c = 0; c < width; ++c)
    for (std::size_t j = 0; j < columns; ++j) b.at(j, c) = other_wave<float>(j, c);
  std::vector<float> out(count * width);
  b.multiplied(slab, first, count, out.data());
  turned.add_transposed_of(slab, first, count, out.data());
  for (int c = 0; c < width; ++c)
    for (std::size_t j = 0; j < columns; ++j) {
      double sum = 0;
      for (std::size_t i = 0; i < count; ++i)
        for (std::size_t k = 0; k < columns; ++k)
          sum += double(slab.row(first + i)[j]) * slab.row(first + i)[k] * b.at(k, c);
      EXPECT_NEAR(turned.at(j, c), sum, 5e-3) << j << ", " << c;
    }
}

TEST(SlabProducts, show_what_is_not_a_number_where_it_enters) {
  const std::size_t columns = 37, count = 9, bad_row = 4, bad_column = 20;
  const int width = 11, bad_strand = 3;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  auto slab = waves<float>(first + count, columns);
  for (const ProductForm &form : product_forms()) {
    auto b = strands(slab, width);
    b[bad_strand * slab.stride() + bad_column] = nan;
    std::vector<float> out(count * width);
    form.multiply(rows_of(slab, first, count), b.data(), width, out.data());
    for (std::size_t i = 0; i < count; ++i)
      for (int c = 0; c < width; ++c) EXPECT_EQ(std::isnan(out[i * width + c]), c == bad_strand) << form.name;

    std::vector<float> f(count * width, 1.0f);
    f[bad_row * width + bad_strand] = nan;
    Aligned<float> turned(width * slab.stride());
    form.add_transposed(rows_of(slab, first, count), f.data(), width, turned.data());
    for (int c = 0; c < width; ++c)
      for (std::size_t j = 0; j < columns; ++j)
        EXPECT_EQ(std::isnan(turned[c * slab.stride() + j]), c == bad_strand) << form.name;
  }
}

TEST(Slab, rows_do_not_fall_into_the_same_places_of_the_cache) {
  for (const std::size_t columns : {1, 8, 100, 1000, 1024}) {
    const Slab<double> slab(2, columns);
    EXPECT_GE(slab.stride(), columns);
    EXPECT_EQ(slab.stride() * sizeof(double) / 64 % 2, 1u);
  }
}

TEST(Slab, begins_and_ends_with_a_line_of_the_cache) {
  for (const std::size_t bytes : {0, 1, 64, 65, 5 << 20}) {
    const std::unique_ptr<void, void (*)(void *)> memory(allocate_lines(bytes), std::free);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(memory.get()) % 64, 0u);
    std::fill_n(static_cast<char *>(memory.get()), (bytes + 63) / 64 * 64, 'x');
  }
  EXPECT_THROW(allocate_lines(std::size_t(1) << 60), std::bad_alloc);
}
