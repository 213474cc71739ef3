#include "problems/mode_border.hpp"

#include <cmath>

#include "support/shell.hpp"

namespace dovetail {

void ModeBorder::take(const NonlinearMode &mode, Vec plane) {
  const HarmonicSystem &system = mode.system();
  const Layout &layout = system.layout();
  const int n = layout.width;
  const std::size_t own = layout.own_coefficients(), first = layout.own_point_offset(0);
  const double alpha = mode.state().amplitude;
  const DynamicStiffness structure = mode.structure();
  for (int b = 0; b < width; ++b) columns[b].assign(own, 0.0), rows[b].assign(own, 0.0);
  auto &[by_omega, by_ratio, by_lam] = columns;
  auto &[length, phase, across] = rows;
  system.by_frequency(structure, by_omega.data());
  const std::vector<double> &v = system.inertia_force(), &G = system.contact_force(), &q = mode.coefficients();
  for (std::size_t i = 0; i < own; ++i) {
    const int place = static_cast<int>(i % n), k = (place + 1) / 2;
    if (place > 0) by_ratio[i] = structure.feeding_slope(k) * (place % 2 ? v[i + 1] : -v[i - 1]) / alpha;
    by_omega[i] /= alpha;
    if (k == 1) length[i] = 2 * v[i] / alpha;
    if (place == sine(1)) phase[i] = mode.reference()[i / n * 2];
    if (place == cosine(1)) phase[i] = -mode.reference()[i / n * 2 + 1];
  }
  swinging_.resize(own - first), along_.resize(own - first);
  for (std::size_t i = 0; i < swinging_.size(); ++i) swinging_[i] = i % n == 0 ? 0 : q[first + i];
  system.contact_forces().multiply(swinging_.data(), along_.data());
  for (std::size_t i = 0; i < swinging_.size(); ++i)
    by_lam[first + i] = std::log(10) * (i % n == 0 ? along_[i] : (along_[i] - G[i]) / alpha);
  const ReadValues of_plane(plane);
  std::copy_n(of_plane + 0, own, across.begin());
  corner.back() = last_of(of_plane);
}

} // namespace dovetail
