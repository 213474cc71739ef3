#include "harmonic/loose_body.hpp"

#include <petscsys.h>

#include <petscblaslapack.h>

#include <algorithm>
#include <cmath>

namespace dovetail {
namespace {

constexpr double rigid_stiffness = 1e-9; // relative to the largest: below it a motion meets no elastic resistance
constexpr double adrift_stiffness = 1e-6;

// Eigenvalues of a symmetric matrix (n, n), ascending; A holds the eigenvectors afterwards, one after the other.
std::vector<double> eigenvalues(PetscBLASInt n, std::vector<double> &A) {
  std::vector<double> values(n), work(1);
  PetscBLASInt room = -1, info = 0;
  for (const bool ask : {true, false}) {
    LAPACKsyev_("V", "L", &n, A.data(), &n, values.data(), work.data(), &room, &info);
    if (ask) room = static_cast<PetscBLASInt>(work[0]), work.resize(room);
  }
  if (info != 0) std::fill(values.begin(), values.end(), 1.0); // not a number in it: that is told elsewhere
  return values;
}

bool positive_definite(PetscBLASInt n, std::vector<double> A, double shift) {
  PetscBLASInt info = 0;
  for (PetscBLASInt i = 0; i < n; ++i) A[static_cast<std::size_t>(i) * n + i] -= shift;
  LAPACKpotrf_("L", &n, A.data(), &n, &info);
  return info == 0;
}

} // namespace

LooseBody::LooseBody(const ReducedModel &model, const Layout &layout) : comm_(layout.comm) {
  const PetscBLASInt n = static_cast<PetscBLASInt>(model.contact_dofs());
  if (n == 0 || n > most_dofs) return;
  std::vector<int> counts(layout.size), starts(layout.size);
  for (int r = 0; r < layout.size; ++r) {
    const Range share = share_of(layout.points, r, layout.size);
    counts[r] = 3 * share.size() * n, starts[r] = 3 * share.begin * n;
  }
  std::vector<double> K(static_cast<std::size_t>(n) * n);
  MPI_Allgatherv(model.kxx.data(), static_cast<int>(model.kxx.size()), MPI_DOUBLE, K.data(), counts.data(),
                 starts.data(), MPI_DOUBLE, comm_);
  double largest = 0;
  for (PetscBLASInt i = 0; i < n; ++i) largest = std::max(largest, std::abs(K[static_cast<std::size_t>(i) * n + i]));
  if (largest > 0 && positive_definite(n, K, rigid_stiffness * largest)) return;
  const std::vector<double> squares = eigenvalues(n, K);
  for (int mode = 0; mode < n && squares[mode] <= rigid_stiffness * largest; ++mode, ++motions_) {
    const double *v = &K[static_cast<std::size_t>(mode) * n + 3 * layout.own_points.begin];
    rigid_.insert(rigid_.end(), v, v + 3 * layout.own_points.size());
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
