#include "reduction/clamped_structure.hpp"

#include "reduction/elastic_partition.hpp"
#include "support/error.hpp"
#include "support/shell.hpp"

namespace dovetail {
namespace {

Blocks split(const UniqueMat A, IS elastic, IS contact) { // A is not wanted any more
  Blocks blocks;
  check(MatCreateSubMatrix(A, elastic, elastic, MAT_INITIAL_MATRIX, blocks.ee.out()), "splitting a matrix");
  check(MatCreateSubMatrix(A, elastic, contact, MAT_INITIAL_MATRIX, blocks.ec.out()), "splitting a matrix");
  check(MatCreateSubMatrix(A, contact, elastic, MAT_INITIAL_MATRIX, blocks.ce.out()), "splitting a matrix");
  check(MatCreateSubMatrix(A, contact, contact, MAT_INITIAL_MATRIX, blocks.cc.out()), "splitting a matrix");
  return blocks;
}

std::vector<double> values_at(Vec v, IS places) {
  MPI_Comm comm;
  PetscInt count;
  UniqueVec chosen;
  UniqueScatter scatter;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(v), &comm), "reading a vector");
  check(ISGetLocalSize(places, &count), "reading a vector");
  check(VecCreateMPI(comm, count, PETSC_DETERMINE, chosen.out()), "reading a vector");
  check(VecScatterCreate(v, places, chosen, nullptr, scatter.out()), "reading a vector");
  check(VecScatterBegin(scatter, v, chosen, INSERT_VALUES, SCATTER_FORWARD), "reading a vector");
  check(VecScatterEnd(scatter, v, chosen, INSERT_VALUES, SCATTER_FORWARD), "reading a vector");
  const ReadValues values(chosen);
  const double *const from = values;
  return {from, from + count};
}

UniqueIS list(MPI_Comm comm, const std::vector<PetscInt> &dofs) {
  UniqueIS is;
  check(ISCreateGeneral(comm, static_cast<PetscInt>(dofs.size()), dofs.data(), PETSC_COPY_VALUES, is.out()),
        "splitting dofs");
  return is;
}

} // namespace

ClampedStructure clamp(FullModel &&full) {
  ClampedStructure parts;
  parts.full = std::move(full);
  const MPI_Comm comm = parts.full.comm;
  const auto points = static_cast<PetscInt>(parts.full.contact_dofs.size());
  parts.own_points = own_share(comm, points);
  std::vector<PetscInt> contact;
  for (PetscInt p = parts.own_points.begin; p < parts.own_points.end; ++p)
    contact.insert(contact.end(), parts.full.contact_dofs[p].begin(), parts.full.contact_dofs[p].end());
  const auto elastic = elastic_share(parts.full.K, parts.full.contact_dofs);
  parts.elastic_dofs.assign(elastic.begin(), elastic.end());
  parts.elastic = parts.full.dofs - 3 * points;
  const auto own = static_cast<PetscInt>(elastic.size());
  MPI_Exscan(&own, &parts.own.begin, 1, MPIU_INT, MPI_SUM, comm);
  parts.own.end = parts.own.begin + own;

  const UniqueIS e = list(comm, elastic), c = list(comm, contact);
  parts.force_e = Tall(own, static_cast<PetscInt>(parts.full.forces.size()));
  for (PetscInt j = 0; j < parts.force_e.columns; ++j) {
    const UniqueVec force = std::move(parts.full.forces[j].values);
    const std::vector<double> elastic_part = values_at(force, e);
    std::copy(elastic_part.begin(), elastic_part.end(), parts.force_e.column(j));
    parts.force_c.push_back(values_at(force, c));
  }
  const UniqueVec preload = std::move(parts.full.preload);
  parts.preload_e = values_at(preload, e), parts.preload_c = values_at(preload, c);
  parts.K = split(std::move(parts.full.K), e, c);
  parts.M = split(std::move(parts.full.M), e, c);
  for (const auto &[whole, split_up] :
       {std::pair(&parts.full.C, &parts.C), std::pair(&parts.full.K_structural, &parts.K_structural)})
    if (*whole) *split_up = split(std::move(*whole), e, c);
  if (const UniqueMat change = std::move(parts.full.change)) {
    parts.moved.dofs.assign(parts.full.moved.begin(), parts.full.moved.end());
    const UniqueIS rows = list(comm, parts.full.moved);
    check(MatCreateSubMatrix(change, rows, e, MAT_INITIAL_MATRIX, parts.moved.e.out()), "splitting rows");
    check(MatCreateSubMatrix(change, rows, c, MAT_INITIAL_MATRIX, parts.moved.c.out()), "splitting rows");
  }
  if (parts.elastic > 0) parts.solver = std::make_unique<ClampedSolver>(parts.K.ee, parts.full.file.string());
  return parts;
}

} // namespace dovetail
