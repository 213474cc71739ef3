#pragma once
// Harmonics that share matrices: those whose spatial indices on a sector have one |h|, or all of them where there is no
// cyclic symmetry. With complex Phi = R + i I of that |h|, and y = c - i s of a harmonic,
//     Phi y:    R c + I s,  R s - I c;        Phi^H y:    R^T c - I^T s,  R^T s + I^T c;
// of -h with -I. So [R I] is applied to two blocks of rows, y and what stands beside I; its transpose gives two, which
// are put together.
#include <vector>

#include "case/travelling_wave.hpp"
#include "stuck/layout.hpp"

namespace dovetail {

struct IndexGroup {
  int index = 0;                 ///< |h|
  bool complex = false;          ///< not 0; of N/2, which is real, too
  bool whole = false;            ///< all coefficients in their order, and real
  std::vector<int> coefficients; ///< (columns) their places among the 2H+1
  std::vector<int> partners;     ///< (columns) the column of the other of its pair; of the mean its own
  std::vector<double> turns;     ///< (columns) sign that the other enters with, beside I

  int columns() const { return static_cast<int>(coefficients.size()); }

  /// From a row of 2H+1: what R is applied to in a column, and what I is.
  template <class Real> Real real(int column, const Real *row) const { return row[coefficients[column]]; }
  template <class Real> Real imaginary(int column, const Real *row) const {
    return static_cast<Real>(turns[column]) * row[coefficients[partners[column]]];
  }
  /// What belongs into the row, from what R^T gives in that column, and I^T in its partner.
  template <class Real> Real joined(int column, Real of_real, Real of_imaginary) const {
    return of_real - static_cast<Real>(turns[column]) * of_imaginary;
  }
};

/// Of all harmonics, in the order of |h|.
std::vector<IndexGroup> groups_of(const TravellingWave &wave, int width);

} // namespace dovetail
