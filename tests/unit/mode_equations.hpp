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

/// The work of the residual at y along the velocity of the motion, over a period. Collective.
inline double work_of_residual(NonlinearMode &mode, Vec y, double alpha) {
  UniqueVec f = mode.unknowns();
  mode.residual(y, f);
  const Layout &layout = mode.system().layout();
  const int w = layout.width;
  const double *r;
  check(VecGetArrayRead(f, &r), "");
  double work = 0;
  for (PetscInt i = 0; i < layout.own_dofs(); ++i)
    for (int k = 1; k <= w / 2; ++k)
      work += M_PI * k * alpha *
              (r[i * w + cosine(k)] * mode.coefficients()[i * w + sine(k)] -
               r[i * w + sine(k)] * mode.coefficients()[i * w + cosine(k)]);
  check(VecRestoreArrayRead(f, &r), "");
  MPI_Allreduce(MPI_IN_PLACE, &work, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return work;
}

} // namespace dovetail::testing
