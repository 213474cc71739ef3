#include "reduction/sector_file.hpp"

#include <algorithm>
#include <cmath>

#include "model/cyclic_sector.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

using h5::Extent;
using Complex = std::complex<double>;

std::string group_of(int index) { return "/cyclic/" + std::to_string(index) + "/"; }

// As numbers of the file, whose last axis is real and imaginary part.
const double *parts(const std::vector<Complex> &values) { return reinterpret_cast<const double *>(values.data()); }

std::vector<Complex> read(const h5::Reader &file, const std::string &name, Extent offset, Extent count) {
  offset.push_back(0), count.push_back(2);
  const std::vector<double> flat = file.doubles(name, offset, count);
  std::vector<Complex> values(flat.size() / 2);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(flat[2 * i]) || !std::isfinite(flat[2 * i + 1]))
      throw InputError(file.place(name) + ": " + std::to_string(flat[2 * i]) + ", " + std::to_string(flat[2 * i + 1]) +
                       "; finite numbers are wanted");
    values[i] = {flat[2 * i], flat[2 * i + 1]};
  }
  return values;
}

std::vector<double> squares(const h5::Reader &file, const std::string &name) {
  const std::vector<double> values = file.doubles(name);
  for (const double square : values)
    if (!(square > 0) || !std::isfinite(square))
      throw InputError(file.place(name) + ": " + std::to_string(square) + "; squared frequencies above 0 are wanted");
  return values;
}

// (m, n) row-major to (n, m), each entry conjugated.
std::vector<Complex> adjoint(const std::vector<Complex> &A, hsize_t m, hsize_t n) {
  std::vector<Complex> out(A.size());
  for (hsize_t i = 0; i < m; ++i)
    for (hsize_t j = 0; j < n; ++j) out[j * m + i] = std::conj(A[i * n + j]);
  return out;
}

// Own rows of a Hermitian matrix of the contact dofs, checked against its columns.
std::vector<Complex> read_hermitian(const h5::Reader &file, const std::string &name, hsize_t first, hsize_t rows,
                                    hsize_t nc) {
  const std::vector<Complex> own = read(file, name, {first, 0}, {rows, nc}),
                             columns = read(file, name, {0, first}, {nc, rows});
  double largest = 0;
  for (const Complex value : own) largest = std::max(largest, std::norm(value));
  for (hsize_t i = 0; i < rows; ++i)
    for (hsize_t j = 0; j < nc; ++j)
      if (std::norm(own[i * nc + j] - std::conj(columns[j * rows + i])) > 1e-16 * largest)
        throw InputError(file.place(name) + ": not Hermitian, row " + std::to_string(first + i) + ", column " +
                         std::to_string(j) + " (of 0..)");
  return own;
}

} // namespace

int sectors_in(const h5::Reader &file, hsize_t modes, hsize_t nc, hsize_t loads) {
  const int sectors = sectors_of_model(file);
  const auto want = [&](const std::string &name, const Extent &wanted) {
    const Extent found = file.extent(name);
    if (found == wanted) return;
    std::string shape, meant;
    for (const hsize_t n : found) shape += (shape.empty() ? "" : ", ") + std::to_string(n);
    for (const hsize_t n : wanted) meant += (meant.empty() ? "" : ", ") + std::to_string(n);
    throw InputError(file.place(name) + ": shape (" + shape + ") where (" + meant + ") is wanted");
  };
  for (int h = 1; h <= sectors / 2; ++h) {
    const std::string group = group_of(h);
    if (!file.has(group.substr(0, group.size() - 1)))
      throw InputError(file.place("/cyclic") + ": index " + std::to_string(h) + " is missing; of " +
                       std::to_string(sectors) + " sectors a group for each of 1 to " + std::to_string(sectors / 2) +
                       " is wanted");
    want(group + "Kaa", {modes});
    want(group + "Max", {modes, nc, 2});
    for (const char *name : {"Mxx", "Kxx"}) want(group + name, {nc, nc, 2});
    want(group + "Fa", {loads, modes, 2}), want(group + "Fx", {loads, nc, 2});
    if (!file.has(group + "left_out/Kaa")) continue;
    const hsize_t r = file.extent(group + "left_out/Kaa").at(0);
    want(group + "left_out/Fa", {loads, r, 2}), want(group + "left_out/Max", {r, nc, 2});
    if (modes > 0) want(group + "left_out/Maa", {modes, r, 2});
  }
  return sectors;
}

