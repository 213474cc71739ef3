#include "harmonic/sector_frequencies.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "harmonic/resonances.hpp"
#include "harmonic/stuck_basis.hpp"
#include "support/error.hpp"
#include "support/hermitian.hpp"

namespace dovetail {
namespace {

using Complex = std::complex<double>;

constexpr double rigid = 1e-9; // of the strain energy that the entries of a mode would meet one by one

std::vector<double> springs_at_rest(const PreloadedModel &model) { // of own points
  std::vector<double> springs = stuck_springs(model.contact);
  for (std::size_t p = 0; p < model.contact.size(); ++p)
    if (!closed_at_rest(model.contact[p], model.standstill[p])) std::fill_n(&springs[3 * p], 3, 0.0);
  return springs;
}

// Index 0 in the same form as the others.
SectorIndex as_index(const ReducedModel &model) {
  SectorIndex index;
  index.kaa = model.kaa;
  index.mxa.assign(model.mxa.begin(), model.mxa.end());
  index.mxx.assign(model.mxx.begin(), model.mxx.end());
  index.kxx.assign(model.kxx.begin(), model.kxx.end());
  return index;
}

// Own rows of all ranks, one rank's after the other's, on rank `root`.
std::vector<Complex> gathered(MPI_Comm comm, const std::vector<Complex> &own, int root) {
  int rank, size;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  const int count = static_cast<int>(own.size());
  std::vector<int> counts(size), places(size + 1, 0);
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  std::partial_sum(counts.begin(), counts.end(), places.begin() + 1);
  std::vector<Complex> all(rank == root ? places[size] : 0);
  MPI_Gatherv(own.data(), count, MPI_C_DOUBLE_COMPLEX, all.data(), counts.data(), places.data(), MPI_C_DOUBLE_COMPLEX,
              root, comm);
  return all;
}

struct HermitianPencil { // of the modes and the contact dofs
  ComplexDense K, M;
};

// On rank `root`, collective.
HermitianPencil pencil(const ReducedModel &model, const SectorIndex &index, const std::vector<double> &springs,
                       int root) {
  const PetscInt na = model.modes, nc = model.contact_dofs(), first = 3 * model.own_points.begin;
  std::vector<Complex> stiffness = index.kxx;
  for (std::size_t i = 0; i < springs.size(); ++i) stiffness[i * nc + first + i] += springs[i];
  const std::vector<Complex> kxx = gathered(model.comm, stiffness, root), mxx = gathered(model.comm, index.mxx, root),
                             mxa = gathered(model.comm, index.mxa, root);
  int rank;
  MPI_Comm_rank(model.comm, &rank);
  if (rank != root) return {};
  HermitianPencil made{ComplexDense(na + nc, na + nc), ComplexDense(na + nc, na + nc)};
  for (PetscInt j = 0; j < na; ++j) made.K(j, j) = index.kaa[j], made.M(j, j) = 1;
  for (PetscInt i = 0; i < nc; ++i) {
    for (PetscInt j = 0; j < nc; ++j)
      made.K(na + i, na + j) = kxx[std::size_t(i) * nc + j], made.M(na + i, na + j) = mxx[std::size_t(i) * nc + j];
    for (PetscInt j = 0; j < na; ++j) {
      made.M(na + i, j) = mxa[std::size_t(i) * na + j];
      made.M(j, na + i) = std::conj(mxa[std::size_t(i) * na + j]);
    }
  }
  return made;
}

std::vector<double> frequencies_of(const HermitianPencil &of, PetscInt count, const std::filesystem::path &file) {
  const int n = of.K.rows;
  double shift = INFINITY; // below the first square as a rule, so that K + shift M is positive without harm
  for (int i = 0; i < n; ++i)
    if (const double k = of.K(i, i).real(), m = of.M(i, i).real(); k > 0 && m > 0) shift = std::min(shift, k / m);
  if (!std::isfinite(shift)) shift = 1;
  ComplexDense K = of.K;
  for (std::size_t i = 0; i < K.values.size(); ++i) K.values[i] += shift * of.M.values[i];
  const HermitianModes modes = lowest_modes(std::move(K), of.M, static_cast<int>(count));
  if (modes.fault != HermitianModes::Fault::none) throw InputError(mass_not_positive(file));
  std::vector<double> found;
  for (PetscInt j = 0; j < count; ++j) {
    double stiff = 0;
    for (int i = 0; i < n; ++i) stiff += of.K(i, i).real() * std::norm(modes.shapes(i, j));
    const double square = modes.squares[j] - shift;
    found.push_back(square <= rigid * stiff ? 0 : std::sqrt(square));
  }
  return found;
}

} // namespace

SectorFrequencies held_frequencies(const ReducedModel &model) {
  SectorFrequencies found;
  const auto take = [&](const std::vector<double> &squares) {
    found.emplace_back();
    for (const double square : squares) found.back().push_back(std::sqrt(square));
  };
  take(model.kaa);
  for (const SectorIndex &index : model.indices) take(index.kaa);
  return found;
}

SectorFrequencies stuck_frequencies(const PreloadedModel &model, PetscInt count) {
  const ReducedModel &reduced = model.reduced;
  const std::vector<double> springs = springs_at_rest(model);
  int rank, size;
  MPI_Comm_rank(reduced.comm, &rank);
  MPI_Comm_size(reduced.comm, &size);
  const int all = static_cast<int>(reduced.indices.size()) + 1;
  count = std::min(count, reduced.modes + reduced.contact_dofs());
  SectorFrequencies found(all, std::vector<double>(count));
  for (int begin = 0; begin < all; begin += size) {
    HermitianPencil mine;
    for (int root = 0; root < size && begin + root < all; ++root) {
      const int h = begin + root;
      HermitianPencil made = pencil(reduced, h == 0 ? as_index(reduced) : reduced.indices[h - 1], springs, root);
      if (rank == root) mine = std::move(made);
    }
    on_all_ranks(reduced.comm, [&] {
      if (begin + rank < all) found[begin + rank] = frequencies_of(mine, count, reduced.file);
    });
    for (int root = 0; root < size && begin + root < all; ++root)
      MPI_Bcast(found[begin + root].data(), static_cast<int>(count), MPI_DOUBLE, root, reduced.comm);
  }
  return found;
}

} // namespace dovetail
