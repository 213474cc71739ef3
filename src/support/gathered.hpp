#pragma once
// Numbers of all ranks in one place.
#include <mpi.h>

#include <array>
#include <vector>

#include "support/int_count.hpp"

namespace dovetail {

constexpr int on_all = -1;

/// Where each rank's part begins, and where the last one ends. ComputeError if that is more than MPI can say.
inline std::vector<int> places_of(const std::vector<long long> &counts) {
  std::vector<int> places{0};
  for (const long long count : counts)
    places.push_back(int_count(static_cast<std::size_t>(count) + places.back(), "numbers that ranks gather at once"));
  return places;
}

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
  const long long count = static_cast<long long>(own.size());
  std::vector<long long> all_counts(size);
  MPI_Allgather(&count, 1, MPI_LONG_LONG, all_counts.data(), 1, MPI_LONG_LONG, comm);
  const std::vector<int> places = places_of(all_counts), counts(all_counts.begin(), all_counts.end());
  std::vector<Number> all(root == on_all || root == rank ? places[size] : 0);
  if (root == on_all)
    MPI_Allgatherv(own.data(), counts[rank], type, all.data(), counts.data(), places.data(), type, comm);
  else
    MPI_Gatherv(own.data(), counts[rank], type, all.data(), counts.data(), places.data(), type, root, comm);
  return all;
}

} // namespace dovetail
