#pragma once
// Harmonics that share matrices: those whose spatial indices on a sector have one |h|, or all of them where there is no
// cyclic symmetry. With complex Phi = R + i I of that |h|, and y = c - i s of a harmonic,
//     Phi y:    R c + I s,  R s - I c;        Phi^H y:    R^T c - I^T s,  R^T s + I^T c;
// of -h with -I. So [R I] is applied to two blocks of rows, y and what stands beside I; its transpose gives two, which
// are put together.
#include <vector>

#include "case/travelling_wave.hpp"
#include "harmonic/layout.hpp"

namespace dovetail {

struct IndexGroup {
  int index = 0;                 ///< |h|
  bool complex = false;          ///< not 0
  bool whole = false;            ///< all coefficients in their order, and real
  std::vector<int> coefficients; ///< (columns) their places among the 2H+1
  std::vector<int> partners;     ///< (columns) the column of the other of its pair; of the mean its own
  std::vector<double> turns;     ///< (columns) sign that the other enters with, beside I

  int columns() const { return static_cast<int>(coefficients.size()); }

  /// From a row of 2H+1: what R is applied to, and what I is, if complex.
  template <class From, class To> void part(const From *row, To *real, To *imaginary) const {
    for (int c = 0; c < columns(); ++c) real[c] = static_cast<To>(row[coefficients[c]]);
    if (!complex) return;
    for (int c = 0; c < columns(); ++c) imaginary[c] = static_cast<To>(turns[c] * row[coefficients[partners[c]]]);
  }
  /// Into a row of 2H+1: from what R^T gives, and I^T.
  template <class From, class To> void join(const From *real, const From *imaginary, To *row) const {
    for (int c = 0; c < columns(); ++c) row[coefficients[c]] = static_cast<To>(real[c]);
    if (!complex) return;
    for (int c = 0; c < columns(); ++c) row[coefficients[c]] -= static_cast<To>(turns[c] * imaginary[partners[c]]);
  }
};

/// Of all harmonics, in the order of |h|.
std::vector<IndexGroup> groups_of(const TravellingWave &wave, int width);

} // namespace dovetail
