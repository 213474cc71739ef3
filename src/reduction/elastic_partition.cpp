#include "reduction/elastic_partition.hpp"

#include <metis.h>

#include <algorithm>

#include "support/error.hpp"
#include "support/gathered.hpp"
#include "support/partition.hpp"

namespace dovetail {
namespace {

// Consecutive rows with the same columns: as a rule the dofs of one node.
struct Groups {
  std::vector<PetscInt> begin;    // of every group, first own dof ...
  std::vector<PetscInt> edges_at; // (groups + 1)
  std::vector<PetscInt> edges;    // dofs its rows are coupled to
};

Groups own_groups(Mat K) {
  Groups groups;
  PetscInt begin, end;
  check(MatGetOwnershipRange(K, &begin, &end), "partitioning");
  for (PetscInt i = begin; i < end; ++i) {
    PetscInt count;
    const PetscInt *columns;
    check(MatGetRow(K, i, &count, &columns, nullptr), "partitioning");
    const bool same = !groups.begin.empty() &&
                      static_cast<std::size_t>(count) == groups.edges.size() - groups.edges_at.back() &&
                      std::equal(columns, columns + count, groups.edges.end() - count);
    if (!same) {
      groups.begin.push_back(i);
      groups.edges_at.push_back(static_cast<PetscInt>(groups.edges.size()));
      groups.edges.insert(groups.edges.end(), columns, columns + count);
    }
    check(MatRestoreRow(K, i, &count, &columns, nullptr), "partitioning");
  }
  groups.edges_at.push_back(static_cast<PetscInt>(groups.edges.size()));
  return groups;
}

// Part of each vertex by METIS. weights: (vertices, 2) elastic dofs and those of them that touch a contact dof.
std::vector<PetscInt> metis_parts(const std::vector<PetscInt> &degrees, const std::vector<PetscInt> &neighbours,
                                  const std::vector<PetscInt> &weights, int parts) {
  std::vector<std::vector<idx_t>> linked(degrees.size()); // both ways: K may hold a zero on one side only
  std::size_t at_edge = 0;
  for (std::size_t g = 0; g < degrees.size(); ++g)
    for (PetscInt d = 0; d < degrees[g]; ++d, ++at_edge)
      linked[g].push_back(neighbours[at_edge]), linked[neighbours[at_edge]].push_back(static_cast<idx_t>(g));
  std::vector<idx_t> begin{0}, edges, load(weights.begin(), weights.end()), part(degrees.size());
  for (auto &list : linked) {
    std::sort(list.begin(), list.end());
    edges.insert(edges.end(), list.begin(), std::unique(list.begin(), list.end()));
    begin.push_back(int_count(edges.size(), "edges between nodes for METIS"));
  }
  idx_t vertices = static_cast<idx_t>(degrees.size()), constraints = 2, wanted = parts, cut = 0;
  const real_t allowed[] = {1.03f, 1.5f};
  idx_t touching = 0;
  for (std::size_t at = 1; at < load.size(); at += 2) touching += load[at];
  if (touching == 0) // METIS divides by the sum of each weight
    for (std::size_t at = 1; at < load.size(); at += 2) load[at] = load[at - 1];
  // recursive bisection keeps to the limits for few parts, where the k-way method overruns them by a tenth
  const int status = (parts <= 8 ? METIS_PartGraphRecursive : METIS_PartGraphKway)(
      &vertices, &constraints, begin.data(), edges.data(), load.data(), nullptr, nullptr, &wanted, nullptr,
      const_cast<real_t *>(allowed), nullptr, &cut, part.data());
  if (status != METIS_OK) throw ComputeError("while partitioning: METIS failed (" + std::to_string(status) + ")");
  return {part.begin(), part.end()};
}

} // namespace

std::vector<PetscInt> elastic_share(Mat K, const std::vector<std::array<PetscInt, 3>> &contact) {
  MPI_Comm comm;
  int size, rank;
  PetscInt dofs;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(K), &comm), "partitioning");
  check(MatGetSize(K, &dofs, nullptr), "partitioning");
  MPI_Comm_size(comm, &size);
  MPI_Comm_rank(comm, &rank);
  std::vector<char> held(dofs, 0);
  for (const auto &point : contact)
    for (const PetscInt dof : point) held[dof] = 1;
  std::vector<PetscInt> own;
  const Groups groups = size > 1 ? own_groups(K) : Groups{};
  const auto begins = gathered(comm, MPIU_INT, groups.begin); // of all groups of all ranks, ascending
  if (begins.size() < 8u * size) {                            // nothing to choose
    const Range share = own_share(comm, dofs);
    for (PetscInt dof = share.begin; dof < share.end; ++dof)
      if (!held[dof]) own.push_back(dof);
    return own;
  }
  const auto group_of = [&](PetscInt dof) {
    return static_cast<PetscInt>(std::upper_bound(begins.begin(), begins.end(), dof) - begins.begin()) - 1;
  };
  const auto end_of = [&](PetscInt group) {
    return group + 1 < static_cast<PetscInt>(begins.size()) ? begins[group + 1] : dofs;
  };
  std::vector<PetscInt> degrees, neighbours, weights;
  for (std::size_t g = 0; g < groups.begin.size(); ++g) {
    const PetscInt self = group_of(groups.begin[g]);
    const std::size_t before = neighbours.size();
    bool touches = false;
    for (PetscInt at = groups.edges_at[g]; at < groups.edges_at[g + 1]; ++at) {
      const PetscInt other = group_of(groups.edges[at]);
      touches = touches || held[groups.edges[at]];
      if (other != self && (neighbours.size() == before || neighbours.back() != other)) neighbours.push_back(other);
    }
    degrees.push_back(static_cast<PetscInt>(neighbours.size() - before));
    const PetscInt elastic =
        static_cast<PetscInt>(std::count(held.begin() + begins[self], held.begin() + end_of(self), 0));
    weights.push_back(elastic);
    weights.push_back(touches ? elastic : 0);
  }
  const auto all_degrees = gathered(comm, MPIU_INT, degrees, 0),
             all_neighbours = gathered(comm, MPIU_INT, neighbours, 0),
             all_weights = gathered(comm, MPIU_INT, weights, 0);
  std::vector<PetscInt> part(begins.size());
  on_all_ranks(comm, [&] {
    if (rank == 0) part = metis_parts(all_degrees, all_neighbours, all_weights, size);
  });
  MPI_Bcast(part.data(), static_cast<int>(part.size()), MPIU_INT, 0, comm);
  for (PetscInt g = 0; g < static_cast<PetscInt>(begins.size()); ++g)
    if (part[g] == rank)
      for (PetscInt dof = begins[g]; dof < end_of(g); ++dof)
        if (!held[dof]) own.push_back(dof);
  return own;
}

} // namespace dovetail
