#pragma once
// Numbers of all ranks in one place.
#include <mpi.h>

#include <array>
#include <numeric>
#include <vector>

namespace dovetail {

constexpr int on_all = -1;

/// `each` own numbers of all ranks, one rank's after the other's, on all. Collective.
template <class Number, std::size_t each>
std::vector<Number> gathered(MPI_Comm comm, MPI_Datatype type, const std::array<Number, each> &own) {
  int size;
  MPI_Comm_size(comm, &size);
  std::vector<Number> all(each * size);
  MPI_Allgather(own.data(), each, type, all.data(), each, type, comm);
  return all;
}

/// Own numbers of all ranks, one rank's after the other's, on rank `root` or on all; on others none. Collective.
template <class Number>
std::vector<Number> gathered(MPI_Comm comm, MPI_Datatype type, const std::vector<Number> &own, int root = on_all) {
  int rank, size;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  const int count = static_cast<int>(own.size());
  std::vector<int> counts(size), places(size + 1, 0);
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  std::partial_sum(counts.begin(), counts.end(), places.begin() + 1);
  std::vector<Number> all(root == on_all || root == rank ? places[size] : 0);
  if (root == on_all)
    MPI_Allgatherv(own.data(), count, type, all.data(), counts.data(), places.data(), type, comm);
  else
    MPI_Gatherv(own.data(), count, type, all.data(), counts.data(), places.data(), type, root, comm);
  return all;
}

} // namespace dovetail
