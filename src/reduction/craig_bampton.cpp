#include <petscsys.h>

#include <petscblaslapack.h> // needs petscsys.h before it

#include <algorithm>
#include <numeric>

#include "reduction/elastic_modes.hpp"
#include "reduction/reduced_model.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

struct Blocks { // of one symmetric matrix; rows of ..e by elastic dofs, of ..c by contact points, on their owners
  UniqueMat ee, ec, ce, cc;
};

Blocks split(Mat A, IS elastic, IS contact) {
  Blocks blocks;
  check(MatCreateSubMatrix(A, elastic, elastic, MAT_INITIAL_MATRIX, blocks.ee.out()), "splitting a matrix");
  check(MatCreateSubMatrix(A, elastic, contact, MAT_INITIAL_MATRIX, blocks.ec.out()), "splitting a matrix");
  check(MatCreateSubMatrix(A, contact, elastic, MAT_INITIAL_MATRIX, blocks.ce.out()), "splitting a matrix");
  check(MatCreateSubMatrix(A, contact, contact, MAT_INITIAL_MATRIX, blocks.cc.out()), "splitting a matrix");
  return blocks;
}

// Column-major own rows of a distributed tall matrix; what the products below run on.
struct Slab {
  PetscInt rows = 0, columns = 0;
  std::vector<double> values;
  double *column(PetscInt j) { return values.data() + static_cast<std::size_t>(j) * rows; }
  const double *column(PetscInt j) const { return values.data() + static_cast<std::size_t>(j) * rows; }
};

// Adds factor * (own rows of sparse A) to the slab, columns [first, first + slab.columns) of A.
void add_sparse(Mat A, double factor, PetscInt first, Slab &slab) {
  PetscInt begin, end;
  check(MatGetOwnershipRange(A, &begin, &end), "reading rows");
  for (PetscInt i = begin; i < end; ++i) {
    PetscInt count;
    const PetscInt *columns;
    const double *values;
    check(MatGetRow(A, i, &count, &columns, &values), "reading rows");
    for (PetscInt at = 0; at < count; ++at)
      if (columns[at] >= first && columns[at] < first + slab.columns)
        slab.column(columns[at] - first)[i - begin] += factor * values[at];
    check(MatRestoreRow(A, i, &count, &columns, &values), "reading rows");
  }
}

// Psi = -K_ee^-1 K_ec (eq 16), a block of columns at a time.
Slab constraint_modes(const ClampedSolver &solver, Mat K_ec) {
  constexpr PetscInt block = 128;
  MPI_Comm comm;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(K_ec), &comm), "computing constraint modes");
  Slab psi;
  PetscInt total;
  check(MatGetLocalSize(K_ec, &psi.rows, nullptr), "computing constraint modes");
  check(MatGetSize(K_ec, nullptr, &total), "computing constraint modes");
  psi.columns = total;
  psi.values.resize(static_cast<std::size_t>(psi.rows) * total);
  for (PetscInt first = 0; first < total; first += block) {
    Slab rhs{psi.rows, std::min(block, total - first), {}};
    rhs.values.resize(static_cast<std::size_t>(rhs.rows) * rhs.columns);
    add_sparse(K_ec, -1, first, rhs);
    UniqueMat B, X;
    check(MatCreateDense(comm, psi.rows, PETSC_DECIDE, PETSC_DETERMINE, rhs.columns, rhs.values.data(), B.out()),
          "computing constraint modes");
    check(MatCreateDense(comm, psi.rows, PETSC_DECIDE, PETSC_DETERMINE, rhs.columns, psi.column(first), X.out()),
          "computing constraint modes");
    for (Mat A : {Mat(B), Mat(X)}) {
      check(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY), "computing constraint modes");
      check(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY), "computing constraint modes");
    }
    solver.solve(B, X);
  }
  return psi;
}

