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
  PetscBLASInt room = -1, info;
  std::vector<double> work(1);
  out.values.resize(n);
  for (const bool ask : {true, false}) {
    LAPACKsyev_("V", "L", &n, A.data(), &n, out.values.data(), work.data(), &room, &info);
    if (ask) room = static_cast<PetscBLASInt>(work[0]), work.resize(room);
  }
  MPI_Bcast(&info, 1, MPI_INT, 0, comm); // the same on all ranks to the last bit
  MPI_Bcast(A.data(), n * n, MPI_DOUBLE, 0, comm);
  MPI_Bcast(out.values.data(), n, MPI_DOUBLE, 0, comm);
  if (info != 0) throw ComputeError("modes made for the loads: LAPACK's syev failed (" + std::to_string(info) + ")");
  out.vectors = std::move(A);
  return out;
}

std::vector<double> norms(MPI_Comm comm, Mat A, const Tall &S) { // s^T A s of each column
  const Tall AS = multiply(A, S);
  std::vector<double> out(S.columns, 0.0);
  for (PetscInt j = 0; j < S.columns; ++j)
    for (PetscInt i = 0; i < S.rows; ++i) out[j] += S.column(j)[i] * AS.column(j)[i];
  MPI_Allreduce(MPI_IN_PLACE, out.data(), S.columns, MPI_DOUBLE, MPI_SUM, comm);
  return out;
}

// S^T A S = 1, without the columns of which nothing is left, by what they had `before`, and without dependent ones.
void independent(MPI_Comm comm, Mat A, const std::vector<double> &before, Tall &S) {
  const std::vector<double> after = norms(comm, A, S);
  PetscInt n = 0, left = 0;
  for (PetscInt j = 0; j < S.columns; ++j)
    if (after[j] > none * before[j])
      std::transform(S.column(j), S.column(j) + S.rows, S.column(n++),
                     [&](double value) { return value / std::sqrt(before[j]); });
  S.drop_columns_from(n);
  if (n == 0) return;
  const Eigen found = eigen(comm, gram(comm, S, 0, n, multiply(A, S), 0, n), static_cast<int>(n));
  std::vector<double> T;
  for (PetscInt j = n - 1; j >= 0 && found.values[j] > none; --j, ++left)
    for (PetscInt i = 0; i < n; ++i) T.push_back(found.vectors[j * n + i] / std::sqrt(found.values[j]));
  if (left > 0) rotate(S, n, left, T.data());
  S.drop_columns_from(left);
}

Tall part(const Tall &S, PetscInt first, PetscInt count) {
  Tall out(S.rows, count);
  std::copy(S.column(first), S.column(first + count), out.column(0));
  return out;
}

} // namespace

double probe_noise(PetscInt row, PetscInt column) {
  return 1 - 2 * double(mix((static_cast<std::uint64_t>(row) + 1) * 64 + column) >> 11) * 0x1p-53;
}

Tall load_probes(MPI_Comm comm, const Tall &forces) {
  const PetscInt loads = forces.columns, n = std::min(loads, lanczos_block / 2);
  Tall probes(forces.rows, n);
  if (n == loads) {
    probes.values = forces.values;
    return probes;
  }
  std::vector<double> squares(loads, 0.0), less(static_cast<std::size_t>(loads) * n, 0.0);
  for (PetscInt j = 0; j < loads; ++j)
    for (PetscInt i = 0; i < forces.rows; ++i) squares[j] += forces.column(j)[i] * forces.column(j)[i];
  MPI_Allreduce(MPI_IN_PLACE, squares.data(), loads, MPI_DOUBLE, MPI_SUM, comm);
  for (PetscInt column = 0; column < n; ++column) // each of the same weight, whatever its size
    for (PetscInt j = 0; j < loads; ++j)
      if (squares[j] > 0) less[column * loads + j] = probe_noise(j, column) / std::sqrt(squares[j]);
  subtract_product(forces, loads, less, probes);
  return probes;
}

void mix_probes(const Tall &carried, PetscInt first, PetscInt contact_dofs, PetscInt given, Tall &probes) {
  const PetscInt count = carried.columns, n = probes.columns;
  std::vector<double> less(static_cast<std::size_t>(count) * n, 0.0);
  for (PetscInt j = given; j < n; ++j)
    for (PetscInt i = 0; i < count; ++i)
      less[j * count + i] =
          contact_dofs <= n - given ? (first + i == j - given ? -1 : 0) : probe_noise(first + i, j - given + 1);
  subtract_product(carried, count, less, probes);
}

