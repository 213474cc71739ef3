#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include "model/full_model.hpp"
#include "support/error.hpp"
#include "support/hash.hpp"
#include "support/hdf5.hpp"
#include "support/partition.hpp"

namespace dovetail {
namespace {

using h5::Extent;

// Sum of hashed (place, value): the same whatever rank holds an entry.
std::uint64_t entry_hash(std::uint64_t kind, std::uint64_t i, std::uint64_t j, double value) {
  std::uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return mix(mix(mix(kind * 0x9e3779b97f4a7c15u + i) + j) + bits);
}

// 0 for "force", so that models with this one pattern keep their number.
std::uint64_t name_hash(const std::string &name) {
  std::uint64_t hash = 0;
  if (name != force_pattern)
    for (const unsigned char c : name) hash = mix(hash + c + 1);
  return hash;
}

std::string place_of_pattern(const std::string &name) { return name == force_pattern ? "/force" : "/forces/" + name; }

std::vector<std::string> pattern_names(const h5::Reader &file) {
  std::vector<std::string> names;
  if (file.has("/force")) names.emplace_back(force_pattern);
  if (file.has("/forces"))
    for (const std::string &name : file.members("/forces")) {
      if (name == force_pattern)
        throw InputError(file.place("/forces/force") +
                         ": \"force\" is the name of the dataset /force; take another name");
      names.push_back(name);
    }
  if (names.empty())
    throw InputError(file.place("/force") + ": missing; one force per dof is wanted there, or in datasets of a group "
                                            "/forces, one per load pattern");
  return names;
}

struct Rows { // this rank's rows of a symmetric matrix, from the file's columns
  std::vector<PetscInt> begin, column;
  std::vector<double> value;
  std::uint64_t hash = 0; // of all entries
};

PetscInt matrix_size(const h5::Reader &file, const std::string &name) {
  if (!file.has(name))
    throw InputError(file.place(name) + ": missing; a sparse matrix as MATLAB v7.3 writes it is wanted");
  for (const char *part : {"/jc", "/ir", "/data"})
    if (!file.has(name + part)) throw InputError(file.place(name + part) + ": missing");
  const Extent jc = file.extent(name + "/jc");
  if (jc.size() != 1 || jc[0] < 2)
    throw InputError(file.place(name + "/jc") + ": one number per column and one more are wanted");
  if (jc[0] > hsize_t(std::numeric_limits<PetscInt>::max()))
    throw InputError(file.place(name + "/jc") + ": more columns than 32-bit numbers can count");
  const PetscInt n = static_cast<PetscInt>(jc[0] - 1);
  if (const long rows = file.integer_attribute("MATLAB_sparse", n, name); rows != n)
    throw InputError(file.place(name) + ": " + std::to_string(rows) + " rows (attribute MATLAB_sparse) but " +
                     std::to_string(n) + " columns; a square matrix is wanted");
  return n;
}

// Column numbers are read some millions at a time, because the file has them twice as wide as they are kept.
Rows read_rows(const h5::Reader &file, const std::string &name, PetscInt n, Range own, std::uint64_t kind,
               bool drop_zeros) {
  constexpr hsize_t most_at_once = 1 << 22;
  Rows rows;
  const auto jc = file.integers(name + "/jc", {hsize_t(own.begin)}, {hsize_t(own.size() + 1)});
  if (jc[0] < 0 || (own.begin == 0 && jc[0] != 0))
    throw InputError(file.place(name + "/jc") + ": begins with " + std::to_string(jc[0]) + " where 0 is wanted");
  for (std::size_t i = 1; i < jc.size(); ++i)
    if (jc[i] < jc[i - 1])
      throw InputError(file.place(name + "/jc") + ": decreases at column " + std::to_string(own.begin + i));
  const hsize_t first = jc.front(), count = jc.back() - jc.front();
  for (const char *part : {"/ir", "/data"})
    if (const Extent length = file.extent(name + part);
        length.size() != 1 || length[0] < first + count || (own.end == n && length[0] != first + count))
      throw InputError(file.place(name + part) + ": " + std::to_string(length.empty() ? 0 : length[0]) +
                       " entries where jc speaks of " + std::to_string(first + count) +
                       (own.end == n ? "" : " and more"));
  if (count > hsize_t(std::numeric_limits<PetscInt>::max()))
    throw InputError(file.place(name) + ": more entries on one rank than 32-bit numbers can count; take more ranks");
  rows.begin.push_back(0);
  if (!drop_zeros) rows.column.reserve(count), rows.value.reserve(count);
  PetscInt i = 0;
  long before = -1; // the row before, in the same column
  for (hsize_t at = 0; at < count; at += most_at_once) {
    const hsize_t some = std::min(most_at_once, count - at);
    const auto ir = file.integers(name + "/ir", {first + at}, {some});
    const auto data = file.doubles(name + "/data", {first + at}, {some});
    for (hsize_t e = 0; e < some; ++e) {
      while (hsize_t(jc[i + 1] - jc[0]) <= at + e)
        rows.begin.push_back(static_cast<PetscInt>(rows.value.size())), ++i, before = -1;
      const auto where = [&] { return " in column " + std::to_string(own.begin + i); };
      if (ir[e] < 0 || ir[e] >= n)
        throw InputError(file.place(name + "/ir") + ": " + std::to_string(ir[e]) + where() + " is outside 0.." +
                         std::to_string(n - 1));
      if (ir[e] <= before)
        throw InputError(file.place(name + "/ir") + ": rows" + where() + " are not in increasing order, each once");
      if (!std::isfinite(data[e]))
        throw InputError(file.place(name + "/data") + ": " + std::to_string(data[e]) + where() + ", row " +
                         std::to_string(ir[e]) + "; finite numbers are wanted");
      before = ir[e];
      if (drop_zeros && data[e] == 0 && ir[e] != own.begin + i) continue;
      rows.hash += entry_hash(kind, own.begin + i, ir[e], data[e]);
      rows.column.push_back(static_cast<PetscInt>(ir[e]));
      rows.value.push_back(data[e]);
    }
  }
  rows.begin.resize(own.size() + 1, static_cast<PetscInt>(rows.value.size()));
  return rows;
}

std::vector<double> read_vector(const h5::Reader &file, const std::string &name, PetscInt n, Range own) {
  const Extent shape = file.extent(name);
  hsize_t length = 1, longest = 0; // (n,), (n, 1) and (1, n) hold the same numbers in the same order
  for (const hsize_t axis : shape) length *= axis, longest = std::max(longest, axis);
  if (length != hsize_t(n) || longest != length)
    throw InputError(file.place(name) + ": " + std::to_string(length) + " values, " + std::to_string(n) +
                     " wanted (one per dof)");
  Extent offset, count;
  for (const hsize_t axis : shape) {
    offset.push_back(axis == length ? own.begin : 0);
    count.push_back(axis == length ? own.size() : axis);
  }
  auto values = file.doubles(name, offset, count);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      throw InputError(file.place(name) + ": " + std::to_string(values[i]) + " at dof " +
                       std::to_string(own.begin + i));
  return values;
}

ContactSettings read_contact(const h5::Reader &file) {
  ContactSettings settings;
  const auto read = [&](const char *key, std::optional<ContactSetting> &setting, double least, bool strictly) {
    const std::string name = std::string("/contact/") + key;
    if (!file.has(name)) return;
    const Extent shape = file.extent(name);
    const bool tangential = &setting == &settings.tangential_stiffness || &setting == &settings.friction;
    const bool pairs = tangential && !shape.empty() && shape.back() == 2; // [t1, t2], for all points or per point
    setting = ContactSetting{file.doubles(name), pairs, file.place(name)};
    for (const double value : setting->values)
      if (!std::isfinite(value) || value < least || (strictly && value == least))
        throw InputError(file.place(name) + ": " + std::to_string(value) + " where a finite number " +
                         (strictly ? "above " : "not below ") + std::to_string(least) + " is wanted");
  };
  const double any = -std::numeric_limits<double>::max();
  read("normal_stiffness", settings.normal_stiffness, 0, true);
  read("tangential_stiffness", settings.tangential_stiffness, 0, true);
  read("friction", settings.friction, 0, false);
  read("gap", settings.gap, any, false);
  if (file.has("/contact/area")) settings.area = file.doubles("/contact/area");
  if (file.has("/contact/joint")) {
    settings.joint = file.integers("/contact/joint");
    settings.joints = file.words_attribute("joints", "/contact");
  }
  return settings;
}

std::vector<std::array<PetscInt, 3>> read_contact_dofs(const h5::Reader &file, PetscInt n) {
  const std::string name = "/contact/dofs";
  const Extent shape = file.extent(name);
  if (shape.size() != 2 || shape[1] != 3)
    throw InputError(file.place(name) + ": one row of three dof numbers (t1, t2, n) per contact point is wanted");
  const auto flat = file.integers(name);
  std::vector<std::array<PetscInt, 3>> dofs(shape[0]);
  std::set<long> seen;
  for (std::size_t i = 0; i < flat.size(); ++i) {
    const std::string where = " for contact point " + std::to_string(i / 3) + " (counted from 0)";
    if (flat[i] < 0 || flat[i] >= n)
      throw InputError(file.place(name) + ": dof " + std::to_string(flat[i]) + where + " is out of range, 0.." +
                       std::to_string(n - 1) + " wanted");
    if (!seen.insert(flat[i]).second)
      throw InputError(file.place(name) + ": dof " + std::to_string(flat[i]) + where + " is repeated");
    dofs[i / 3][i % 3] = static_cast<PetscInt>(flat[i]);
  }
  return dofs;
}

void check_format(const h5::Reader &file, const std::filesystem::path &path) {
  const std::string format = file.text_attribute("format");
  if (format != "dovetail-model")
    throw InputError(
        path.string() + ": attribute format is \"" + format + "\", \"dovetail-model\" wanted" +
        (format == "dovetail-reduced" ? "; name a reduced file with  reduced =  instead of  model =" : ""));
  if (const long found = file.integer_attribute("version", 1); found != 1)
    throw InputError(path.string() + ": version " + std::to_string(found) +
                     " of the model format; this program reads version 1");
}

UniqueMat assemble(MPI_Comm comm, PetscInt n, Range own, const Rows &rows) {
  UniqueMat A;
  check(MatCreate(comm, A.out()), "creating a matrix");
  check(MatSetSizes(A, own.size(), own.size(), n, n), "sizing a matrix");
  check(MatSetType(A, MATAIJ), "typing a matrix");
  check(MatSeqAIJSetPreallocationCSR(A, rows.begin.data(), rows.column.data(), rows.value.data()), "filling a matrix");
  check(MatMPIAIJSetPreallocationCSR(A, rows.begin.data(), rows.column.data(), rows.value.data()), "filling a matrix");
  check(MatSetOption(A, MAT_SYMMETRIC, PETSC_TRUE), "marking a matrix");
  return A;
}

// A x against A^T x for one vector without structure, row by row against the size of the row: no transpose is stored.
void check_symmetry(Mat A, Range own, const std::string &place) {
  UniqueVec x, y, z, largest;
  check(MatCreateVecs(A, x.out(), y.out()), "checking symmetry");
  check(VecDuplicate(y, z.out()), "checking symmetry");
  check(VecDuplicate(y, largest.out()), "checking symmetry");
  double *values;
  check(VecGetArray(x, &values), "checking symmetry");
  for (PetscInt i = 0; i < own.size(); ++i) values[i] = 0.5 + static_cast<double>(mix(own.begin + i) >> 11) * 0x1p-53;
  check(VecRestoreArray(x, &values), "checking symmetry");
  check(MatMult(A, x, y), "checking symmetry");
  check(MatMultTranspose(A, x, z), "checking symmetry");
  check(MatGetRowMaxAbs(A, largest, nullptr), "checking symmetry");
  const double *a, *b, *scale;
  check(VecGetArrayRead(y, &a), "checking symmetry");
  check(VecGetArrayRead(z, &b), "checking symmetry");
  check(VecGetArrayRead(largest, &scale), "checking symmetry");
  PetscInt worst = -1;
  double most = 1e-8; // of the row's largest entry
  for (PetscInt i = 0; i < own.size(); ++i)
    if (const double off = std::abs(a[i] - b[i]); off > most * scale[i])
      worst = own.begin + i, most = scale[i] > 0 ? off / scale[i] : HUGE_VAL;
  MPI_Comm comm;
  PetscObjectGetComm(reinterpret_cast<PetscObject>(A), &comm);
  on_all_ranks(comm, [&] {
    if (worst >= 0)
      throw InputError(place + ": not symmetric, seen in row " + std::to_string(worst) +
                       " (of 0..); full symmetric storage is wanted");
  });
  VecRestoreArrayRead(y, &a), VecRestoreArrayRead(z, &b), VecRestoreArrayRead(largest, &scale);
}

void check_diagonal(Mat M, Range own, const std::string &place, const std::string &wanted) {
  UniqueVec diagonal;
  const double *values;
  MPI_Comm comm;
  check(MatCreateVecs(M, diagonal.out(), nullptr), "checking a diagonal");
  check(MatGetDiagonal(M, diagonal), "checking a diagonal");
  check(VecGetArrayRead(diagonal, &values), "checking a diagonal");
  PetscObjectGetComm(reinterpret_cast<PetscObject>(M), &comm);
  on_all_ranks(comm, [&] {
    for (PetscInt i = 0; i < own.size(); ++i)
      if (values[i] < 0)
        throw InputError(place + ": " + std::to_string(values[i]) + " on the diagonal of row " +
                         std::to_string(own.begin + i) + "; " + wanted + " is wanted");
  });
  check(VecRestoreArrayRead(diagonal, &values), "checking a diagonal");
}

UniqueVec distribute(MPI_Comm comm, PetscInt n, Range own, const std::vector<double> &values) {
  UniqueVec v;
  check(VecCreateMPI(comm, own.size(), n, v.out()), "creating a vector");
  double *array;
  check(VecGetArrayWrite(v, &array), "filling a vector");
  std::copy(values.begin(), values.end(), array);
  check(VecRestoreArrayWrite(v, &array), "filling a vector");
  return v;
}

} // namespace

ModelHeader read_model_header(const std::filesystem::path &path) {
  const h5::Reader file(path);
  check_format(file, path);
  ModelHeader header;
  if (const std::string units = file.text_attribute("units"); !units.empty()) header.units = units;
  header.dofs = matrix_size(file, "/K");
  const Extent entries = file.extent("/K/data");
  if (entries.size() != 1) throw InputError(file.place("/K/data") + ": one list of values is wanted");
  header.nonzeros = static_cast<double>(entries[0]);
  header.sectors = sectors_of_model(file);
  header.points =
      header.sectors > 0 ? sector_points(file) : static_cast<PetscInt>(read_contact_dofs(file, header.dofs).size());
  header.contact = read_contact(file);
  header.forces = pattern_names(file);
  header.has_c = file.has("/C"), header.has_structural = file.has("/K_structural");
  return header;
}

FullModel read_full_model(MPI_Comm comm, const std::filesystem::path &path) {
  FullModel model;
  model.comm = comm;
  model.file = path;
  std::vector<std::vector<double>> forces;
  std::vector<double> preload;
  Range own;
  bool has_c = false, has_structural = false;
  on_all_ranks(comm, [&] {
    const h5::Reader file(path);
    check_format(file, path);
    if (const std::string units = file.text_attribute("units"); !units.empty()) model.units = units;
    model.dofs = matrix_size(file, "/K");
    for (const char *name : {"/M", "/C", "/K_structural"}) {
      if (name != std::string("/M") && !file.has(name)) continue;
      if (const PetscInt other = matrix_size(file, name); other != model.dofs)
        throw InputError(file.place(name) + ": " + std::to_string(other) + " columns where /K has " +
                         std::to_string(model.dofs));
    }
    has_c = file.has("/C"), has_structural = file.has("/K_structural");
    own = own_share(comm, model.dofs);
    model.cyclic = read_cyclic_sector(file, model.dofs);
    if (model.cyclic.sectors == 0) model.contact_dofs = read_contact_dofs(file, model.dofs);
    model.contact = read_contact(file);
    for (const std::string &name : pattern_names(file)) {
      model.forces.push_back({name, {}});
      forces.push_back(read_vector(file, place_of_pattern(name), model.dofs, own));
    }
    preload = read_vector(file, "/preload", model.dofs, own);
  });
  const auto matrix = [&](const std::string &name, std::uint64_t kind, bool drop_zeros) {
    Rows rows;
    on_all_ranks(comm, [&] { rows = read_rows(h5::Reader(path), name, model.dofs, own, kind, drop_zeros); });
    model.hash += rows.hash;
    UniqueMat A = assemble(comm, model.dofs, own, rows);
    check_symmetry(A, own, path.string() + ": " + name);
    return A;
  };
  model.K = matrix("/K", 1, false); // a node's dofs keep the same columns: see the partition
  model.M = matrix("/M", 2, true);  // of solid elements two thirds of it are zeros
  check_diagonal(model.M, own, path.string() + ": /M", "a positive definite mass");
  if (has_c) {
    model.C = matrix("/C", 6, true);
    check_diagonal(model.C, own, path.string() + ": /C", "damping that gives no energy");
  }
  if (has_structural) {
    model.K_structural = matrix("/K_structural", 7, true);
    check_diagonal(model.K_structural, own, path.string() + ": /K_structural", "a stiffness");
  }
  for (PetscInt i = 0; i < own.size(); ++i) model.hash += entry_hash(4, own.begin + i, 0, preload[i]);
  for (std::size_t j = 0; j < forces.size(); ++j) {
    const std::uint64_t name = name_hash(model.forces[j].name);
    for (PetscInt i = 0; i < own.size(); ++i) model.hash += entry_hash(3, own.begin + i, name, forces[j][i]);
  }
  MPI_Allreduce(MPI_IN_PLACE, &model.hash, 1, MPI_UINT64_T, MPI_SUM, comm);
  model.hash += model.cyclic.hash;
  for (std::size_t p = 0; p < model.contact_dofs.size(); ++p)
    for (int d = 0; d < 3; ++d) model.hash += entry_hash(5, 3 * p + d, model.contact_dofs[p][d], 0);
  for (std::size_t j = 0; j < forces.size(); ++j) model.forces[j].values = distribute(comm, model.dofs, own, forces[j]);
  model.preload = distribute(comm, model.dofs, own, preload);
  return model;
}

} // namespace dovetail
