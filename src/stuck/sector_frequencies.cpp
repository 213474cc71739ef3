#include "stuck/sector_frequencies.hpp"

#include <algorithm>
#include <cmath>

#include "stuck/resonances.hpp"
#include "stuck/sector_modes.hpp"
#include "support/error.hpp"

namespace dovetail {

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
  int rank, size;
  MPI_Comm_rank(reduced.comm, &rank);
  MPI_Comm_size(reduced.comm, &size);
  const int all = static_cast<int>(reduced.indices.size()) + 1;
  count = std::min(count, reduced.modes + reduced.contact_dofs());
  SectorFrequencies found(all, std::vector<double>(count));
  for (int begin = 0; begin < all; begin += size) {
    HermitianPencil mine;
    for (int root = 0; root < size && begin + root < all; ++root) {
      HermitianPencil made = pencil(reduced, begin + root, springs, root);
      if (rank == root) mine = std::move(made);
    }
    on_all_ranks(reduced.comm, [&] {
      if (begin + rank >= all) return;
      std::vector<double> &own = found[begin + rank];
      own = sector_modes(mine, static_cast<int>(count), reduced.file).squares;
      for (double &value : own) value = std::sqrt(value);
    });
    for (int root = 0; root < size && begin + root < all; ++root)
      MPI_Bcast(found[begin + root].data(), static_cast<int>(count), MPI_DOUBLE, root, reduced.comm);
  }
  return found;
}

} // namespace dovetail
