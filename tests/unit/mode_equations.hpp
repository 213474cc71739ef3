#pragma once
// Unknowns of a nonlinear mode, and its derivative against differences.
#include <gtest/gtest.h>

#include "norms.hpp"
#include "problems/mode_jacobian.hpp"
#include "small_model.hpp"
#include "support/error.hpp"

namespace dovetail::testing {

/// [Psi; Om; zeta; lam]: a motion of that size, whatever the number of ranks.
inline UniqueVec mode_vector(const NonlinearMode &mode, double mean, double size, int seed,
                             std::array<double, 3> last) {
  UniqueVec y = mode.unknowns();
  const Layout &layout = mode.system().layout();
  double *own;
  check(VecGetArray(y, &own), "");
  for (PetscInt d = 0; d < layout.own_dofs(); ++d)
    for (int i = 0; i < layout.width; ++i)
      own[d * layout.width + i] = (i == 0 ? mean : size) * wave(seed, static_cast<int>(layout.number(d)) * 7 + i);
  if (layout.owns_omega()) std::copy(last.begin(), last.end(), own + layout.own_coefficients());
  check(VecRestoreArray(y, &own), "");
  return y;
}

/// Of J v against an extrapolated central difference of the residual, relative.
inline double derivative_error(NonlinearMode &mode, Vec y, Vec v) {
  const auto J = mode.jacobian();
  UniqueVec plane = mode_vector(mode, 0.2, 0.3, 11, {0.1, -0.2, 0.3}), slope = mode.unknowns(), f = mode.unknowns(),
            moved = mode.unknowns(), product = mode.unknowns();
  J->assemble(y, plane);
  check(MatMult(J->matrix(), v, product), "");
  double along;
  check(VecDot(plane, v, &along), "");
  EXPECT_NEAR(parameter_of(product), along, 1e-12); // its last row is the plane
  for (const auto &[h, weight] : {std::pair{2e-5, -1.0 / 3}, {1e-5, 4.0 / 3}})
    for (const double side : {1.0, -1.0}) {
      check(VecWAXPY(moved, side * h, v, y), "");
      mode.residual(moved, f);
      check(VecAXPY(slope, side * weight / (2 * h), f), "");
    }
  set_parameter(slope, along);
  return relative_difference(product, slope);
}

} // namespace dovetail::testing
