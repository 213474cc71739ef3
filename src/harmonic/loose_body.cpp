#include "harmonic/loose_body.hpp"

#include <petscsys.h>

#include <petscblaslapack.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "preload/preload_tangent.hpp"
#include "support/dense.hpp"
#include "support/hash.hpp"

namespace dovetail {
namespace {

constexpr double rigid_stiffness = 1e-9; // relative to the largest: below it a motion meets no elastic resistance
constexpr double adrift_stiffness = 1e-6;
constexpr PetscBLASInt lapack_block = 64; // columns that it takes at once, at most
constexpr int first_guess = 8;            // motions looked for: those of a body, and some
constexpr int enough_solves = 4;          // a motion a hundred times stiffer than a rigid one may be is gone to 1e-8

// Eigenvalues of a symmetric matrix (n, n), ascending; A holds the eigenvectors afterwards, one after the other.
std::vector<double> eigenvalues(PetscBLASInt n, std::vector<double> &A) {
  PetscBLASInt room = lapack_block * n, info = 0;
  std::vector<double> values(n), work(room);
  LAPACKsyev_("V", "L", &n, A.data(), &n, values.data(), work.data(), &room, &info);
  if (info != 0) std::fill(values.begin(), values.end(), 1.0); // not a number in it: that is told elsewhere
  return values;
}

// Own rows of K times V (n, columns), summed up to V^T K V.
std::vector<double> stiffness_of(const ReducedModel &model, const Dense &V) {
  const PetscBLASInt n = V.rows, own = static_cast<PetscBLASInt>(model.own_contact_dofs()), columns = V.columns;
  const double once = 1, none = 0;
  std::vector<double> KV(std::size_t(own) * columns), H(std::size_t(columns) * columns);
  if (own > 0) {
    BLASgemm_("T", "N", &own, &columns, &n, &once, model.kxx.data(), &n, V.column(0), &n, &none, KV.data(), &own);
    BLASgemm_("T", "N", &columns, &columns, &own, &once, V.column(0) + 3 * model.own_points.begin, &n, KV.data(), &own,
              &none, H.data(), &columns);
  }
  MPI_Allreduce(MPI_IN_PLACE, H.data(), static_cast<int>(H.size()), MPI_DOUBLE, MPI_SUM, model.comm);
  return H;
}

// Column by column, twice: after a solve they nearly depend on each other.
void make_orthonormal(Dense &V) {
  std::vector<double> h(V.columns);
  for (int j = 0; j < V.columns; ++j) {
    double *v = V.column(j);
    const auto turn = [&] {
      if (j > 0) transposed_times(V, j, v, h.data()), subtract_columns(V, j, h.data(), v);
      const double size = std::sqrt(std::inner_product(v, v + V.rows, v, 0.0));
      for (int i = 0; i < V.rows; ++i) v[i] /= size;
    };
    turn(), turn();
  }
}

// The softest motions of K, `count` of them, with their stiffness, by subspace iteration with those factors of it,
// shifted: one that is rigid grows more in a solve than one that is not, by their stiffness over the shift.
std::vector<double> softest(const ReducedModel &model, const SpreadFactors &factors, int count, Dense &motions) {
  const int n = static_cast<int>(model.contact_dofs());
  Dense V(n, count);
  for (std::size_t i = 0; i < V.values.size(); ++i) V.values[i] = noise(i + 1);
  for (int solves = 0; solves < enough_solves; ++solves) {
    make_orthonormal(V);
    factors.solve(V.column(0), count);
  }
  make_orthonormal(V);
  Dense turned(count, count);
  turned.values = stiffness_of(model, V);
  std::vector<double> values = eigenvalues(count, turned.values);
  motions.reset(n, count);
  multiply(1, V, turned, 0, motions);
  return values;
}

} // namespace

LooseBody::LooseBody(const ReducedModel &model, const Layout &layout) : comm_(layout.comm) {
  const int n = static_cast<int>(model.contact_dofs()), first = static_cast<int>(3 * layout.own_points.begin);
  if (n == 0) return;
  const auto row = [&](std::size_t i) { return &model.kxx[i * n]; };
  double largest = 0;
  for (PetscInt i = 0; i < model.own_contact_dofs(); ++i) largest = std::max(largest, std::abs(row(i)[first + i]));
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, comm_);
  const BlockCyclic grid = contact_grid(model);
  SpreadFactors factors(grid);
  std::vector<double> line(n);
  factors.factor([&](std::size_t i) {
    std::copy_n(row(i), n, line.begin());
    line[first + i] += largest > 0 ? rigid_stiffness * largest : 1;
    return line.data();
  });
  for (int count = std::min(n, first_guess); count > motions_; count = std::min(n, 2 * count)) {
    Dense motions;
    const std::vector<double> stiffness = softest(model, factors, count, motions);
    motions_ = static_cast<int>(
        std::count_if(stiffness.begin(), stiffness.end(), [&](double k) { return k <= rigid_stiffness * largest; }));
    MPI_Bcast(&motions_, 1, MPI_INT, 0, comm_);
    rigid_.clear();
    for (int mode = 0; mode < motions_; ++mode)
      rigid_.insert(rigid_.end(), motions.column(mode) + first,
                    motions.column(mode) + first + model.own_contact_dofs());
    if (motions_ < count) break;
  }
}

bool LooseBody::adrift(const std::vector<double> &mean_stiffness, const std::vector<double> &springs) const {
  std::vector<double> sums = held(mean_stiffness, springs);
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, comm_);
  return adrift(sums.data());
}

std::vector<double> LooseBody::held(const std::vector<double> &mean_stiffness,
                                    const std::vector<double> &springs) const {
  const std::size_t own = mean_stiffness.size(), m = motions_;
  std::vector<double> held(2 * m * m); // by the joint as it is, and closed and stuck
  for (std::size_t a = 0; a < m; ++a)
    for (std::size_t b = 0; b < m; ++b)
      for (std::size_t i = 0; i < own; ++i) {
        const double product = rigid_[a * own + i] * rigid_[b * own + i];
        held[a * m + b] += product * mean_stiffness[i], held[(m + a) * m + b] += product * springs[i];
      }
  return held;
}

bool LooseBody::adrift(const double *held) const {
  const std::size_t m = motions_;
  std::vector<double> now(held, held + m * m), closed(held + m * m, held + 2 * m * m);
  return eigenvalues(static_cast<PetscBLASInt>(m), now)[0] <
         adrift_stiffness * eigenvalues(static_cast<PetscBLASInt>(m), closed).back();
}

} // namespace dovetail