std::vector<double> carried_by(const ClampedStructure &parts, const Blocks &M, const Tall &phi, PetscInt from) {
  const PetscInt columns = phi.columns - from, own_contact = 3 * parts.own_points.size();
  std::vector<double> rows(static_cast<std::size_t>(own_contact) * columns);
  for (PetscInt first = 0; first < columns; first += lanczos_block) { // B^T = M_ce + Psi^T M_ee, Psi^T = -K_ce K_ee^-1
    const Tall block = part(phi, from + first, std::min(lanczos_block, columns - first)), own = multiply(M.ce, block),
               held = multiply(parts.K.ce, parts.solver->solve(multiply(M.ee, block)));
    for (PetscInt j = 0; j < block.columns; ++j)
      for (PetscInt i = 0; i < own_contact; ++i)
        rows[static_cast<std::size_t>(i) * columns + first + j] = own.column(j)[i] - held.column(j)[i];
  }
  return rows;
}

ElasticModes ritz_modes(const ClampedStructure &parts, const ElasticModes &kept, Tall S) {
  const MPI_Comm comm = parts.full.comm;
  const PetscInt m = kept.shapes.columns;
  const std::vector<double> before = norms(comm, parts.K.ee, S);
  if (m > 0 && S.columns > 0) {
    std::vector<double> C = gram(comm, kept.shapes, 0, m, multiply(parts.K.ee, S), 0, S.columns);
    for (std::size_t at = 0; at < C.size(); ++at) C[at] /= kept.squares[at % m];
    subtract_product(kept.shapes, m, C, S);
  }
  independent(comm, parts.K.ee, before, S);
  ElasticModes out;
  if (S.columns > 0) {
    const PetscInt r = S.columns;
    const Eigen found = eigen(comm, gram(comm, S, 0, r, multiply(parts.M.ee, S), 0, r), static_cast<int>(r));
    std::vector<double> T; // the most flexible first, M-normal; massless ones follow at once, and hinder no motion
    for (PetscInt j = r - 1; j >= 0 && found.values[j] > none * found.values.back(); --j) {
      out.squares.push_back(1 / found.values[j]);
      for (PetscInt i = 0; i < r; ++i) T.push_back(found.vectors[j * r + i] / std::sqrt(found.values[j]));
    }
    rotate(S, r, static_cast<PetscInt>(out.squares.size()), T.data());
  }
  S.drop_columns_from(static_cast<PetscInt>(out.squares.size()));
  out.shapes = std::move(S);
  return out;
}

PetscInt with_residuals(const ClampedStructure &parts, ElasticModes &modes, Tall &S) {
  const PetscInt all = modes.shapes.columns, taken = std::min(S.columns, all / 2);
  ElasticModes lowest, residual;
  PetscInt count = taken;
  for (PetscInt wanted = -1; wanted != count && count > 0;) { // of some probes nothing may be left
    wanted = count;
    lowest = {{modes.squares.begin(), modes.squares.begin() + (all - count)}, part(modes.shapes, 0, all - count)};
    residual = ritz_modes(parts, lowest, part(S, 0, taken));
    count = std::min(count, residual.shapes.columns);
  }
  if (count == 0) return 0;
  for (PetscInt j = 0; j < count; ++j) {
    fix_sign(parts.full.comm, parts.elastic_dofs, residual.shapes.column(j));
    modes.squares[all - count + j] = residual.squares[j];
    std::copy_n(residual.shapes.column(j), S.rows, modes.shapes.column(all - count + j));
  }
  const Tall beyond = parts.solver->solve(multiply(parts.M.ee, part(residual.shapes, 0, count)));
  Tall next(S.rows, S.columns - taken + count);
  std::copy(S.column(taken), S.column(S.columns), next.column(0));
  std::copy(beyond.values.begin(), beyond.values.end(), next.column(S.columns - taken));
  S = std::move(next);
  return count;
}

LeftOut left_out(const ClampedStructure &parts, const ElasticModes &kept, const Tall &S) {
  const MPI_Comm comm = parts.full.comm;
  const ElasticModes rest = ritz_modes(parts, kept, S);
  const PetscInt left = rest.shapes.columns, m = kept.shapes.columns;
  LeftOut out;
  if (left == 0) return out;
  out.squares = rest.squares;
  const auto loads = gram(comm, rest.shapes, 0, left, parts.force_e, 0, parts.force_e.columns);
  for (PetscInt j = 0; j < parts.force_e.columns; ++j)
    out.loads.emplace_back(loads.begin() + j * left, loads.begin() + (j + 1) * left);
  out.coupling = carried_by(parts, parts.M, rest.shapes);
  if (m > 0) out.with_modes = gram(comm, rest.shapes, 0, left, multiply(parts.M.ee, kept.shapes), 0, m);
  return out;
}

} // namespace dovetail
