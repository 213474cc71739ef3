#pragma once
// Sizes of vectors, and how far a Jacobian is from differences of the residual.
#include "harmonic/harmonic_system.hpp"
#include "support/error.hpp"

namespace dovetail::testing {

/// Whether there is no other rank. With others what differs is who owns what, and one motion of a kind shows it.
inline bool alone() {
  int ranks;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  return ranks == 1;
}

inline double norm(Vec v) {
  PetscReal value;
  check(VecNorm(v, NORM_2, &value), "");
  return value;
}

inline double relative_difference(Vec a, Vec b) {
  UniqueVec c;
  check(VecDuplicate(a, c.out()), "");
  check(VecWAXPY(c, -1, a, b), "");
  return norm(c) / norm(b);
}

/// A derivative of the residual as the Jacobian's product and as an extrapolated central difference: both sizes, and
/// that of their difference.
struct TwoWays {
  double product, slope, difference;
};

inline TwoWays along(HarmonicSystem &system, Vec y, Vec v) {
  UniqueVec f = system.unknowns(), slope = system.unknowns(), at = system.unknowns(), product = system.unknowns();
  const UniqueVec border = system.unknowns();
  for (const auto &[h, weight] : {std::pair{2e-5, -1.0 / 3}, {1e-5, 4.0 / 3}})
    for (const double side : {1.0, -1.0}) {
      check(VecWAXPY(at, side * h, v, y), "");
      check(VecSet(f, 0), "");
      system.residual(at, f);
      check(VecAXPY(slope, side * weight / (2 * h), f), "");
    }
  const UniqueMat J = system.matrix();
  system.jacobian(y, border, J);
  check(MatMult(J, v, product), "");
  TwoWays ways{norm(product), norm(slope), 0};
  check(VecAXPY(slope, -1, product), "");
  ways.difference = norm(slope);
  return ways;
}

/// Of the derivative along v, relative to the Jacobian's product, which must not be zero.
inline double directional_error(HarmonicSystem &system, Vec y, Vec v) {
  const TwoWays ways = along(system, y, v);
  return ways.difference / ways.product;
}

} // namespace dovetail::testing
