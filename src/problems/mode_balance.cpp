#include "problems/mode_balance.hpp"

#include <cmath>

#include "harmonic/lowest_harmonic.hpp"

namespace dovetail {
namespace {

constexpr double orthogonal = 1e-9; // work of a load on a mode, relative to the sum of its parts' sizes

} // namespace

ModeBalance balance_of(const NonlinearMode &mode, const ModeState &state) {
  const HarmonicSystem &system = mode.system();
  const Layout &layout = system.layout();
  const int n = layout.width, driven = lowest_harmonic(system.loads());
  const DynamicStiffness structure(system.scaled().damping, state.omega);
  const std::vector<double> &q = mode.coefficients(), &u = system.stiffness_force(), &v = system.inertia_force(),
                            &C = system.damping_force(), &S = system.hysteretic_force(), &G = system.contact_force();
  const std::size_t contact = layout.own_point_offset(0);
  // friction, structure, mass by k^2, work of the load in phase and out of phase, sizes of its parts
  double sums[6] = {};
  for (PetscInt d = 0; d < layout.own_dofs(); ++d)
    for (int k = 1; k <= n / 2; ++k) {
      const std::size_t c = d * n + cosine(k), s = d * n + sine(k);
      const auto with = [&](const std::vector<double> &force) { return q[c] * force[c] + q[s] * force[s]; };
      if (c >= contact) sums[0] += M_PI * k * (G[c - contact] * q[s] - G[s - contact] * q[c]);
      double lost = structure.loss(k) * with(u) + structure.drag(k) * with(v);
      if (!C.empty()) lost += structure.turn(k) * with(C);
      if (!S.empty()) lost += structure.hysteresis(k) * with(S);
      sums[1] += M_PI * k * lost;
      sums[2] += k * k * with(v);
    }
  const bool same_wave = system.wave().index(driven) == system.wave().index(1);
  for (PetscInt d = 0; d < layout.own_dofs() && driven > 0 && same_wave; ++d) {
    const double Fc = force_coefficient(system.loads(), d, cosine(driven)),
                 Fs = force_coefficient(system.loads(), d, sine(driven));
    const double c = q[d * n + cosine(1)] / state.amplitude, s = q[d * n + sine(1)] / state.amplitude;
    sums[3] += c * Fc + s * Fs, sums[4] += s * Fc - c * Fs;
    sums[5] += std::hypot(c, s) * std::hypot(Fc, Fs);
  }
  MPI_Allreduce(MPI_IN_PLACE, sums, 6, MPI_DOUBLE, MPI_SUM, layout.comm);
  ModeBalance out;
  out.friction = sums[0], out.structure = sums[1];
  out.unit = 2 * M_PI * state.omega * state.omega * sums[2], out.fed = state.ratio * out.unit;
  const double work = std::hypot(sums[3], sums[4]);
  out.load =
      work > orthogonal * sums[5] ? 2 * state.ratio * state.omega * state.omega * state.amplitude / work : INFINITY;
  return out;
}

} // namespace dovetail
