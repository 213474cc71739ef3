#include "analyses/last_iterate.hpp"

#include <cmath>
#include <cstdio>
#include <vector>

namespace dovetail {

std::string difference(const HarmonicSystem &system, const CurvePoint &here) {
  if (system.adrift())
    return "; the body is held by its joint alone, and its contacts are open, or slip, all through the period: nothing "
           "holds its mean position, it walks or flies off, unless it is pressed on harder or something else holds it";
  static const std::vector<Activity> none;
  const std::vector<Activity> &then = here.data ? data_of(here).activity : none, &now = system.activity();
  struct {
    double size;
    int rank;
  } most{0, system.layout().rank};
  std::size_t which = 0;
  for (std::size_t p = 0; p < now.size() && p < then.size(); ++p) {
    const double size = std::abs(now[p].open - then[p].open) + std::abs(now[p].slip - then[p].slip);
    if (size > most.size) most.size = size, which = p;
  }
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, system.layout().comm);
  if (most.size == 0) return "";
  char words[200] = "";
  if (most.rank == system.layout().rank)
    std::snprintf(words, sizeof words,
                  "; contact point %d is open for %.3g %% of the period at the last point and for %.3g %% where Newton "
                  "stopped, slips for %.3g %% and %.3g %%",
                  static_cast<int>(system.layout().own_points.begin + which) + 1, 100 * then[which].open,
                  100 * now[which].open, 100 * then[which].slip, 100 * now[which].slip);
  MPI_Bcast(words, sizeof words, MPI_CHAR, most.rank, system.layout().comm);
  return words;
}

} // namespace dovetail
