#pragma once
// A sum of reduced dofs, such as the motion of a node, from coefficients of these and back.
#include <petscsys.h>

#include <complex>
#include <vector>

#include "case/travelling_wave.hpp"

namespace dovetail {

class WatchedRow {
public:
  /// One factor for each dof, (N_a + 3 N_x).
  WatchedRow(std::vector<double> factors) : of_mean_(std::move(factors)) {}
  /// Of a cyclic sector: complex ones for each index h = 0 .. N / 2, conjugate for -h.
  WatchedRow(std::vector<std::vector<std::complex<double>>> by_index, const TravellingWave &wave);

  /// sum += the part of dof `number`, whose coefficients are c; `width` of both.
  void add(PetscInt number, const double *c, int width, double *sum) const;
  /// c += the transpose of that times the sum.
  void add_transposed(PetscInt number, const double *sum, int width, double *c) const;
  /// The factors of one dof, times a number.
  void scale(PetscInt number, double by);

private:
  std::complex<double> factor(PetscInt number, int harmonic) const;

  std::vector<double> of_mean_; // or of all harmonics
  std::vector<std::vector<std::complex<double>>> by_index_;
  TravellingWave wave_;
};

} // namespace dovetail
