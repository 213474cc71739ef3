#include "stuck/own_rows.hpp"

#include <algorithm>

namespace dovetail {

Slab<double> rows_of_modes(const std::vector<double> &xa, const Layout &layout) {
  std::vector<int> counts(layout.size), starts(layout.size);
  for (int r = 0; r < layout.size; ++r) {
    const Range share = share_of(layout.points, r, layout.size);
    counts[r] = 3 * share.size(), starts[r] = 3 * share.begin;
  }
  Slab<double> rows(layout.own_modes.size(), 3 * layout.points);
  std::vector<double> own(3 * layout.own_points.size()), all(3 * layout.points);
  for (PetscInt mode = 0; mode < layout.modes; ++mode) {
    for (std::size_t i = 0; i < own.size(); ++i) own[i] = xa[i * layout.modes + mode];
    MPI_Gatherv(own.data(), static_cast<int>(own.size()), MPI_DOUBLE, all.data(), counts.data(), starts.data(),
                MPI_DOUBLE, owner_of(layout.modes, mode, layout.size), layout.comm);
    if (mode >= layout.own_modes.begin && mode < layout.own_modes.end)
      std::copy(all.begin(), all.end(), rows.row(mode - layout.own_modes.begin));
  }
  return rows;
}

} // namespace dovetail
