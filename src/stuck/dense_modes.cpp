#include "stuck/dense_modes.hpp"

#include <petscsys.h>
#include <slepcblaslapack.h>

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr std::size_t most = 32766; // dofs: dsygvd wants 1 + 6 n + 2 n^2 numbers, and counts them by an int

// Rows of one rank from (n, n) or into it; `at` of both.
template <class Copy> void each_row(const Layout &layout, int rank, Copy copy) {
  std::size_t own = 0;
  for (const PetscInt number : numbers_of(layout, rank)) copy(own++, static_cast<std::size_t>(number));
}

// Rows of all ranks, in the order of their numbers, on rank 0.
std::vector<double> on_first_rank(const Layout &layout, std::vector<double> &own, const RowMessages &messages) {
  const std::size_t n = layout.dofs();
  std::vector<double> all(layout.rank == 0 ? n * n : 0);
  if (layout.rank > 0) messages.send(own, 0);
  for (int r = 0; r < layout.size && layout.rank == 0; ++r) {
    if (r > 0) messages.receive(own, r, r);
    each_row(layout, r, [&](std::size_t i, std::size_t number) { std::copy_n(&own[i * n], n, &all[number * n]); });
  }
  own = {};
  return all;
}

// K becomes Phi, one mode after the other. Both: the lower half, by columns. lambda is empty if M is not positive.
void solve(std::vector<double> &K, std::vector<double> &M, std::vector<double> &lambda) {
  const std::size_t order = lambda.size();
  PetscBLASInt n = static_cast<PetscBLASInt>(order), kind = 1, info = 0, room = -1, int_room = -1;
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
  if (info > n) return lambda.clear();
  if (info != 0)
    throw ComputeError("the modes of the stuck structure were not found (dsygvd: " + std::to_string(info) + ")");
}

} // namespace

std::vector<double> dense_modes_on_one_rank(const Layout &layout, std::vector<double> &K, std::vector<double> &M) {
  const std::size_t na = layout.modes, n = layout.dofs();
  if (n > most) throw ComputeError("LAPACK finds all modes of no more than 32766 dofs on one rank; take more ranks");
  const RowMessages messages(layout);
  std::vector<double> all_K = on_first_rank(layout, K, messages), all_M = on_first_rank(layout, M, messages), lambda(n);
  on_all_ranks(layout.comm, [&] {
    if (layout.rank > 0) return;
    for (std::size_t j = 0; j < na; ++j)
      for (std::size_t i = na; i < n; ++i) all_M[j * n + i] = all_M[i * n + j];
    solve(all_K, all_M, lambda);
  });
  int positive = !lambda.empty();
  MPI_Bcast(&positive, 1, MPI_INT, 0, layout.comm);
  if (!positive) return {};
  MPI_Bcast(lambda.data(), static_cast<int>(n), MPI_DOUBLE, 0, layout.comm);
  for (int r = layout.size - 1; r >= 0 && layout.rank == 0; --r) {
    K.resize(numbers_of(layout, r).size() * n);
    each_row(layout, r, [&](std::size_t i, std::size_t number) {
      for (std::size_t j = 0; j < n; ++j) K[i * n + j] = all_K[j * n + number];
    });
    if (r > 0) messages.send(K, r);
  }
  if (layout.rank > 0) messages.receive(K, layout.rank, 0);
  return lambda;
}

} // namespace dovetail
