#pragma once
// How a motion changes with the numbers that it begins with, and with frequency.
#include "support/dense.hpp"

namespace dovetail {

/// A column for each coordinate: its derivatives by all numbers side by side, that by frequency last, then zeros up to
/// whole vectors. Changes are those at the same instant.
struct Tangents {
  int numbers = 0;    ///< frequency among them
  double turning = 1; ///< change of omega that counts as one
  Dense eta, rate;    ///< (padded numbers, n)
  Dense slider;       ///< (padded numbers, 2 points) where a slider stands, as long as it sticks
  Dense along;        ///< (padded numbers, 2 points) direction in which a cone's slider slips
  double largest = 0; ///< entry of eta so far
};

} // namespace dovetail
