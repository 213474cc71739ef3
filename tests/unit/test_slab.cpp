// Products of slabs with few columns, against sums written out.
#include <gtest/gtest.h>

#include <cmath>

#include "harmonic/strands.hpp"

using namespace dovetail;

namespace {

template <class Real> Slab<Real> waves(std::size_t rows, std::size_t columns) {
  Slab<Real> slab(rows, columns);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) slab.row(i)[j] = static_cast<Real>(std::sin(1.0 + 0.7 * i + 1.3 * j));
  return slab;
}

template <class Real> Aligned<Real> sheaf(std::size_t rows, int width, int room) {
  Aligned<Real> values(rows * room);
  for (std::size_t i = 0; i < rows; ++i)
    for (int j = 0; j < width; ++j) values[i * room + j] = static_cast<Real>(std::cos(0.3 * i - 1.9 * j));
  return values;
}

// Of rows `first` onwards; largest error of slab times b.
template <class Real> double error_of_product(std::size_t count, std::size_t columns, int width) {
  constexpr std::size_t first = 2;
  const int room = padded<Real>(width);
  const auto slab = waves<Real>(first + count, columns);
  const auto b = sheaf<Real>(columns, width, room);
  Aligned<Real> out(count * room);
  multiply(slab, first, count, b.data(), room, out.data());
  double error = 0;
  for (std::size_t i = 0; i < count; ++i)
    for (int k = 0; k < room; ++k) {
      double sum = 0;
      for (std::size_t j = 0; j < columns; ++j) sum += double(slab.row(first + i)[j]) * b[j * room + k];
      error = std::max(error, std::abs(sum - out[i * room + k]));
    }
  return error;
}

double error_of_transposed(std::size_t count, std::size_t columns, int width) {
  const int room = padded<float>(width);
  const auto slab = waves<float>(count, columns);
  const auto f = sheaf<float>(count, width, room);
  auto out = sheaf<float>(columns, width, room);
  const auto before = sheaf<float>(columns, width, room);
  add_transposed(slab, 0, count, f.data(), room, out.data());
  double error = 0;
  for (std::size_t j = 0; j < columns; ++j)
    for (int k = 0; k < room; ++k) {
      double sum = before[j * room + k];
      for (std::size_t i = 0; i < count; ++i) sum += double(slab.row(i)[j]) * f[i * room + k];
      error = std::max(error, std::abs(sum - out[j * room + k]));
    }
  return error;
}

} // namespace

TEST(Slab, products) { // every way of filling the registers, and what is left over
  for (const int width : {1, 7, 11, 21, 41, 61})
    for (const std::size_t rows : {0, 1, 3, 8, 23, 24, 29, 51})
      for (const std::size_t columns : {1, 7, 40, 130}) {
        EXPECT_LT(error_of_product<double>(rows, columns, width), 1e-12) << rows << " " << columns << " " << width;
        EXPECT_LT(error_of_product<float>(rows, columns, width), 1e-4) << rows << " " << columns << " " << width;
        EXPECT_LT(error_of_transposed(rows, columns, width), 1e-4) << rows << " " << columns << " " << width;
      }
}

TEST(Slab, rows_do_not_fall_into_the_same_places_of_the_cache) {
  for (const std::size_t columns : {1, 8, 100, 1000, 1024}) {
    const Slab<double> slab(2, columns);
    EXPECT_GE(slab.stride(), columns);
    EXPECT_EQ(slab.stride() * sizeof(double) / 64 % 2, 1u);
  }
}

// Slab times strands, and its transpose; largest error of both.
template <class Real> double error_of_strands(std::size_t count, std::size_t columns, int width) {
  constexpr std::size_t first = 2;
  const auto slab = waves<Real>(first + count, columns);
  Bundle<Real> b(slab, width, false);
  for (int k = 0; k < width; ++k)
    for (std::size_t j = 0; j < columns; ++j) b.at(j, k) = static_cast<Real>(std::cos(0.3 * j - 1.9 * k));
  std::vector<Real> out(count * width);
  b.multiplied(slab, first, count, out.data());
  double error = 0;
  for (std::size_t i = 0; i < count; ++i)
    for (int k = 0; k < width; ++k) {
      double sum = 0;
      for (std::size_t j = 0; j < columns; ++j) sum += double(slab.row(first + i)[j]) * b.at(j, k);
      error = std::max(error, std::abs(sum - out[i * width + k]));
    }
  if constexpr (std::is_same_v<Real, float>) {
    double largest = 1; // of what is multiplied
    for (const Real value : out) largest = std::max<double>(largest, std::abs(value));
    Bundle<Real> turned(slab, width, false);
    turned.add_transposed_of(slab, first, count, out.data());
    for (std::size_t j = 0; j < columns; ++j)
      for (int k = 0; k < width; ++k) {
        double sum = 0;
        for (std::size_t i = 0; i < count; ++i) sum += double(slab.row(first + i)[j]) * out[i * width + k];
        error = std::max(error, std::abs(sum - turned.at(j, k)) / largest);
      }
  }
  return error;
}

TEST(Strands, are_products_of_a_slab) {
  for (const std::size_t count : {1u, 5u, 24u, 31u})
    for (const std::size_t columns : {1u, 17u, 130u})
      for (int width = 1; width <= 11; ++width) {
        EXPECT_LT(error_of_strands<double>(count, columns, width), 1e-13 * columns);
        EXPECT_LT(error_of_strands<float>(count, columns, width), 2e-7 * (columns + count))
            << count << " rows, " << columns << " columns, width " << width;
      }
}
