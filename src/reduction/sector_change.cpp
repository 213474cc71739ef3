#include "reduction/sector_change.hpp"

#include <algorithm>
#include <map>

#include "support/error.hpp"

namespace dovetail {
namespace {

using Row = std::map<PetscInt, double>; // of T, by column

// Rows of T other than those of the identity. x takes the place of u_a, or of u_b without a; s that of u_b.
std::map<PetscInt, Row> changed_rows(const CyclicSector &sector) {
  std::map<PetscInt, Row> rows;
  for (const CyclicSector::Contact &contact : sector.contacts) {
    if (contact.next) continue;
    const CyclicSector::Node &x = contact.has_a() ? contact.a : contact.b;
    const double half = contact.is_pair() ? 0.5 : 1;
    for (int d = 0; d < 3; ++d)
      for (int j = 0; j < 3; ++j) {
        const double along = half * contact.axes[3 * j + d];
        if (contact.has_a()) rows[contact.a[d]][x[j]] += along;
        if (contact.has_b()) rows[contact.b[d]][x[j]] -= along;
      }
    for (int d = 0; d < 3 && contact.is_pair(); ++d)
      rows[contact.a[d]][contact.b[d]] += 0.5, rows[contact.b[d]][contact.b[d]] += 0.5;
    for (const CyclicSector::Weighted &part : contact.face)
      for (int d = 0; d < 3; ++d)
        if (part.node[d] >= 0) rows[contact.a[d]][part.node[d]] += part.weight;
  }
  return rows;
}

UniqueMat change_of(Mat K, const CyclicSector &sector) {
  MPI_Comm comm;
  PetscInt begin, end, n;
  UniqueMat T;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(K), &comm), "changing coordinates");
  check(MatGetOwnershipRange(K, &begin, &end), "changing coordinates");
  check(MatGetSize(K, &n, nullptr), "changing coordinates");
  const std::map<PetscInt, Row> rows = changed_rows(sector);
  std::vector<PetscInt> at{0}, column;
  std::vector<double> value;
  for (PetscInt i = begin; i < end; ++i) {
    const auto found = rows.find(i);
    for (const auto &[j, entry] : found == rows.end() ? Row{{i, 1.0}} : found->second)
      if (entry != 0) column.push_back(j), value.push_back(entry);
    at.push_back(static_cast<PetscInt>(column.size()));
  }
  check(MatCreate(comm, T.out()), "changing coordinates");
  check(MatSetSizes(T, end - begin, end - begin, n, n), "changing coordinates");
  check(MatSetType(T, MATAIJ), "changing coordinates");
  check(MatSeqAIJSetPreallocationCSR(T, at.data(), column.data(), value.data()), "changing coordinates");
  check(MatMPIAIJSetPreallocationCSR(T, at.data(), column.data(), value.data()), "changing coordinates");
  return T;
}

void change(Mat T, UniqueMat &A) { // T^T A T
  UniqueMat out;
  check(MatPtAP(A, T, MAT_INITIAL_MATRIX, PETSC_DEFAULT, out.out()), "changing coordinates");
  check(MatSetOption(out, MAT_SYMMETRIC, PETSC_TRUE), "changing coordinates");
  A = std::move(out);
}

void change(Mat T, UniqueVec &v) { // T^T v
  UniqueVec out;
  check(VecDuplicate(v, out.out()), "changing coordinates");
  check(MatMultTranspose(T, v, out), "changing coordinates");
  v = std::move(out);
}

} // namespace

CyclicSector changed(const CyclicSector &sector) {
  CyclicSector out = sector;
  for (CyclicSector::Contact &contact : out.contacts) {
    if (contact.next) continue;
    contact.a = contact.has_a() ? contact.a : contact.b;
    contact.b = {-1, -1, -1}, contact.face.clear();
    contact.axes = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  }
  return out;
}

void change_within_sector(FullModel &model, bool all, const std::vector<PetscInt> &wanted) {
  PetscInt begin, end;
  UniqueMat T = change_of(model.K, model.cyclic);
  for (UniqueMat *A : {&model.K, &model.M}) change(T, *A);
  for (ForcePattern &force : model.forces) change(T, force.values);
  change(T, model.preload);
  model.cyclic = changed(model.cyclic);
  check(MatGetOwnershipRange(T, &begin, &end), "changing coordinates");
  for (PetscInt dof = begin; dof < end; ++dof)
    if (all || std::binary_search(wanted.begin(), wanted.end(), dof)) model.moved.push_back(dof);
  model.change = std::move(T);
}

} // namespace dovetail
