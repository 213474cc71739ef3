#include "harmonic/stuck_basis.hpp"

#include <petscsys.h>
#include <slepcblaslapack.h>

#include "harmonic/kept_modes.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr std::size_t worth_keeping = 1000; // modes; fewer are found within a second

// Contact rows of all ranks, `columns` numbers each, in order on rank 0.
std::vector<double> on_first_rank(const Layout &layout, const std::vector<double> &own, PetscInt columns) {
  std::vector<int> counts(layout.size), starts(layout.size);
  for (int r = 0; r < layout.size; ++r) {
    const Range share = share_of(layout.points, r, layout.size);
    counts[r] = 3 * share.size(), starts[r] = 3 * share.begin;
  }
  std::vector<double> all(layout.rank == 0 ? static_cast<std::size_t>(3 * layout.points) * columns : 0);
  MPI_Datatype row; // numbers alone would soon be more than an int counts
  MPI_Type_contiguous(columns, MPI_DOUBLE, &row);
  MPI_Type_commit(&row);
  MPI_Gatherv(own.data(), counts[layout.rank], row, all.data(), counts.data(), starts.data(), row, 0, layout.comm);
  MPI_Type_free(&row);
  return all;
}

// K_s becomes Phi, one mode after the other.
void solve(std::vector<double> &K, std::vector<double> &M, std::vector<double> &lambda) {
  PetscBLASInt n = static_cast<PetscBLASInt>(lambda.size()), kind = 1, info = 0, room = -1, int_room = -1;
  std::vector<double> work(1);
  std::vector<PetscBLASInt> int_work(1);
  for (const bool ask : {true, false}) {
    LAPACKsygvd_(&kind, "V", "L", &n, K.data(), &n, M.data(), &n, lambda.data(), work.data(), &room, int_work.data(),
                 &int_room, &info);
    if (ask) {
      room = static_cast<PetscBLASInt>(work[0]), int_room = int_work[0];
      work.resize(room), int_work.resize(int_room);
    }
  }
  if (info > n) throw ComputeError("the reduced mass matrix is not positive definite");
  if (info != 0)
    throw ComputeError("the modes of the stuck structure were not found (dsygvd: " + std::to_string(info) + ")");
}

} // namespace

StuckBasis stuck_basis(const ReducedModel &model, const std::vector<ContactPoint> &contact, const Layout &layout) {
  const std::size_t na = layout.modes, nc = 3 * layout.points, n = na + nc;
  StuckBasis basis;
  for (const ContactPoint &point : contact)
    for (const double spring : stuck_springs(point)) basis.springs.push_back(spring);
  basis.lambda.resize(n);
  const std::vector<double> springs = on_first_rank(layout, basis.springs, 1),
                            kxx = on_first_rank(layout, model.kxx, 3 * layout.points),
                            mxx = on_first_rank(layout, model.mxx, 3 * layout.points),
                            mxa = on_first_rank(layout, model.mxa, layout.modes);
  std::vector<double> phi; // on rank 0, one mode after the other
  on_all_ranks(layout.comm, [&] {
    if (layout.rank != 0) return;
    std::vector<double> K(n * n), M(n * n); // the lower half, by columns
    for (std::size_t j = 0; j < na; ++j) {
      K[j * n + j] = model.kaa[j], M[j * n + j] = 1;
      for (std::size_t i = 0; i < nc; ++i) M[j * n + na + i] = mxa[i * na + j];
    }
    for (std::size_t j = 0; j < nc; ++j) {
      std::copy_n(&kxx[j * nc], nc, &K[(na + j) * n + na]);
      std::copy_n(&mxx[j * nc], nc, &M[(na + j) * n + na]);
      K[(na + j) * n + na + j] += springs[j];
    }
    const bool kept = n >= worth_keeping && !model.stuck_file.empty();
    const std::uint64_t of = kept ? fingerprint(K, M, n) : 0;
    if (!kept || !read_modes(model.stuck_file, of, basis.lambda, K)) {
      solve(K, M, basis.lambda);
      if (kept) keep_modes(model.stuck_file, of, basis.lambda, K);
    }
    phi.swap(K);
  });
  MPI_Bcast(basis.lambda.data(), static_cast<int>(n), MPI_DOUBLE, 0, layout.comm);

  basis.exact = Slab<double>(layout.own_dofs(), n), basis.phi = Slab<float>(layout.own_dofs(), n);
  const auto rows_of = [&](int rank, std::vector<double> &rows) { // in the order of that rank's dofs
    const Range modes = share_of(layout.modes, rank, layout.size), points = share_of(layout.points, rank, layout.size);
    rows.clear();
    const auto add = [&](std::size_t dof) {
      for (std::size_t j = 0; j < n; ++j) rows.push_back(phi[j * n + dof]);
    };
    for (PetscInt j = modes.begin; j < modes.end; ++j) add(j);
    for (PetscInt i = 3 * points.begin; i < 3 * points.end; ++i) add(na + i);
  };
  std::vector<double> rows(static_cast<std::size_t>(layout.own_dofs()) * n);
  MPI_Datatype row;
  MPI_Type_contiguous(static_cast<int>(n), MPI_DOUBLE, &row);
  MPI_Type_commit(&row);
  for (int r = layout.size - 1; r >= 0 && layout.rank == 0; --r) {
    rows_of(r, rows);
    if (r > 0) MPI_Send(rows.data(), static_cast<int>(rows.size() / n), row, r, 0, layout.comm);
  }
  if (layout.rank > 0) MPI_Recv(rows.data(), layout.own_dofs(), row, 0, 0, layout.comm, MPI_STATUS_IGNORE);
  MPI_Type_free(&row);
  basis.damped.assign(n, 0.0);
  for (PetscInt i = 0; i < layout.own_dofs(); ++i) {
    const double *of_dof = &rows[i * n],
                 spring = i < layout.own_modes.size() ? 0 : basis.springs[i - layout.own_modes.size()];
    std::copy_n(of_dof, n, basis.exact.row(i)), std::copy_n(of_dof, n, basis.phi.row(i));
    for (std::size_t j = 0; j < n; ++j) basis.damped[j] -= spring * of_dof[j] * of_dof[j];
  }
  MPI_Allreduce(MPI_IN_PLACE, basis.damped.data(), static_cast<int>(n), MPI_DOUBLE, MPI_SUM, layout.comm);
  for (std::size_t j = 0; j < n; ++j) basis.damped[j] = std::max(0.0, basis.lambda[j] + basis.damped[j]);
  return basis;
}

} // namespace dovetail