// Own rows of A S for sparse A and a slab S distributed like A's columns.
Slab multiply(Mat A, Slab &S) {
  MPI_Comm comm;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(A), &comm), "multiplying");
  UniqueMat B, C;
  Slab product;
  product.columns = S.columns;
  check(MatGetLocalSize(A, &product.rows, nullptr), "multiplying");
  check(MatCreateDense(comm, S.rows, PETSC_DECIDE, PETSC_DETERMINE, S.columns, S.values.data(), B.out()),
        "multiplying");
  check(MatAssemblyBegin(B, MAT_FINAL_ASSEMBLY), "multiplying");
  check(MatAssemblyEnd(B, MAT_FINAL_ASSEMBLY), "multiplying");
  check(MatMatMult(A, B, MAT_INITIAL_MATRIX, PETSC_DEFAULT, C.out()), "multiplying");
  const double *values;
  PetscInt lda;
  check(MatDenseGetLDA(C, &lda), "multiplying");
  check(MatDenseGetArrayRead(C, &values), "multiplying");
  product.values.resize(static_cast<std::size_t>(product.rows) * product.columns);
  for (PetscInt j = 0; j < product.columns; ++j)
    std::copy_n(values + static_cast<std::size_t>(j) * lda, product.rows, product.column(j));
  check(MatDenseRestoreArrayRead(C, &values), "multiplying");
  return product;
}

// Own contact rows (row-major) of S^T T, S and T distributed by elastic rows: each rank's share of the rows is summed
// onto its owner, one reduction per owner.
std::vector<double> transposed_product(MPI_Comm comm, PetscInt points, const Slab &S, const Slab &T) {
  int size, rank;
  MPI_Comm_size(comm, &size);
  MPI_Comm_rank(comm, &rank);
  std::vector<double> own, part;
  for (int owner = 0; owner < size; ++owner) {
    const Range range = share_of(points, owner, size);
    const PetscBLASInt rows = 3 * range.size(), columns = T.columns, inner = S.rows, ld = std::max<PetscInt>(1, S.rows);
    part.assign(static_cast<std::size_t>(rows) * columns, 0.0);
    const double one = 1, zero = 0;
    if (rows > 0 && columns > 0 && inner > 0) // column-major (columns, rows) is row-major (rows, columns)
      BLASgemm_("T", "N", &columns, &rows, &inner, &one, T.values.data(), &ld, S.column(3 * range.begin), &ld, &zero,
                part.data(), &columns);
    if (owner == rank) own.resize(part.size());
    MPI_Reduce(part.data(), own.data(), static_cast<int>(part.size()), MPI_DOUBLE, MPI_SUM, owner, comm);
  }
  return own;
}

std::vector<double> own_values(Vec v) {
  PetscInt n;
  const double *values;
  check(VecGetLocalSize(v, &n), "reading a vector");
  check(VecGetArrayRead(v, &values), "reading a vector");
  std::vector<double> copy(values, values + n);
  check(VecRestoreArrayRead(v, &values), "reading a vector");
  return copy;
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
  return own_values(chosen);
}

std::vector<double> row_major(const Slab &slab) {
  std::vector<double> out(slab.values.size());
  for (PetscInt i = 0; i < slab.rows; ++i)
    for (PetscInt j = 0; j < slab.columns; ++j) out[static_cast<std::size_t>(i) * slab.columns + j] = slab.column(j)[i];
  return out;
}

void add_to(std::vector<double> &rows, const Slab &slab) {
  for (PetscInt i = 0; i < slab.rows; ++i)
    for (PetscInt j = 0; j < slab.columns; ++j)
      rows[static_cast<std::size_t>(i) * slab.columns + j] += slab.column(j)[i];
}

} // namespace

