#pragma once
// Modes of a cyclic sector without the loss of the interior modes left out: inverse iteration with K^h itself, by
// solves with the real factor and the dense stiffness of the faces. The sparse matrices stay real.
#include "reduction/clamped_structure.hpp"
#include "reduction/sector_coordinates.hpp"

namespace dovetail {

struct ExactModes {
  std::vector<double> squares;  ///< ascending [rad^2/s^2]
  Tall moved;                   ///< (own rows wanted later, 2 count): real parts, then imaginary ones; v^H M^h v = 1
  ComplexDense carried;         ///< (n_b, count) M v as b feels it: (M v)_b + Psi^T (M v)_e
  std::vector<ComplexDense> fa; ///< (count, 1) v^H F of each load pattern
  int steps = 0;                ///< iterations made
  double change = 0;            ///< of a square in the last one, the largest, relative
  double first_change = 0;      ///< likewise in the first one
};

struct FirstGuess {
  const Tall &interior; ///< (own, N_m) interior modes
  const std::vector<double> &squares;
  const ComplexDense &by_modes; ///< (N_m, p)
  const ComplexDense &held;     ///< (n_b, p)
};

/// The `count` lowest modes with x held, from p >= count vectors. `E`: of the index; `S`: its stiffness of s, positive.
/// Ends when no square changes by more than `tolerance`, or after that many steps. Collective. ComputeError.
ExactModes exact_modes(const ClampedStructure &parts, const SectorCoordinates &E, const ComplexDense &S,
                       const FirstGuess &guess, PetscInt count, int steps, double tolerance);

} // namespace dovetail
