#include "modal/dampers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "contact/law_traits.hpp"
#include "modal/modal_factors.hpp"
#include "stuck/own_rows.hpp"

namespace dovetail {
namespace {

// Of a contact point, those that act at the preload state: open it has none, where it slips the normal one.
std::array<double, 3> springs_at_rest(const ContactPoint &point, const Standstill &at_rest) {
  constexpr double bound = 1 - 1e-9; // of friction, to rounding errors of the preload
  std::array<double, 3> springs = stuck_springs(point);
  const std::array<double, 3> &force = at_rest.force;
  if (may_open(point.law) && !(force[2] > 0)) return {};
  for (int d = 0; d < 2; ++d) {
    const double size = shares_slider(point.law) ? std::hypot(force[0], force[1]) : std::abs(force[d]);
    if (!(size < bound * point.mu[d] * force[2])) springs[d] = 0;
  }
  return springs;
}

} // namespace

Dampers::Dampers(const ReducedModel &model, const std::vector<ContactPoint> &contact,
                 const std::vector<Standstill> &standstill, const Damping &damping, const Layout &layout)
    : layout_(layout) {
  const bool fixed = damping.of_fixed && !damping.ratios.empty(), springs = damping.contact && damping.stiffness != 0;
  const PetscInt modes = layout.own_modes.size();
  has_diagonal_ = fixed || springs;
  if (has_diagonal_) diagonal_.assign(layout.own_dofs(), 0.0);
  for (const ModeRatio &ratio : damping.ratios)
    if (const PetscInt mode = ratio.mode - 1 - layout.own_modes.begin; fixed && mode >= 0 && mode < modes)
      diagonal_[mode] = 2 * ratio.ratio * std::sqrt(model.kaa[ratio.mode - 1]);
  for (std::size_t p = 0; springs && p < contact.size(); ++p)
    for (int d = 0; d < 3; ++d)
      diagonal_[modes + 3 * p + d] = damping.stiffness * springs_at_rest(contact[p], standstill[p])[d];
  if (damping.matrix) viscous_ = own_rows(model.viscous, model);
  if (damping.of_parts && damping.structural != 0) hysteretic_ = own_rows(model.structural, model);
}

Slab<double> Dampers::own_rows(const DampingMatrix &matrix, const ReducedModel &model) const {
  const std::size_t na = layout_.modes, nc = 3 * layout_.points, modes = layout_.own_modes.size();
  Slab<double> rows(layout_.own_dofs(), na + nc);
  const Slab<double> of_modes = rows_of_modes(matrix.xa, layout_);
  for (std::size_t j = 0; j < modes; ++j) {
    std::copy_n(&matrix.aa[(layout_.own_modes.begin + j) * na], na, rows.row(j));
    std::copy_n(of_modes.row(j), nc, rows.row(j) + na);
  }
  for (PetscInt i = 0; i < model.own_contact_dofs(); ++i) {
    std::copy_n(matrix.xa.data() + i * na, na, rows.row(modes + i));
    std::copy_n(&matrix.xx[i * nc], nc, rows.row(modes + i) + na);
  }
  return rows;
}

void Dampers::take_ratios(LinearPart &part, const StuckBasis &basis, const std::vector<ModeRatio> &ratios) {
  const std::size_t r = ratios.size(), w = layout_.width;
  const PetscInt own = layout_.own_dofs();
  std::vector<double> q(layout_.own_coefficients()), stiff(q.size()), heavy(q.size());
  shapes_.resize(own * r);
  for (std::size_t j = 0; j < r; ++j) {
    const PetscInt mode = ratios[j].mode - 1;
    rates_.push_back(rate_of(basis, ratios[j]));
    for (PetscInt d = 0; d < own; ++d) q[d * w] = basis.exact.row(d)[mode];
    part.multiply(q.data(), stiff.data(), heavy.data());
    for (PetscInt d = 0; d < own; ++d) shapes_[d * r + j] = heavy[d * w];
  }
}

void Dampers::add_local(const double *q, int width, double *out) const {
  for (std::size_t d = 0; d < diagonal_.size(); ++d)
    for (int i = 0; i < width; ++i) out[d * width + i] += diagonal_[d] * q[d * width + i];
}

void Dampers::add_dense(const Slab<double> &rows, const double *q, int width, double *out) const {
  if (rows.columns() == 0) return;
  const std::size_t n = layout_.dofs(), own = layout_.own_dofs(), w = width;
  std::vector<double> all, received;
  gather(layout_, std::vector<double>(q, q + own * w), received, MPI_DOUBLE);
  all.resize(n * w);
  const double *from = received.data();
  for (int rank = 0; rank < layout_.size; ++rank)
    for (const PetscInt number : numbers_of(layout_, rank)) std::copy_n(from, w, &all[number * w]), from += w;
  gemm("N", "N", w, own, n, all.data(), w, rows.row(0), rows.stride(), 1, out, w);
}

void Dampers::viscous_force(const double *q, int width, double *out) const {
  const std::size_t r = rates_.size(), w = width, own = layout_.own_dofs();
  std::fill_n(out, own * w, 0.0);
  if (r > 0) {
    std::vector<double> along(r * w, 0.0); // c V^T q
    for (std::size_t d = 0; d < own; ++d)
      for (std::size_t j = 0; j < r; ++j)
        for (std::size_t i = 0; i < w; ++i) along[j * w + i] += rates_[j] * shapes_[d * r + j] * q[d * w + i];
    MPI_Allreduce(MPI_IN_PLACE, along.data(), static_cast<int>(along.size()), MPI_DOUBLE, MPI_SUM, layout_.comm);
    for (std::size_t d = 0; d < own; ++d)
      for (std::size_t j = 0; j < r; ++j)
        for (std::size_t i = 0; i < w; ++i) out[d * w + i] += shapes_[d * r + j] * along[j * w + i];
  }
  add_local(q, width, out);
  add_dense(viscous_, q, width, out);
}

void Dampers::hysteretic_force(const double *q, int width, double *out) const {
  std::fill_n(out, static_cast<std::size_t>(layout_.own_dofs()) * width, 0.0);
  add_dense(hysteretic_, q, width, out);
}

std::vector<Dampers::Entry> Dampers::entries() const {
  const std::size_t r = rates_.size();
  std::vector<double> all; // of V, ranks one after the other, as rows of the harmonic system are
  gather(layout_, shapes_, all, MPI_DOUBLE);
  const PetscInt first = layout_.first_dof(), own = layout_.own_dofs();
  std::vector<Entry> out;
  for (PetscInt number = 0; number < layout_.dofs(); ++number) {
    const PetscInt e = number < layout_.modes ? layout_.mode_row(number) : layout_.contact_row(number - layout_.modes);
    for (PetscInt d = 0; d < own; ++d) {
      Entry entry{first + d, e, 0, 0};
      for (std::size_t j = 0; j < r; ++j) entry.viscous += shapes_[d * r + j] * rates_[j] * all[e * r + j];
      if (has_diagonal_ && entry.row == e) entry.viscous += diagonal_[d];
      if (viscous_.columns() > 0) entry.viscous += viscous_.row(d)[number];
      if (hysteretic_.columns() > 0) entry.hysteretic = hysteretic_.row(d)[number];
      if (entry.viscous != 0 || entry.hysteretic != 0) out.push_back(entry);
    }
  }
  return out;
}

void Dampers::project(StuckBasis &basis) const {
  const std::size_t n = layout_.dofs(), own = layout_.own_dofs();
  std::vector<double> shapes(own * n);
  for (std::size_t d = 0; d < own; ++d) std::copy_n(basis.exact.row(d), n, &shapes[d * n]);
  const auto in_modes = [&](std::vector<double> &diagonal, Slab<float> &rows, const std::vector<double> &moved) {
    std::vector<double> share(n * n);
    gemm("N", "T", n, n, own, moved.data(), n, basis.exact.row(0), basis.exact.stride(), 0, share.data(), n);
    std::vector<int> counts;
    for (int rank = 0; rank < layout_.size; ++rank)
      counts.push_back(static_cast<int>(share_of(layout_.dofs(), rank, layout_.size).size() * n));
    const Range mine = own_share(layout_.comm, layout_.dofs());
    std::vector<double> product(mine.size() * n);
    MPI_Reduce_scatter(share.data(), product.data(), counts.data(), MPI_DOUBLE, MPI_SUM, layout_.comm);
    std::vector<double> found(n, 0.0);
    rows = Slab<float>(mine.size(), n);
    for (PetscInt i = 0; i < mine.size(); ++i) {
      found[mine.begin + i] = std::exchange(product[i * n + mine.begin + i], 0.0);
      std::copy_n(&product[i * n], n, rows.row(i));
    }
    MPI_Allreduce(MPI_IN_PLACE, found.data(), static_cast<int>(n), MPI_DOUBLE, MPI_SUM, layout_.comm);
    for (std::size_t j = 0; j < n; ++j) diagonal[j] += found[j];
  };
  std::vector<double> moved(own * n, 0.0);
  if (viscous_.columns() > 0 || has_diagonal_) {
    add_local(shapes.data(), static_cast<int>(n), moved.data());
    add_dense(viscous_, shapes.data(), static_cast<int>(n), moved.data());
    in_modes(basis.rates, basis.viscous, moved);
  }
  if (!is_hysteretic()) return;
  hysteretic_force(shapes.data(), static_cast<int>(n), moved.data());
  in_modes(basis.losses, basis.hysteretic, moved);
}

} // namespace dovetail
