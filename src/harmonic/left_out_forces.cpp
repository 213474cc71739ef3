#include "harmonic/left_out_forces.hpp"

#include <algorithm>
#include <cmath>

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "estimating what modes do that are left out";
// Of its stiffness, at least so much resists in a mode left out. Nearer to their resonances, which are not known that
// well, it counts as if the harmonic were so far away.
constexpr double least_resistance = 0.1;

} // namespace

double left_out_forces(HarmonicSystem &system, Vec y, Vec residual) {
  const Layout &layout = system.layout();
  const LeftOut &left = system.scaled().model.reduced.left_out;
  const PetscInt r = static_cast<PetscInt>(left.squares.size()), n = layout.width, modes = layout.own_modes.size();
  const auto mass = [&](PetscInt d) { // (r) that an own dof has in common with them
    return d < modes ? &left.with_modes[(layout.own_modes.begin + d) * r] : &left.coupling[(d - modes) * r];
  };
  system.set(system.parameter_in(y));
  const DynamicStiffness structure = system.structure(system.setting().omega);
  const double factor = system.setting().load;
  std::vector<double> z(r * n, 0.0); // M_lx x + M_la a, then the modes' motion: (r, 2H+1)
  const double *q;
  double *out, squares = 0;
  check(VecGetArrayRead(y, &q), doing);
  for (PetscInt d = 0; d < layout.own_dofs(); ++d)
    for (PetscInt j = 0; j < r; ++j)
      for (PetscInt c = 1; c < n; ++c) z[j * n + c] += mass(d)[j] * q[d * n + c];
  check(VecRestoreArrayRead(y, &q), doing);
  MPI_Allreduce(MPI_IN_PLACE, z.data(), static_cast<int>(z.size()), MPI_DOUBLE, MPI_SUM, layout.comm);
  for (PetscInt j = 0; j < r; ++j) // eq (11) of each mode by itself, driven by the load and by moving contacts
    for (int k = 1; k <= system.harmonics(); ++k) {
      const double w2 = structure.inertia(k), drag = structure.drag(k), least = least_resistance * left.squares[j],
                   d = structure.quadrature(k, left.squares[j], 1), a = structure.in_phase(k, left.squares[j], 1);
      const double stiffness = std::abs(a) < least ? std::copysign(least, a) : a, size = stiffness * stiffness + d * d;
      double &c = z[j * n + cosine(k)], &s = z[j * n + sine(k)];
      const double fc = force_coefficient(system.left_out_loads(), j, cosine(k), factor) + w2 * c - drag * s,
                   fs = force_coefficient(system.left_out_loads(), j, sine(k), factor) + w2 * s + drag * c;
      c = (stiffness * fc - d * fs) / size, s = (stiffness * fs + d * fc) / size;
      squares += c * c + s * s;
    }
  check(VecSet(residual, 0), doing);
  check(VecGetArray(residual, &out), doing);
  for (PetscInt d = 0; d < layout.own_dofs(); ++d) // -mu_k times the mass in common times their motion
    for (PetscInt j = 0; j < r; ++j)
      for (int k = 1; k <= system.harmonics(); ++k) {
        const double w2 = structure.inertia(k), drag = structure.drag(k), c = z[j * n + cosine(k)],
                     s = z[j * n + sine(k)];
        out[d * n + cosine(k)] -= mass(d)[j] * (w2 * c - drag * s);
        out[d * n + sine(k)] -= mass(d)[j] * (w2 * s + drag * c);
      }
  check(VecRestoreArray(residual, &out), doing);
  return std::sqrt(squares);
}

} // namespace dovetail
