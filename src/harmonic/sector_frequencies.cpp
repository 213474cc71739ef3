#include "harmonic/sector_frequencies.hpp"

#include <algorithm>
#include <cmath>

#include "harmonic/resonances.hpp"
#include "harmonic/sector_pencil.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

// Index 0 in the same form as the others.
SectorIndex as_index(const ReducedModel &model) {
  SectorIndex index;
  index.kaa = model.kaa;
  index.mxa.assign(model.mxa.begin(), model.mxa.end());
  index.mxx.assign(model.mxx.begin(), model.mxx.end());
  index.kxx.assign(model.kxx.begin(), model.kxx.end());
  return index;
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
  std::vector<double> found, diagonal;
  for (int i = 0; i < n; ++i) diagonal.push_back(of.K(i, i).real());
  for (int j = 0; j < count; ++j) {
    const double square = modes.squares[j] - shift;
    found.push_back(is_rigid(square, modes.shapes.column(j), diagonal) ? 0 : std::sqrt(square));
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
  const std::vector<double> springs = closed_springs(model);
  const SectorIndex first = as_index(reduced);
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
      HermitianPencil made = pencil(reduced, h == 0 ? first : reduced.indices[h - 1], springs, root);
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
