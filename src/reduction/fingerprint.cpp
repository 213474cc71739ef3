#include <cinttypes>
#include <cstdio>
#include <cstring>

#include "reduction/reduced_model.hpp"
#include "support/hash.hpp"

namespace dovetail {

std::string fingerprint_of(const ReducedModel &model) {
  std::uint64_t sum = 0, kind = 0; // a sum, whose terms may come in any order
  const auto take = [&](const std::vector<double> &values, std::uint64_t first) {
    ++kind;
    for (std::size_t i = 0; i < values.size(); ++i) {
      std::uint64_t bits;
      std::memcpy(&bits, &values[i], sizeof bits);
      sum += mix(mix(mix(kind) ^ (first + i)) ^ bits);
    }
  };
  int rank;
  MPI_Comm_rank(model.comm, &rank);
  const std::uint64_t row = 3 * model.own_points.begin, contact = model.contact_dofs();
  const LeftOut &left = model.left_out;
  const auto take_once = [&](const std::vector<double> &values) { // of what is on every rank
    take(rank == 0 ? values : std::vector<double>(), 0);
  };
  take_once(model.kaa), take_once(left.squares), take_once(left.with_modes);
  for (const auto &load : left.loads) take_once(load);
  for (const LoadPattern &load : model.loads) {
    take_once(load.fa);
    take(load.fx, row);
  }
  take(model.r, row);
  take(model.kxx, row * contact), take(model.mxx, row * contact);
  take(model.mxa, row * model.modes), take(left.coupling, row * left.squares.size());
  for (const DampingMatrix *matrix : {&model.viscous, &model.structural}) {
    if (!matrix->given) {
      kind += 3; // absent, it leaves the number as it is
      continue;
    }
    take_once(matrix->aa);
    take(matrix->xa, row * model.modes), take(matrix->xx, row * contact);
  }
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, model.comm);
  char text[24];
  std::snprintf(text, sizeof text, "%016" PRIx64, sum);
  return text;
}

} // namespace dovetail