void read_sectors(const h5::Reader &file, int sectors, ReducedModel &model) {
  const hsize_t na = model.modes, nc = model.contact_dofs(), first = 3 * model.own_points.begin,
                rows = model.own_contact_dofs();
  model.sectors = sectors;
  for (int h = 1; h <= sectors / 2; ++h) {
    const std::string group = group_of(h);
    SectorIndex index;
    index.kaa = squares(file, group + "Kaa");
    index.mxa = adjoint(read(file, group + "Max", {0, first}, {na, rows}), na, rows);
    index.mxx = read_hermitian(file, group + "Mxx", first, rows, nc);
    index.kxx = read_hermitian(file, group + "Kxx", first, rows, nc);
    for (hsize_t j = 0; j < model.loads.size(); ++j)
      index.loads.push_back(
          {read(file, group + "Fa", {j, 0}, {1, na}), read(file, group + "Fx", {j, first}, {1, rows})});
    if (const std::string beyond = group + "left_out/"; file.has(beyond + "Kaa")) {
      auto &left = index.left_out;
      left.squares = squares(file, beyond + "Kaa");
      const hsize_t r = left.squares.size();
      for (hsize_t j = 0; j < model.loads.size(); ++j) left.loads.push_back(read(file, beyond + "Fa", {j, 0}, {1, r}));
      left.coupling = adjoint(read(file, beyond + "Max", {0, first}, {r, rows}), r, rows);
      if (na > 0) left.with_modes = read(file, beyond + "Maa", {0, 0}, {na, r});
    }
    model.indices.push_back(std::move(index));
  }
}

void write_sectors(h5::Writer &file, const Reduction &reduction, hsize_t before, hsize_t total) {
  const ReducedModel &model = reduction.model;
  int rank;
  MPI_Comm_rank(model.comm, &rank);
  const hsize_t na = model.modes, nc = model.contact_dofs(), first = 3 * model.own_points.begin,
                rows = model.own_contact_dofs(), all = rank == 0 ? na : 0, loads = model.loads.size(),
                kept = reduction.recovery.elastic_dofs.size();
  for (std::size_t at = 0; at < model.indices.size(); ++at) {
    const SectorIndex &index = model.indices[at];
    const std::string group = group_of(static_cast<int>(at) + 1);
    file.rows(group + "Kaa", {na}, 0, all, index.kaa.data());
    file.slab(group + "Max", {na, nc, 2}, {0, first, 0}, {na, rows, 2}, parts(adjoint(index.mxa, rows, na)));
    file.rows(group + "Mxx", {nc, nc, 2}, first, rows, parts(index.mxx));
    file.rows(group + "Kxx", {nc, nc, 2}, first, rows, parts(index.kxx));
    for (hsize_t j = 0; j < loads; ++j)
      file.slab(group + "Fa", {loads, na, 2}, {j, 0, 0}, {1, all, 2}, parts(index.loads[j].fa));
    for (hsize_t j = 0; j < loads; ++j)
      file.slab(group + "Fx", {loads, nc, 2}, {j, first, 0}, {1, rows, 2}, parts(index.loads[j].fx));
    if (const auto &left = index.left_out; !left.squares.empty()) {
      const std::string beyond = group + "left_out/";
      const hsize_t r = left.squares.size();
      file.rows(beyond + "Kaa", {r}, 0, rank == 0 ? r : 0, left.squares.data());
      for (hsize_t j = 0; j < loads; ++j)
        file.slab(beyond + "Fa", {loads, r, 2}, {j, 0, 0}, {1, rank == 0 ? r : 0, 2}, parts(left.loads[j]));
      file.slab(beyond + "Max", {r, nc, 2}, {0, first, 0}, {r, rows, 2}, parts(adjoint(left.coupling, rows, r)));
      if (na > 0) file.slab(beyond + "Maa", {na, r, 2}, {0, 0, 0}, {all, r, 2}, parts(left.with_modes));
    }
    if (reduction.recovery.indices.empty()) continue;
    const Recovery::OfIndex &motion = reduction.recovery.indices[at];
    file.rows(group + "Phi", {total, na, 2}, before, kept, parts(motion.phi));
    file.rows(group + "Psi", {total, nc, 2}, before, kept, parts(motion.psi));
  }
  file.attribute("sectors", long(model.sectors), "/cyclic");
}

} // namespace dovetail
