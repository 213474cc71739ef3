#pragma once
// Counts for MPI, BLAS, LAPACK, ScaLAPACK and METIS, which take no more than an int holds.
#include <climits>
#include <cstddef>
#include <string>

#include "support/error.hpp"

namespace dovetail {

/// The count as an int. ComputeError if it is none; `what` is counted, and what helps: "numbers ...; take more ranks".
inline int int_count(std::size_t count, const char *what) {
  if (count > INT_MAX)
    throw ComputeError(std::to_string(count) + " is beyond the 32-bit counts of MPI and LAPACK: " + what);
  return static_cast<int>(count);
}

} // namespace dovetail
