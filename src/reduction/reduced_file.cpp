#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <limits>
#include <set>
#include <tuple>
#include <utility>

#include "reduction/reduced_model.hpp"
#include "reduction/sector_file.hpp"
#include "support/error.hpp"
#include "support/hdf5.hpp"
#include "support/version.hpp"

namespace dovetail {
namespace {

using h5::Extent;

constexpr hsize_t compared = 2048; // rows at a time, with their columns
constexpr int method = 5;          // to be raised whenever the reduction computes something else from the same model

std::string text_of(const Source &source) {
  char text[96];
  std::snprintf(text, sizeof text, "%016" PRIx64 " with %ld %s, method %d, motion ", source.hash,
                static_cast<long>(source.modes), source.kind == ModeKind::residual ? "modes with residuals" : "modes",
                method);
  const std::string shared =
      source.interior_modes > 0
          ? std::to_string(source.interior_modes) + (source.exact_modes ? " interior, exact, and what they leave out, "
                                                                        : " interior, and what they leave out, ")
          : "";
  return text + shared + source.motion + ", units " + source.units;
}

// Rows become columns: (m, n) row-major to (n, m).
std::vector<double> transposed(const std::vector<double> &A, hsize_t m, hsize_t n) {
  std::vector<double> out(A.size());
  for (hsize_t i = 0; i < m; ++i)
    for (hsize_t j = 0; j < n; ++j) out[j * m + i] = A[i * n + j];
  return out;
}

// (columns,) of one load pattern, as it always was, (L, columns) of several; this rank writes [first, first + count).
void write_by_pattern(h5::Writer &file, const std::string &name, const std::vector<std::vector<double>> &values,
                      hsize_t columns, hsize_t first, hsize_t count) {
  std::vector<double> flat;
  for (const auto &of_one : values) flat.insert(flat.end(), of_one.begin(), of_one.begin() + count);
  if (const hsize_t loads = values.size(); loads > 1)
    file.slab(name, {loads, columns}, {0, first}, {loads, count}, flat.data());
  else
    file.rows(name, {columns}, first, count, flat.data());
}

// Columns [first, first + count) of such a dataset, of each of the `loads` patterns.
std::vector<std::vector<double>> read_by_pattern(const h5::Reader &file, const std::string &name, hsize_t loads,
                                                 hsize_t first, hsize_t count) {
  const bool rows = file.extent(name).size() == 2;
  const std::vector<double> flat =
      rows ? file.doubles(name, {0, first}, {loads, count}) : file.doubles(name, {first}, {count});
  std::vector<std::vector<double>> values;
  for (hsize_t j = 0; j < loads; ++j) values.emplace_back(flat.begin() + j * count, flat.begin() + (j + 1) * count);
  return values;
}

// Of the load patterns, as many as /Fa has rows.
std::vector<std::string> names_of_patterns(const h5::Reader &file) {
  const Extent fa = file.extent("/Fa");
  const hsize_t loads = fa.size() == 2 ? fa[0] : 1;
  std::vector<std::string> names = file.words_attribute("force_names");
  if (names.empty() && loads == 1) names = {force_pattern};
  if (names.size() != loads)
    throw InputError(file.place("/") + ": attribute force_names has " + std::to_string(names.size()) +
                     " names where /Fa has " + std::to_string(loads) + " load patterns; a name for each is wanted");
  if (std::set<std::string>(names.begin(), names.end()).size() != loads)
    throw InputError(file.place("/") + ": attribute force_names has one name twice; another for each is wanted");
  return names;
}

} // namespace

std::string mass_not_positive(const std::filesystem::path &file) {
  return file.string() +
         ": the reduced mass matrix, [1, Max; Max^T, Mxx], is not positive definite. Every contact dof needs mass of "
         "its own: look for zeros on the diagonal of /M (or /Mxx), and for a mass that lost digits where it was "
         "condensed or written";
}

std::size_t ReducedModel::load(const std::string &name) const {
  std::string names;
  for (std::size_t j = 0; j < loads.size(); ++j) {
    if (loads[j].name == name) return j;
    names += (j > 0 ? ", \"" : "\"") + loads[j].name + '"';
  }
  throw InputError("load pattern \"" + name + "\": the reduced model has only " + names);
}

void write_reduced(const std::filesystem::path &path, const Source &source, const Reduction &reduction) {
  const ReducedModel &model = reduction.model;
  const Recovery &recovery = reduction.recovery;
  const hsize_t na = model.modes, nc = model.contact_dofs(), first = 3 * model.own_points.begin,
                rows = model.own_contact_dofs();
  std::filesystem::path partial = path;
  partial += ".partial"; // renamed when whole: a killed run leaves no half file behind
  {
    h5::Writer file(model.comm, partial);
    file.attribute("format", "dovetail-reduced");
    file.attribute("version", 1);
    file.attribute("source", text_of(source));
    file.attribute("fingerprint", model.fingerprint);
    file.attribute("units", model.units);
    file.attribute("model", source.file.string());
    file.attribute("program", std::string("dovetail ") + version + " " + git_revision);
    file.attribute("ordering", source.ordering);
    file.attribute("modes_counted", source.modes_counted);
    int rank;
    MPI_Comm_rank(model.comm, &rank);
    const hsize_t all = rank == 0 ? na : 0;
    file.rows("/Kaa", {na}, 0, all, model.kaa.data());
    std::vector<std::string> names;
    std::vector<std::vector<double>> fa, fx;
    for (const LoadPattern &load : model.loads)
      names.push_back(load.name), fa.push_back(load.fa), fx.push_back(load.fx);
    if (names != std::vector<std::string>{force_pattern}) file.attribute("force_names", names);
    write_by_pattern(file, "/Fa", fa, na, 0, all);
    file.rows("/Kxx", {nc, nc}, first, rows, model.kxx.data());
    file.rows("/Mxx", {nc, nc}, first, rows, model.mxx.data());
    write_by_pattern(file, "/Fx", fx, nc, first, rows);
    file.rows("/R", {nc}, first, rows, model.r.data());
    file.slab("/Max", {na, nc}, {0, first}, {na, rows}, transposed(model.mxa, rows, na).data());
    for (const auto &[letter, matrix] : {std::pair("C", &model.viscous), std::pair("S", &model.structural)}) {
      if (!matrix->given) continue;
      const std::string name = std::string("/") + letter;
      file.rows(name + "aa", {na, na}, 0, all, matrix->aa.data());
      file.slab(name + "ax", {na, nc}, {0, first}, {na, rows}, transposed(matrix->xa, rows, na).data());
      file.rows(name + "xx", {nc, nc}, first, rows, matrix->xx.data());
    }
    if (const LeftOut &left = model.left_out; !left.squares.empty()) {
      const hsize_t r = left.squares.size();
      file.rows("/left_out/Kaa", {r}, 0, rank == 0 ? r : 0, left.squares.data());
      write_by_pattern(file, "/left_out/Fa", left.loads, r, 0, rank == 0 ? r : 0);
      file.slab("/left_out/Max", {r, nc}, {0, first}, {r, rows}, transposed(left.coupling, rows, r).data());
      if (na > 0) file.rows("/left_out/Maa", {na, r}, 0, all, left.with_modes.data());
    }
    std::vector<long> contact;
    for (const auto &point : source.contact_dofs) contact.insert(contact.end(), point.begin(), point.end());
    file.rows("/recovery/contact_dofs", {nc / 3, 3}, 0, rank == 0 ? nc / 3 : 0, contact.data());
    if (const hsize_t points = source.area.size())
      file.rows("/contact/area", {points}, 0, rank == 0 ? points : 0, source.area.data());
    unsigned long long kept = recovery.elastic_dofs.size(), before = 0, total;
    MPI_Exscan(&kept, &before, 1, MPI_UNSIGNED_LONG_LONG, MPI_SUM, model.comm);
    MPI_Allreduce(&kept, &total, 1, MPI_UNSIGNED_LONG_LONG, MPI_SUM, model.comm);
    file.rows("/recovery/elastic_dofs", {total}, before, kept, recovery.elastic_dofs.data());
    file.rows("/recovery/xe0", {total}, before, kept, recovery.xe0.data());
    file.rows("/recovery/Phi", {total, na}, before, kept, recovery.phi.data());
    file.rows("/recovery/Psi", {total, nc}, before, kept, recovery.psi.data());
    if (model.sectors > 0) write_sectors(file, reduction, before, total);
    file.flush();
    file.close();
  }
  on_all_ranks(model.comm, [&] {
    int rank;
    MPI_Comm_rank(model.comm, &rank);
    if (rank == 0) std::filesystem::rename(partial, path);
  });
}

ReducedHeader read_reduced_header(const std::filesystem::path &path) {
  const h5::Reader file(path);
  const std::string format = file.text_attribute("format");
  if (format != "dovetail-reduced")
    throw InputError(path.string() + ": attribute format is \"" + format + "\", \"dovetail-reduced\" wanted" +
                     (format == "dovetail-model" ? "; name a full model with  model =  instead of  reduced =" : ""));
  if (const long found = file.integer_attribute("version", 1); found != 1)
    throw InputError(path.string() + ": version " + std::to_string(found) +
                     " of the reduced format; this program reads version 1");
  const auto want = [&](const std::string &name, const Extent &wanted, const std::string &meaning) {
    if (const Extent found = file.extent(name); found != wanted) {
      std::string shape;
      for (const hsize_t n : found) shape += (shape.empty() ? "" : ", ") + std::to_string(n);
      throw InputError(file.place(name) + ": shape (" + shape + ") where " + meaning + " is wanted");
    }
  };
  const Extent kaa = file.extent("/Kaa"), kxx = file.extent("/Kxx");
  if (kaa.size() != 1) throw InputError(file.place("/Kaa") + ": a list of the squared frequencies (N_a,) is wanted");
  if (kxx.size() != 2 || kxx[0] != kxx[1] || kxx[0] % 3 != 0)
    throw InputError(file.place("/Kxx") + ": a square matrix with three rows (t1, t2, n) per contact point is wanted");
  const hsize_t na = kaa[0], nc = kxx[0];
  if (na + nc == 0) throw InputError(path.string() + ": holds no mode and no contact point");
  if (std::max(na, nc) > hsize_t(std::numeric_limits<PetscInt>::max()))
    throw InputError(path.string() + ": more unknowns than 32-bit numbers can count");
  const std::string modes = "(" + std::to_string(na), contact = std::to_string(nc) + ")";
  want("/Max", {na, nc}, "(N_a, 3 N_x) = " + modes + ", " + contact);
  want("/Mxx", {nc, nc}, "(3 N_x, 3 N_x) = (" + std::to_string(nc) + ", " + contact);
  const std::vector<std::string> loads = names_of_patterns(file);
  if (file.extent("/Fa").size() == 2) {
    const std::string patterns = "(" + std::to_string(loads.size()) + ", ";
    want("/Fa", {loads.size(), na}, "(patterns, N_a) = " + patterns + std::to_string(na) + ")");
    want("/Fx", {loads.size(), nc}, "(patterns, 3 N_x) = " + patterns + contact);
  } else {
    want("/Fa", {na}, "(N_a,) = " + modes + ",)");
    want("/Fx", {nc}, "(3 N_x,) = (" + std::to_string(nc) + ",)");
  }
  want("/R", {nc}, "(3 N_x,) = (" + std::to_string(nc) + ",)");
  const auto has_damping = [&](const std::string &letter) {
    if (!file.has(letter + "aa") && !file.has(letter + "ax") && !file.has(letter + "xx")) return false;
    if (!file.has(letter + "aa") || file.extent(letter + "aa").size() != 1) // the diagonal will do
      want(letter + "aa", {na, na}, "(N_a, N_a) = " + modes + ", " + std::to_string(na) + "), or its diagonal (N_a,),");
    else
      want(letter + "aa", {na}, "(N_a,) = " + modes + ",)");
    if (file.has(letter + "ax")) want(letter + "ax", {na, nc}, "(N_a, 3 N_x) = " + modes + ", " + contact);
    if (file.has(letter + "xx"))
      want(letter + "xx", {nc, nc}, "(3 N_x, 3 N_x) = (" + std::to_string(nc) + ", " + contact);
    return true;
  };
  std::vector<double> area;
  if (file.has("/contact/area")) {
    want("/contact/area", {nc / 3}, "(N_x,) = (" + std::to_string(nc / 3) + ",)");
    area = file.doubles("/contact/area");
  }
  const std::string units = file.text_attribute("units");
  return {static_cast<PetscInt>(na),
          static_cast<PetscInt>(nc / 3),
          loads,
          has_damping("/C"),
          has_damping("/S"),
          area,
          units.empty() ? "SI" : units,
          sectors_in(file, na, nc, loads.size())};
}

ReducedModel read_reduced(MPI_Comm comm, const std::filesystem::path &path) {
  ReducedModel model;
  model.comm = comm;
  on_all_ranks(comm, [&] {
    const ReducedHeader header = read_reduced_header(path);
    model.modes = header.modes;
    model.points = header.points;
    model.own_modes = own_share(comm, model.modes);
    model.own_points = own_share(comm, model.points);
    const h5::Reader file(path);
    model.units = header.units;
    const hsize_t na = model.modes, nc = model.contact_dofs(), first = 3 * model.own_points.begin,
                  rows = model.own_contact_dofs();
    const auto finite = [&](const std::string &name, std::vector<double> values) {
      for (const double value : values)
        if (!std::isfinite(value))
          throw InputError(file.place(name) + ": " + std::to_string(value) + "; finite numbers are wanted");
      return values;
    };
    model.kaa = finite("/Kaa", file.doubles("/Kaa"));
    model.loads.clear();
    const auto fa = read_by_pattern(file, "/Fa", header.loads.size(), 0, na),
               fx = read_by_pattern(file, "/Fx", header.loads.size(), first, rows);
    for (std::size_t j = 0; j < fa.size(); ++j)
      model.loads.push_back({header.loads[j], finite("/Fa", fa[j]), finite("/Fx", fx[j])});
    for (const double square : model.kaa)
      if (!(square > 0))
        throw InputError(file.place("/Kaa") + ": " + std::to_string(square) +
                         "; squared frequencies above 0 are wanted");
    model.r = finite("/R", file.doubles("/R", {first}, {rows}));
    const auto contact_rows = [&](const std::string &name) {
      std::vector<double> own = finite(name, file.doubles(name, {first, 0}, {rows, nc}));
      double largest = 0;
      for (const double value : own) largest = std::max(largest, std::abs(value));
      for (hsize_t begin = 0; begin < nc; begin += compared) { // some of the columns at a time, for their memory
        const hsize_t count = std::min(compared, nc - begin);
        const auto columns = file.doubles(name, {begin, first}, {count, rows});
        for (hsize_t i = 0; i < rows; ++i)
          for (hsize_t j = 0; j < count; ++j)
            if (std::abs(own[i * nc + begin + j] - columns[j * rows + i]) > 1e-8 * largest)
              throw InputError(file.place(name) + ": not symmetric, row " + std::to_string(first + i) + ", column " +
                               std::to_string(begin + j) + " (of 0..)");
      }
      return own;
    };
    const auto modal_columns = [&](const std::string &name) {
      return transposed(finite(name, file.doubles(name, {0, first}, {na, rows})), na, rows);
    };
    model.kxx = contact_rows("/Kxx"), model.mxx = contact_rows("/Mxx");
    model.mxa = modal_columns("/Max");
    for (auto [letter, matrix, has] :
         {std::tuple("C", &model.viscous, header.has_c), std::tuple("S", &model.structural, header.has_structural)}) {
      if (!(matrix->given = has)) continue;
      const std::string name = std::string("/") + letter;
      matrix->aa = finite(name + "aa", file.doubles(name + "aa"));
      if (file.extent(name + "aa").size() == 1) {
        const std::vector<double> diagonal = std::exchange(matrix->aa, std::vector<double>(na * na));
        for (hsize_t j = 0; j < na; ++j) matrix->aa[j * na + j] = diagonal[j];
      }
      for (hsize_t i = 0; i < na; ++i)
        for (hsize_t j = 0; j < i; ++j)
          if (std::abs(matrix->aa[i * na + j] - matrix->aa[j * na + i]) >
              1e-8 * std::max(std::abs(matrix->aa[i * na + i]), std::abs(matrix->aa[j * na + j])))
            throw InputError(file.place(name + "aa") + ": not symmetric, row " + std::to_string(i) + ", column " +
                             std::to_string(j) + " (of 0..)");
      matrix->xa = file.has(name + "ax") ? modal_columns(name + "ax") : std::vector<double>(rows * na);
      matrix->xx = file.has(name + "xx") ? contact_rows(name + "xx") : std::vector<double>(rows * nc);
    }
    if (header.sectors > 0) read_sectors(file, header.sectors, model);
    if (!file.has("/left_out/Kaa")) return;
    LeftOut &left = model.left_out;
    left.squares = finite("/left_out/Kaa", file.doubles("/left_out/Kaa"));
    const hsize_t r = left.squares.size(), loads = header.loads.size();
    const Extent left_fa = file.extent("/left_out/Fa");
    if ((left_fa != Extent{loads, r} && (loads > 1 || left_fa != Extent{r})) ||
        file.extent("/left_out/Max") != Extent{r, nc})
      throw InputError(file.place("/left_out") + ": shapes (r,), (r,) and (r, 3 N_x) are wanted of Kaa, Fa and Max; "
                                                 "of several load patterns, (patterns, r) of Fa");
    for (auto &load : read_by_pattern(file, "/left_out/Fa", loads, 0, r))
      left.loads.push_back(finite("/left_out/Fa", std::move(load)));
    for (const double square : left.squares)
      if (!(square > 0)) throw InputError(file.place("/left_out/Kaa") + ": squared frequencies above 0 are wanted");
    if (na > 0) {
      left.with_modes = finite("/left_out/Maa", file.doubles("/left_out/Maa"));
      if (left.with_modes.size() != na * r)
        throw InputError(file.place("/left_out/Maa") + ": shape (N_a, r) is wanted");
    }
    left.coupling = transposed(finite("/left_out/Max", file.doubles("/left_out/Max", {0, first}, {r, rows})), r, rows);
  });
  model.fingerprint = fingerprint_of(model);
  on_all_ranks(comm, [&] {
    const std::string written = h5::Reader(path).text_attribute("fingerprint");
    model.as_written = written.empty() || written == model.fingerprint;
  });
  return model;
}

void check_replaceable(const std::filesystem::path &path) {
  if (!std::filesystem::exists(path)) return;
  bool foreign = false;
  try {
    foreign = h5::Reader(path).text_attribute("source").empty();
  } catch (const InputError &) { // damaged: nothing to lose
  }
  if (foreign)
    throw InputError(path.string() +
                     ": this file was not made by dovetail, but the reduced model is to be written there; move it "
                     "away, or name another folder with output.directory or --out");
}

bool matches(MPI_Comm comm, const std::filesystem::path &path, const Source &source) {
  int same = 0;
  try {
    on_all_ranks(comm, [&] {
      read_reduced_header(path);
      const h5::Reader file(path);
      same = file.text_attribute("source") == text_of(source) &&
             (!source.modes_counted || file.integer_attribute("modes_counted", 0) == 1);
    });
  } catch (const InputError &) { // absent, damaged or foreign: it will be written anew
    return false;
  }
  MPI_Allreduce(MPI_IN_PLACE, &same, 1, MPI_INT, MPI_LAND, comm); // a shared file system may show ranks different files
  return same != 0;
}

} // namespace dovetail
