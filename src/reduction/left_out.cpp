#include "reduction/left_out.hpp"

#include <algorithm>
#include <cmath>

#include <petscsys.h>
#include <slepcblaslapack.h> // needs petscsys.h before it

#include "support/error.hpp"
#include "support/hash.hpp"

namespace dovetail {
namespace {

constexpr double none = 1e-12; // of a probe's energy: rounding errors

struct Eigen {
  std::vector<double> values, vectors; // (n) ascending, (n, n) column-major
};

Eigen eigen(MPI_Comm comm, std::vector<double> A, PetscBLASInt n) {
  Eigen out;
  PetscBLASInt room = -1, info = 0;
  std::vector<double> work(1);
  out.values.resize(n);
  for (const bool ask : {true, false}) {
    LAPACKsyev_("V", "L", &n, A.data(), &n, out.values.data(), work.data(), &room, &info);
    if (ask) room = static_cast<PetscBLASInt>(work[0]), work.resize(room);
  }
  MPI_Bcast(&info, 1, MPI_INT, 0, comm); // the same on all ranks to the last bit
  MPI_Bcast(A.data(), n * n, MPI_DOUBLE, 0, comm);
  MPI_Bcast(out.values.data(), n, MPI_DOUBLE, 0, comm);
  if (info != 0) throw ComputeError("modes left out: LAPACK's syev failed (" + std::to_string(info) + ")");
  out.vectors = std::move(A);
  return out;
}

// Columns [from, n) of (n, n) V, each times scale[column].
std::vector<double> columns(const Eigen &found, PetscInt n, PetscInt from, const std::vector<double> &scale) {
  std::vector<double> T;
  for (PetscInt j = from; j < n; ++j)
    for (PetscInt i = 0; i < n; ++i) T.push_back(found.vectors[j * n + i] * scale[j]);
  return T;
}

// A B, A (m, k), B (k, n), column-major; A^T B if `transposed`, A (k, m).
std::vector<double> product(const std::vector<double> &A, const std::vector<double> &B, PetscInt m, PetscInt k,
                            PetscInt n, bool transposed) {
  std::vector<double> C(m * n, 0.0);
  for (PetscInt j = 0; j < n; ++j)
    for (PetscInt i = 0; i < m; ++i)
      for (PetscInt l = 0; l < k; ++l) C[j * m + i] += (transposed ? A[i * k + l] : A[l * m + i]) * B[j * k + l];
  return C;
}

} // namespace

void mix_probes(const Tall &carried, PetscInt first, PetscInt contact_dofs, Tall &probes) {
  const PetscInt count = carried.columns, n = probes.columns;
  std::vector<double> less(static_cast<std::size_t>(count) * n, 0.0);
  for (PetscInt j = 1; j < n; ++j)
    for (PetscInt i = 0; i < count; ++i) {
      const auto dof = static_cast<std::uint64_t>(first + i);
      less[j * count + i] =
          contact_dofs < n ? (first + i == j - 1 ? -1 : 0) : 1 - 2 * double(mix((dof + 1) * 64 + j) >> 11) * 0x1p-53;
    }
  subtract_product(carried, count, less, probes);
}

LeftOut left_out(const ClampedStructure &parts, const Tall &phi, Tall probes) {
  const MPI_Comm comm = parts.full.comm;
  const PetscInt n = probes.columns, own_contact = 3 * parts.own_points.size();
  const auto square = [&](const Tall &S, const Tall &AS) { return gram(comm, S, 0, S.columns, AS, 0, AS.columns); };
  Tall S = parts.solver->solve(probes);
  const std::vector<double> before = square(S, probes); // S^T K_ee S
  if (phi.columns > 0) {
    const Tall MS = multiply(parts.M.ee, S);
    subtract_product(phi, phi.columns, gram(comm, phi, 0, phi.columns, MS, 0, n), S);
  }
  std::vector<double> K = square(S, multiply(parts.K.ee, S)), M = square(S, multiply(parts.M.ee, S));
  for (PetscInt j = 0; j < n; ++j) // probes weigh alike
    for (PetscInt i = 0; i < n; ++i) {
      const double weight = std::sqrt(before[i * n + i] * before[j * n + j]);
      K[j * n + i] = weight > 0 ? K[j * n + i] / weight : 0;
      M[j * n + i] = weight > 0 ? M[j * n + i] / weight : 0;
    }

  const Eigen energy = eigen(comm, K, n);
  std::vector<double> scale(n);
  PetscInt from = 0;
  while (from < n && !(energy.values[from] > none)) ++from;
  for (PetscInt j = from; j < n; ++j) scale[j] = 1 / std::sqrt(energy.values[j]);
  const PetscInt r = n - from;
  if (r == 0) return {};
  std::vector<double> T = columns(energy, n, from, scale); // T^T K T = 1
  const Eigen flexible = eigen(comm, product(T, product(M, T, n, n, r, false), r, n, r, true), static_cast<int>(r));
  PetscInt first = 0; // massless ones follow at once: they are not left out of any motion's inertia
  while (first < r && !(flexible.values[first] > none * flexible.values.back())) ++first;
  LeftOut out;
  std::vector<double> normal(r);
  for (PetscInt j = r - 1; j >= first; --j) out.squares.push_back(1 / flexible.values[j]);
  for (PetscInt j = first; j < r; ++j) normal[j] = 1 / std::sqrt(flexible.values[j]);
  std::vector<double> V = product(T, columns(flexible, r, first, normal), n, r, r - first, false);
  for (PetscInt i = 0; i < n; ++i)
    for (PetscInt j = 0; j < r - first; ++j)
      V[j * n + i] = before[i * n + i] > 0 ? V[j * n + i] / std::sqrt(before[i * n + i]) : 0;
  rotate(S, n, r - first, V.data());
  S.drop_columns_from(r - first); // M-normal; columns by descending square

  Tall force(S.rows, 1);
  force.values = parts.force_e;
  out.load = gram(comm, S, 0, S.columns, force, 0, 1);
  const Tall carried = multiply(parts.M.ce, S), // B^T S = M_ce S + Psi^T M_ee S, Psi^T = -K_ce K_ee^-1
      held = multiply(parts.K.ce, parts.solver->solve(multiply(parts.M.ee, S)));
  out.coupling.resize(static_cast<std::size_t>(own_contact) * S.columns);
  for (PetscInt j = 0; j < S.columns; ++j) // ascending
    for (PetscInt i = 0; i < own_contact; ++i)
      out.coupling[static_cast<std::size_t>(i) * S.columns + S.columns - 1 - j] =
          carried.column(j)[i] - held.column(j)[i];
  std::reverse(out.load.begin(), out.load.end());
  return out;
}

} // namespace dovetail
