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
  const auto take_complex = [&](const std::vector<std::complex<double>> &values, std::uint64_t first) {
    std::vector<double> parts;
    for (const std::complex<double> value : values) parts.push_back(value.real()), parts.push_back(value.imag());
    take(parts, 2 * first);
  };
  for (const SectorIndex &index : model.indices) {
    take_once(index.kaa);
    take_complex(index.kxx, row * contact), take_complex(index.mxx, row * contact);
    take_complex(index.mxa, row * model.modes);
    for (const SectorIndex::Load &load : index.loads) {
      take_complex(rank == 0 ? load.fa : std::vector<std::complex<double>>(), 0);
      take_complex(load.fx, row);
    }
    const auto &beyond = index.left_out;
    if (beyond.squares.empty()) continue; // absent, it leaves the number as it is
    take_once(beyond.squares), take_complex(rank == 0 ? beyond.with_modes : decltype(beyond.with_modes)(), 0);
    for (const auto &load : beyond.loads) take_complex(rank == 0 ? load : decltype(beyond.with_modes)(), 0);
    take_complex(beyond.coupling, row * beyond.squares.size());
  }
  if (rank == 0 && model.sectors > 0) sum += mix(mix(++kind) ^ static_cast<std::uint64_t>(model.sectors));
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, model.comm);
  char text[24];
  std::snprintf(text, sizeof text, "%016" PRIx64, sum);
  return text;
}

} // namespace dovetail
