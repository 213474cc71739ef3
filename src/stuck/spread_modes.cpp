// A dense eigenproblem on all ranks, by ScaLAPACK.
#include <string>
#include <utility>

#include "stuck/dense_modes.hpp"
#include "stuck/pencil_matrices.hpp"
#include "support/error.hpp"
#include "support/int_count.hpp"

extern "C" { // ScaLAPACK has no header
void pdpotrf_(const char *, const int *, double *, const int *, const int *, const int *, int *);
void pdsygst_(const int *, const char *, const int *, double *, const int *, const int *, const int *, const double *,
              const int *, const int *, const int *, double *, int *);
void pdsyevd_(const char *, const char *, const int *, double *, const int *, const int *, const int *, double *,
              double *, const int *, const int *, const int *, double *, const int *, int *, const int *, int *);
void pdtrtrs_(const char *, const char *, const char *, const int *, const int *, const double *, const int *,
              const int *, const int *, double *, const int *, const int *, const int *, int *);
}

namespace dovetail {
namespace {

constexpr int one = 1;

void succeed(int info, const char *routine) {
  if (info != 0)
    throw ComputeError("the modes of the stuck structure were not found (" + std::string(routine) + ": " +
                       std::to_string(info) + ")");
}

} // namespace

// M = L L^T, L^-1 K L^-T = Z diag(lambda) Z^T, Phi = L^-T Z.
std::vector<double> dense_modes_on_all_ranks(const Layout &layout, std::vector<double> &K, std::vector<double> &M) {
  const BlockCyclic grid = grid_of(layout);
  const int n = grid.order(), *d = grid.descriptor(), ask = -1;
  const auto taken = [&](std::vector<double> &rows) {
    std::vector<double> local =
        grid.take(BlockCyclic::Part::lower, [&](std::size_t i) { return &rows[i * static_cast<std::size_t>(n)]; });
    rows = {};
    return local;
  };
  std::vector<double> A = taken(K), L = taken(M), Z = grid.matrix(), lambda(n), work(1);
  on_all_ranks(layout.comm, [&] {
    int_count(2 * Z.size() + 16 * lambda.size() + grid.more_room(),
              "room of pdsyevd on one rank for all modes of so large a model; take more ranks");
  });
  int info = 0;
  pdpotrf_("L", &n, L.data(), &one, &one, d, &info);
  if (info > 0) return {};
  succeed(info, "pdpotrf");
  double scale;
  pdsygst_(&one, "L", &n, A.data(), &one, &one, d, L.data(), &one, &one, d, &scale, &info);
  succeed(info, "pdsygst");
  std::vector<int> int_work(1);
  pdsyevd_("V", "L", &n, A.data(), &one, &one, d, lambda.data(), Z.data(), &one, &one, d, work.data(), &ask,
           int_work.data(), &ask, &info);
  work.resize(static_cast<std::size_t>(work[0]) + grid.more_room()), int_work.resize(int_work[0]);
  const int room = static_cast<int>(work.size()), int_room = static_cast<int>(int_work.size());
  pdsyevd_("V", "L", &n, A.data(), &one, &one, d, lambda.data(), Z.data(), &one, &one, d, work.data(), &room,
           int_work.data(), &int_room, &info);
  succeed(info, "pdsyevd");
  pdtrtrs_("L", "T", "N", &n, &n, L.data(), &one, &one, d, Z.data(), &one, &one, d, &info);
  succeed(info, "pdtrtrs");
  K = grid.give(Z);
  return lambda;
}

} // namespace dovetail
