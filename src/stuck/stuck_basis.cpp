#include "stuck/stuck_basis.hpp"

#include <cmath>

#include "stuck/dense_modes.hpp"
#include "stuck/joint_shapes.hpp"
#include "stuck/kept_modes.hpp"
#include "stuck/near_basis.hpp"
#include "stuck/own_rows.hpp"
#include "stuck/sector_pencil.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr PetscInt large = 1000; // dofs; the modes of fewer are found within a second

// From lambda, springs and Phi what else there is.
void complete(const Layout &layout, StuckBasis &basis) {
  const std::size_t n = layout.dofs(), columns = basis.phi.columns();
  basis.damped.assign(n, 0.0);
  basis.each_part(layout.own_modes.size(),
                  [&](const double *rows, std::size_t stride, std::size_t first, std::size_t count) {
                    for (std::size_t i = 0; i < count; ++i) {
                      const double *of_dof = rows + i * stride, spring = basis.springs[first + i];
                      for (std::size_t j = 0; j < columns; ++j) basis.damped[j % n] -= spring * of_dof[j] * of_dof[j];
                    }
                  });
  MPI_Allreduce(MPI_IN_PLACE, basis.damped.data(), static_cast<int>(n), MPI_DOUBLE, MPI_SUM, layout.comm);
  for (std::size_t j = 0; j < n; ++j) basis.damped[j] = std::max(0.0, basis.lambda[j] + basis.damped[j]);
  basis.rates.assign(n, 0.0), basis.losses.assign(n, 0.0);
  basis.shapes = joint_shapes(basis, layout);
}

// From lambda, springs and the own rows of the modes, (own dofs, n), or twice as many numbers if complex.
void take_modes(const std::vector<double> &phi, std::size_t columns, const Layout &layout, StuckBasis &basis) {
  const std::size_t own = layout.own_dofs();
  basis.exact = Slab<double>(own, columns), basis.phi = Slab<float>(own, columns);
  for (std::size_t i = 0; i < own; ++i) {
    const double *of_dof = &phi[i * columns];
    std::copy_n(of_dof, columns, basis.exact.row(i)), std::copy_n(of_dof, columns, basis.phi.row(i));
  }
  complete(layout, basis);
}

// The own rows of modes that rank `root` holds, real parts and then imaginary ones.
std::vector<double> dealt_out(const ComplexDense &modes, int root, const Layout &layout) {
  const std::size_t n = layout.dofs();
  const RowMessages messages(layout, 2 * n);
  std::vector<double> rows;
  const auto pick = [&](int rank) {
    rows.clear();
    for (const PetscInt number : numbers_of(layout, rank))
      for (const bool real : {true, false})
        for (std::size_t j = 0; j < n; ++j) {
          const auto value = modes(static_cast<int>(number), static_cast<int>(j));
          rows.push_back(real ? value.real() : value.imag());
        }
  };
  if (layout.rank != root) {
    messages.receive(rows, layout.rank, root);
    return rows;
  }
  for (int rank = 0; rank < layout.size; ++rank)
    if (rank != root) pick(rank), messages.send(rows, rank);
  pick(root);
  return rows;
}

} // namespace

Pencil own_pencil(const PencilRows &rows, const std::vector<double> &springs, const Layout &layout) {
  const std::size_t na = layout.modes, nc = 3 * layout.points, n = na + nc, own = layout.own_dofs(),
                    own_modes = layout.own_modes.size();
  Pencil pencil{std::vector<double>(own * n), std::vector<double>(own * n)};
  auto &[K, M] = pencil;
  for (std::size_t d = 0; d < own_modes; ++d) {
    const std::size_t number = layout.number(d);
    K[d * n + number] = rows.kaa[number], M[d * n + number] = 1;
  }
  for (std::size_t i = 0; i < own - own_modes; ++i) {
    const std::size_t row = (own_modes + i) * n, number = layout.number(own_modes + i);
    std::copy_n(rows.kxx.row(i), nc, &K[row + na]);
    std::copy_n(rows.mxa.row(i), na, &M[row]);
    std::copy_n(rows.mxx.row(i), nc, &M[row + na]);
    K[row + number] += springs[i];
  }
  return pencil;
}

StuckBasis stuck_basis(const PencilRows &rows, std::vector<double> springs, const Layout &layout) {
  StuckBasis basis;
  basis.springs = std::move(springs);
  auto [phi, M] = own_pencil(rows, basis.springs, layout); // K_s, until its modes take the place
  const bool kept = layout.dofs() >= large && !rows.stuck_file.empty();
  const std::uint64_t of = kept ? fingerprint(layout, phi, M) : 0;
  if (!kept || !read_modes(layout, rows.stuck_file, of, basis.lambda, phi)) {
    basis.lambda = layout.dofs() >= large && layout.size > 1 ? dense_modes_on_all_ranks(layout, phi, M)
                                                             : dense_modes_on_one_rank(layout, phi, M);
    if (basis.lambda.empty()) throw InputError(mass_not_positive(rows.file));
    if (kept) keep_modes(layout, rows.stuck_file, of, basis.lambda, phi);
  }
  take_modes(phi, layout.dofs(), layout, basis);
  return basis;
}

StuckBasis modal_basis(const PencilRows &rows, std::vector<double> springs, const Layout &layout, bool dampers,
                       double reach) {
  PetscInt least = many_dofs;
  check(PetscOptionsGetInt(nullptr, "hb_modal_", "-many", &least, nullptr), "reading options");
  if (layout.dofs() >= least && !dampers)
    if (std::optional<StuckBasis> near = near_basis(rows, springs, layout, reach)) {
      complete(layout, *near);
      return std::move(*near);
    }
  return stuck_basis(rows, std::move(springs), layout);
}

std::vector<StuckBasis> stuck_bases(const ReducedModel &model, const std::vector<const SectorIndex *> &indices,
                                    const std::vector<double> &springs, const Layout &layout) {
  std::vector<StuckBasis> bases;
  const std::size_t n = layout.dofs(), size = layout.size;
  for (std::size_t begin = 0; begin < indices.size(); begin += size) {
    const std::size_t count = std::min(size, indices.size() - begin);
    HermitianPencil mine;
    for (std::size_t root = 0; root < count; ++root) {
      HermitianPencil made = pencil(model, *indices[begin + root], springs, static_cast<int>(root));
      if (static_cast<std::size_t>(layout.rank) == root) mine = std::move(made);
    }
    HermitianModes modes;
    on_all_ranks(layout.comm, [&] {
      if (static_cast<std::size_t>(layout.rank) >= count) return;
      modes = all_modes(std::move(mine.K), std::move(mine.M));
      if (modes.fault != HermitianModes::Fault::none) throw InputError(mass_not_positive(model.file));
    });
    for (std::size_t root = 0; root < count; ++root) {
      StuckBasis &basis = bases.emplace_back();
      basis.springs = springs, basis.lambda = modes.squares;
      basis.lambda.resize(n);
      MPI_Bcast(basis.lambda.data(), static_cast<int>(n), MPI_DOUBLE, static_cast<int>(root), layout.comm);
      take_modes(dealt_out(modes.shapes, static_cast<int>(root), layout), 2 * n, layout, basis);
    }
  }
  return bases;
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
