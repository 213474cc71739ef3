#include "harmonic/left_out_forces.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "support/error.hpp"
#include "support/shell.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "estimating what modes do that are left out";

template <class Number> const Number *row_of(const LeftOutOf<Number> &left, const Layout &layout, PetscInt d) {
  const PetscInt modes = layout.own_modes.size(), r = static_cast<PetscInt>(left.squares.size());
  return d < modes ? &left.with_modes[(layout.own_modes.begin + d) * r] : &left.coupling[(d - modes) * r];
}

} // namespace

LeftOutModes::LeftOutModes(HarmonicSystem &system, Vec y) : system_(system) {
  const ReducedModel &model = system.scaled().model.reduced;
  std::size_t most = model.left_out.squares.size();
  for (const SectorIndex &index : model.indices) most = std::max(most, index.left_out.squares.size());
  count_ = static_cast<PetscInt>(most);
  system.set(system.parameter_in(y));
}

LeftOutModes::OfHarmonic LeftOutModes::of(int k) const {
  const ReducedModel &model = system_.scaled().model.reduced;
  const int h = system_.wave().index(k);
  if (h == 0) return {&model.left_out.squares, &model.left_out, nullptr, 0};
  const auto &left = model.indices[std::abs(h) - 1].left_out;
  return {&left.squares, nullptr, &left, h < 0 ? -1.0 : 1.0};
}

LeftOutModes::Masses LeftOutModes::masses(const OfHarmonic &left, PetscInt d) const {
  return {left.real ? row_of(*left.real, system_.layout(), d) : nullptr,
          left.complex ? row_of(*left.complex, system_.layout(), d) : nullptr};
}

std::vector<double> LeftOutModes::motion(Vec y, double load) const {
  const Layout &layout = system_.layout();
  const PetscInt r = count_, n = layout.width;
  const DynamicStiffness structure = system_.structure(system_.setting().omega);
  std::vector<double> z(r * n, 0.0); // M_lx x + M_la a, then the modes' motion
  const ReadValues q(y);
  for (int k = 1; k <= system_.harmonics(); ++k) {
    const OfHarmonic left = of(k);
    double *zc = &z[cosine(k) * r], *zs = &z[sine(k) * r];
    for (PetscInt d = 0; d < layout.own_dofs(); ++d) {
      const double c = q[d * n + cosine(k)], s = q[d * n + sine(k)];
      const Masses m = masses(left, d);
      for (std::size_t j = 0; j < left.squares->size(); ++j) { // conj(m) (c - i s)
        const double re = m.real ? m.real[j] : m.complex[j].real(), im = m.real ? 0 : left.sign * m.complex[j].imag();
        zc[j] += re * c - im * s, zs[j] += re * s + im * c;
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, z.data(), static_cast<int>(z.size()), MPI_DOUBLE, MPI_SUM, layout.comm);
  for (int k = 1; k <= system_.harmonics();
       ++k) { // eq (11) of each mode by itself, driven by the load and the contacts
    const OfHarmonic left = of(k);
    const double w2 = structure.inertia(k), drag = structure.drag(k);
    for (std::size_t j = 0; j < left.squares->size(); ++j) {
      const double square = (*left.squares)[j], stiffness = structure.in_phase(k, square, 1),
                   d = structure.quadrature(k, square, 1), size = stiffness * stiffness + d * d;
      double &c = z[cosine(k) * r + j], &s = z[sine(k) * r + j];
      const double fc = force_coefficient(system_.left_out_loads(), j, cosine(k), load) + w2 * c - drag * s,
                   fs = force_coefficient(system_.left_out_loads(), j, sine(k), load) + w2 * s + drag * c;
      c = (stiffness * fc - d * fs) / size, s = (stiffness * fs + d * fc) / size;
    }
  }
  return z;
}

void LeftOutModes::forces(const std::vector<double> &motion, Vec residual) const {
  const Layout &layout = system_.layout();
  const PetscInt r = count_, n = layout.width;
  const DynamicStiffness structure = system_.structure(system_.setting().omega);
  check(VecSet(residual, 0), doing);
  const Values out(residual);
  for (int k = 1; k <= system_.harmonics(); ++k) { // -mu_k times the mass in common times their motion
    const OfHarmonic left = of(k);
    const double w2 = structure.inertia(k), drag = structure.drag(k);
    const double *zc = &motion[cosine(k) * r], *zs = &motion[sine(k) * r];
    for (PetscInt d = 0; d < layout.own_dofs(); ++d) {
      const Masses m = masses(left, d);
      double c = 0, s = 0;
      for (std::size_t j = 0; j < left.squares->size(); ++j) { // m (c - i s)
        const double re = m.real ? m.real[j] : m.complex[j].real(), im = m.real ? 0 : left.sign * m.complex[j].imag();
        c += re * zc[j] + im * zs[j], s += re * zs[j] - im * zc[j];
      }
      out[d * n + cosine(k)] -= w2 * c - drag * s, out[d * n + sine(k)] -= w2 * s + drag * c;
    }
  }
}

} // namespace dovetail
