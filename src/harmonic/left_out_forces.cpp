#include "harmonic/left_out_forces.hpp"

#include <cmath>

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "estimating what modes do that are left out";

} // namespace

LeftOutModes::LeftOutModes(HarmonicSystem &system, Vec y)
    : system_(system), left_(system.scaled().model.reduced.left_out),
      count_(static_cast<PetscInt>(left_.squares.size())) {
  system.set(system.parameter_in(y));
}

const double *LeftOutModes::mass(PetscInt d) const {
  const PetscInt modes = system_.layout().own_modes.size();
  return d < modes ? &left_.with_modes[(system_.layout().own_modes.begin + d) * count_]
                   : &left_.coupling[(d - modes) * count_];
}

std::vector<double> LeftOutModes::motion(Vec y, double load) const {
  const Layout &layout = system_.layout();
  const PetscInt r = count_, n = layout.width;
  const DynamicStiffness structure = system_.structure(system_.setting().omega);
  std::vector<double> z(r * n, 0.0); // M_lx x + M_la a, then the modes' motion
  const double *q;
  check(VecGetArrayRead(y, &q), doing);
  for (PetscInt d = 0; d < layout.own_dofs(); ++d)
    for (PetscInt j = 0; j < r; ++j)
      for (PetscInt c = 1; c < n; ++c) z[j * n + c] += mass(d)[j] * q[d * n + c];
  check(VecRestoreArrayRead(y, &q), doing);
  MPI_Allreduce(MPI_IN_PLACE, z.data(), static_cast<int>(z.size()), MPI_DOUBLE, MPI_SUM, layout.comm);
  for (PetscInt j = 0; j < r; ++j) // eq (11) of each mode by itself, driven by the load and by moving contacts
    for (int k = 1; k <= system_.harmonics(); ++k) {
      const double w2 = structure.inertia(k), drag = structure.drag(k);
      const double stiffness = structure.in_phase(k, left_.squares[j], 1),
                   d = structure.quadrature(k, left_.squares[j], 1), size = stiffness * stiffness + d * d;
      double &c = z[j * n + cosine(k)], &s = z[j * n + sine(k)];
      const double fc = force_coefficient(system_.left_out_loads(), j, cosine(k), load) + w2 * c - drag * s,
                   fs = force_coefficient(system_.left_out_loads(), j, sine(k), load) + w2 * s + drag * c;
      c = (stiffness * fc - d * fs) / size, s = (stiffness * fs + d * fc) / size;
    }
  return z;
}

void LeftOutModes::forces(const std::vector<double> &motion, Vec residual) const {
  const Layout &layout = system_.layout();
  const PetscInt n = layout.width;
  const DynamicStiffness structure = system_.structure(system_.setting().omega);
  double *out;
  check(VecSet(residual, 0), doing);
  check(VecGetArray(residual, &out), doing);
  for (PetscInt d = 0; d < layout.own_dofs(); ++d) // -mu_k times the mass in common times their motion
    for (PetscInt j = 0; j < count_; ++j)
      for (int k = 1; k <= system_.harmonics(); ++k) {
        const double w2 = structure.inertia(k), drag = structure.drag(k), c = motion[j * n + cosine(k)],
                     s = motion[j * n + sine(k)];
        out[d * n + cosine(k)] -= mass(d)[j] * (w2 * c - drag * s);
        out[d * n + sine(k)] -= mass(d)[j] * (w2 * s + drag * c);
      }
  check(VecRestoreArray(residual, &out), doing);
}

} // namespace dovetail
