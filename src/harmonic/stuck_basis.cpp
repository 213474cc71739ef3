#include "harmonic/stuck_basis.hpp"

#include <cmath>

#include "harmonic/dense_modes.hpp"
#include "harmonic/joint_shapes.hpp"
#include "harmonic/kept_modes.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr PetscInt large = 1000; // dofs; the modes of fewer are found within a second

} // namespace

Pencil own_pencil(const ReducedModel &model, const std::vector<double> &springs, const Layout &layout) {
  const std::size_t na = layout.modes, nc = 3 * layout.points, n = na + nc, own = layout.own_dofs(),
                    own_modes = layout.own_modes.size();
  Pencil pencil{std::vector<double>(own * n), std::vector<double>(own * n)};
  auto &[K, M] = pencil;
  for (std::size_t d = 0; d < own_modes; ++d) {
    const std::size_t number = layout.number(d);
    K[d * n + number] = model.kaa[number], M[d * n + number] = 1;
  }
  for (std::size_t i = 0; i < own - own_modes; ++i) {
    const std::size_t row = (own_modes + i) * n, number = layout.number(own_modes + i);
    std::copy_n(&model.kxx[i * nc], nc, &K[row + na]);
    std::copy_n(model.mxa.data() + i * na, na, &M[row]);
    std::copy_n(&model.mxx[i * nc], nc, &M[row + na]);
    K[row + number] += springs[i];
  }
  return pencil;
}

StuckBasis stuck_basis(const ReducedModel &model, std::vector<double> springs, const Layout &layout) {
  const std::size_t n = layout.dofs(), own = layout.own_dofs(), own_modes = layout.own_modes.size();
  StuckBasis basis;
  basis.springs = std::move(springs);
  auto [phi, M] = own_pencil(model, basis.springs, layout); // K_s, until its modes take the place
  const bool kept = layout.dofs() >= large && !model.stuck_file.empty();
  const std::uint64_t of = kept ? fingerprint(layout, phi, M) : 0;
  if (!kept || !read_modes(layout, model.stuck_file, of, basis.lambda, phi)) {
    basis.lambda = layout.dofs() >= large && layout.size > 1 ? dense_modes_on_all_ranks(layout, phi, M)
                                                             : dense_modes_on_one_rank(layout, phi, M);
    if (basis.lambda.empty()) throw InputError(mass_not_positive(model.file));
    if (kept) keep_modes(layout, model.stuck_file, of, basis.lambda, phi);
  }
  basis.exact = Slab<double>(own, n), basis.phi = Slab<float>(own, n);
  basis.damped.assign(n, 0.0);
  for (std::size_t i = 0; i < own; ++i) {
    const double *of_dof = &phi[i * n], spring = i < own_modes ? 0 : basis.springs[i - own_modes];
    std::copy_n(of_dof, n, basis.exact.row(i)), std::copy_n(of_dof, n, basis.phi.row(i));
    for (std::size_t j = 0; j < n; ++j) basis.damped[j] -= spring * of_dof[j] * of_dof[j];
  }
  MPI_Allreduce(MPI_IN_PLACE, basis.damped.data(), static_cast<int>(n), MPI_DOUBLE, MPI_SUM, layout.comm);
  for (std::size_t j = 0; j < n; ++j) basis.damped[j] = std::max(0.0, basis.lambda[j] + basis.damped[j]);
  basis.rates.assign(n, 0.0), basis.losses.assign(n, 0.0);
  basis.shapes = joint_shapes(basis, layout);
  return basis;
}

std::vector<double> stuck_springs(const std::vector<ContactPoint> &contact) {
  std::vector<double> springs;
  for (const ContactPoint &point : contact)
    for (const double spring : stuck_springs(point)) springs.push_back(spring);
  return springs;
}

double rate_of(const StuckBasis &basis, const ModeRatio &ratio) {
  return 2 * ratio.ratio * std::sqrt(std::max(0.0, basis.lambda[ratio.mode - 1]));
}

} // namespace dovetail