Reduction craig_bampton(const FullModel &full, PetscInt modes) {
  const MPI_Comm comm = full.comm;
  Reduction out;
  ReducedModel &model = out.model;
  Recovery &recovery = out.recovery;
  model.comm = comm;
  model.units = full.units;
  model.modes = modes;
  model.points = static_cast<PetscInt>(full.contact_dofs.size());
  model.own_points = own_share(comm, model.points);
  model.own_modes = own_share(comm, modes);

  std::vector<PetscInt> contact, elastic;
  for (PetscInt p = model.own_points.begin; p < model.own_points.end; ++p)
    contact.insert(contact.end(), full.contact_dofs[p].begin(), full.contact_dofs[p].end());
  PetscInt begin, end;
  check(MatGetOwnershipRange(full.K, &begin, &end), "splitting dofs");
  std::vector<char> in_contact(end - begin, 0);
  for (const auto &point : full.contact_dofs)
    for (const PetscInt dof : point)
      if (dof >= begin && dof < end) in_contact[dof - begin] = 1;
  for (PetscInt dof = begin; dof < end; ++dof)
    if (!in_contact[dof - begin]) elastic.push_back(dof), recovery.elastic_dofs.push_back(dof);
  recovery.elastic = full.dofs - model.contact_dofs();
  const PetscInt own_elastic = static_cast<PetscInt>(elastic.size());
  MPI_Exscan(&own_elastic, &recovery.own.begin, 1, MPIU_INT, MPI_SUM, comm);
  recovery.own.end = recovery.own.begin + own_elastic;
  if (modes > recovery.elastic)
    throw InputError(full.file.string() + ": reduction.modes = " + std::to_string(modes) + ", but the model has only " +
                     std::to_string(recovery.elastic) +
                     " elastic dofs (those not in /contact/dofs): at most so many modes exist");

  UniqueIS is_e, is_c;
  check(ISCreateGeneral(comm, own_elastic, elastic.data(), PETSC_COPY_VALUES, is_e.out()), "splitting dofs");
  check(ISCreateGeneral(comm, static_cast<PetscInt>(contact.size()), contact.data(), PETSC_COPY_VALUES, is_c.out()),
        "splitting dofs");
  Slab contact_rows{model.own_contact_dofs(), model.contact_dofs(), {}};
  const auto rows_of = [&](Mat A) { // own rows of a sparse contact block, row-major
    contact_rows.values.assign(static_cast<std::size_t>(contact_rows.rows) * contact_rows.columns, 0.0);
    add_sparse(A, 1, 0, contact_rows);
    return row_major(contact_rows);
  };
  const Blocks K = split(full.K, is_e, is_c), M = split(full.M, is_e, is_c);
  model.kxx = rows_of(K.cc);
  model.mxx = rows_of(M.cc);
  model.fx = values_at(full.force, is_c);
  model.r = values_at(full.preload, is_c);
  for (double &value : model.r) value = -value;
  if (recovery.elastic == 0) return out; // every dof in contact: nothing to condense

  const ClampedSolver solver(K.ee, full.file.string());
  out.ordering = solver.ordering();

  UniqueVec xe0, load, reaction; // eq (2)
  check(MatCreateVecs(K.ee, xe0.out(), load.out()), "elastic preload");
  recovery.xe0 = values_at(full.preload, is_e);
  double *array;
  check(VecGetArrayWrite(load, &array), "elastic preload");
  std::copy(recovery.xe0.begin(), recovery.xe0.end(), array);
  check(VecRestoreArrayWrite(load, &array), "elastic preload");
  solver.solve(load, xe0);
  recovery.xe0 = own_values(xe0);
  check(MatCreateVecs(K.ce, nullptr, reaction.out()), "elastic preload");
  check(MatMult(K.ce, xe0, reaction), "elastic preload");
  const auto held = own_values(reaction);
  for (std::size_t i = 0; i < held.size(); ++i) model.r[i] += held[i]; // R = K_ce x_e0 - P_c

  Slab psi = constraint_modes(solver, K.ec); // eq (16)

  // after Psi: SLEPc resets the shared solver when it is done
  const ElasticModes found = elastic_modes(solver, K.ee, M.ee, modes, full.file.string()); // eq (15)
  model.kaa = found.squares;
  Slab phi{own_elastic, modes, {}};
  for (const UniqueVec &shape : found.shapes) {
    const auto column = own_values(shape);
    phi.values.insert(phi.values.end(), column.begin(), column.end());
  }

  add_to(model.kxx, multiply(K.ce, psi)); // K_xx = K_cc + K_ce Psi
  add_to(model.mxx, multiply(M.ce, psi)); // M_xx = M_cc + M_ce Psi + Psi^T (M_ee Psi + M_ec)
  Slab inertia = multiply(M.ee, psi);
  add_sparse(M.ec, 1, 0, inertia);
  const auto quadratic = transposed_product(comm, model.points, psi, inertia);
  for (std::size_t i = 0; i < quadratic.size(); ++i) model.mxx[i] += quadratic[i];
  model.mxa = transposed_product(comm, model.points, inertia, phi); // M_ax = Phi^T (M_ee Psi + M_ec)

  Slab force{own_elastic, 1, values_at(full.force, is_e)}; // eqs (17), (18)
  const auto loaded = transposed_product(comm, model.points, psi, force);
  for (std::size_t i = 0; i < loaded.size(); ++i) model.fx[i] += loaded[i];
  model.fa.resize(modes);
  for (PetscInt j = 0; j < modes; ++j)
    model.fa[j] = std::inner_product(force.values.begin(), force.values.end(), phi.column(j), 0.0);
  MPI_Allreduce(MPI_IN_PLACE, model.fa.data(), modes, MPI_DOUBLE, MPI_SUM, comm);

  recovery.phi = row_major(phi);
  recovery.psi = row_major(psi);
  return out;
}

} // namespace dovetail
