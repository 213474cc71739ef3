#include "results/results_file.hpp"

#include <algorithm>
#include <cmath>

#include "support/version.hpp"

namespace dovetail {
namespace {

int rank_of(MPI_Comm comm) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  return rank;
}

// Own contact points' numbers, written as datasets of N_x rows by rank 0.
template <class Pick>
void write_points(MPI_Comm comm, h5::Writer *file, const std::string &name, std::size_t points, int columns,
                  Pick &&pick) {
  std::vector<double> own;
  for (std::size_t p = 0; p < points; ++p)
    for (int d = 0; d < columns; ++d) own.push_back(pick(p, d));
  const auto all = gather(comm, own);
  if (!file) return;
  const hsize_t rows = all.size() / columns;
  if (columns == 1)
    file->rows(name, {rows}, 0, rows, all.data());
  else
    file->rows(name, {rows, hsize_t(columns)}, 0, rows, all.data());
}

void write_laws(MPI_Comm comm, h5::Writer *file, const std::vector<ContactPoint> &contact) {
  std::vector<double> own;
  for (const ContactPoint &point : contact) own.push_back(static_cast<int>(point.law));
  const auto all = gather(comm, own);
  const std::vector<long> numbers(all.begin(), all.end());
  if (file) file->rows("/contact/law", {numbers.size()}, 0, numbers.size(), numbers.data());
}

// Energies come in scaled units, force times displacement (theory.md, section 7), and leave in the user's.
ContactRecord collect_contact(const Layout &layout, const Scales &scales, const std::vector<Activity> &activity) {
  const double energy = std::pow(scales.modal * scales.frequency, 2);
  std::vector<double> own;
  for (const Activity &did : activity)
    own.insert(own.end(), {did.stick(), did.slip, did.open, energy * did.dissipation, double(did.events)});
  const std::vector<double> all = gather(layout.comm, own); // (N_x, 5) on rank 0
  ContactRecord record;
  for (std::size_t i = 0; i < all.size(); i += 5) {
    record.stick.push_back(all[i]);
    record.slip.push_back(all[i + 1]);
    record.open.push_back(all[i + 2]);
    record.dissipation.push_back(all[i + 3]);
    record.events.push_back(static_cast<int>(all[i + 4]));
  }
  return record;
}

} // namespace

PointRecord collect(const HarmonicSystem &system, const BranchPoint &point, double seconds) {
  const Layout &layout = system.layout();
  PointRecord record;
  record.omega = point.omega * system.scales().frequency;
  record.arclength = point.arclength;
  record.newton = point.newton.newton, record.linear = point.newton.linear;
  record.residual = point.newton.residual;
  record.seconds = seconds;
  record.progress = point.progress;
  record.contact = collect_contact(layout, system.scales(), point.activity);
  for (std::size_t p = 0; p < record.contact.open.size(); ++p)
    ++(record.contact.open[p] > 0 ? record.open : record.contact.slip[p] > 0 ? record.slip : record.stick);
  for (double *share : {&record.stick, &record.slip, &record.open}) *share /= std::max<double>(1, layout.points);
  record.coefficients = physical_coefficients(layout, system.scales(), point.y);
  return record;
}

ResultsFile::ResultsFile(const std::filesystem::path &path, const Case &study, const std::filesystem::path &reduced,
                         const PreloadedModel &preloaded)
    : comm_(preloaded.reduced.comm) {
  const ReducedModel &model = preloaded.reduced;
  std::filesystem::path partial = path;
  partial += ".partial"; // takes its name once it can be opened
  on_all_ranks(comm_, [&] {
    if (rank_of(comm_) != 0) return;
    file_ = std::make_unique<h5::Writer>(partial);
    file_->attribute("format", "dovetail-results");
    file_->attribute("version", 1);
    file_->attribute("program", std::string("dovetail ") + version + " " + git_revision);
    char library[256];
    check(PetscGetVersion(library, sizeof library), "asking PETSc its version");
    file_->attribute("petsc", library);
    check(SlepcGetVersion(library, sizeof library), "asking SLEPc its version");
    file_->attribute("slepc", library);
    int size;
    MPI_Comm_size(comm_, &size);
    file_->attribute("ranks", size);
    file_->attribute("title", study.title);
    file_->attribute("case", study.text);
    file_->attribute("units", model.units);
    file_->attribute("reduced", reduced.string());
    file_->attribute("harmonics", study.harmonics);
    file_->attribute("samples", study.samples);
    file_->attribute("modes", model.modes);
    file_->attribute("contact_points", model.points);
  });
  h5::Writer *file = file_.get();
  const auto &contact = preloaded.contact;
  const auto &rest = preloaded.standstill;
  const std::size_t own = contact.size();
  write_laws(comm_, file, contact);
  write_points(comm_, file, "/contact/normal_stiffness", own, 1, [&](auto p, int) { return contact[p].kn; });
  write_points(comm_, file, "/contact/tangential_stiffness", own, 2, [&](auto p, int d) { return contact[p].kt[d]; });
  write_points(comm_, file, "/contact/friction", own, 2, [&](auto p, int d) { return contact[p].mu[d]; });
  write_points(comm_, file, "/contact/gap", own, 1, [&](auto p, int) { return contact[p].gap; });
  write_points(comm_, file, "/preload/xp", 3 * own, 1, [&](auto i, int) { return rest[i / 3].x[i % 3]; });
  write_points(comm_, file, "/preload/g", 3 * own, 1, [&](auto i, int) { return rest[i / 3].force[i % 3]; });
  write_points(comm_, file, "/preload/w", own, 2, [&](auto p, int d) { return rest[p].w[d]; });
  on_all_ranks(comm_, [&] {
    if (!file) return;
    const hsize_t dofs = model.modes + model.contact_dofs(), width = coefficient_count(study.harmonics);
    const hsize_t points = model.points;
    chunk_rows_ = std::clamp<hsize_t>((1 << 18) / (8 * dofs * width), 1, 256); // coefficients: chunks of about 256 KiB
    chunk_bytes_ = chunk_rows_ * (8 * dofs * width + (4 * 8 + sizeof(int)) * points);
    const auto table = [&](const std::string &name, const h5::Extent &row, hid_t type, hsize_t chunk) {
      tables_.emplace_back(*file, "/points/" + name, row, type, chunk);
    };
    table("coefficients", {dofs, width}, H5T_NATIVE_DOUBLE, chunk_rows_); // the order of append() below
    for (const char *name : {"omega", "arclength", "residual", "seconds", "stick", "slip", "open"})
      table(name, {}, H5T_NATIVE_DOUBLE, 256);
    for (const char *name : {"newton_iterations", "linear_iterations"}) table(name, {}, H5T_NATIVE_INT, 256);
    if (points > 0) { // HDF5 has no chunks of nothing
      for (const char *name : {"stick", "slip", "open", "dissipation"})
        table(std::string("contact/") + name, {points}, H5T_NATIVE_DOUBLE, chunk_rows_);
      table("contact/events", {points}, H5T_NATIVE_INT, chunk_rows_);
    }
    file->flush();
    std::filesystem::rename(partial, path);
  });
}

void ResultsFile::append(const PointRecord &point) {
  on_all_ranks(comm_, [&] {
    if (!file_) return;
    constexpr hsize_t rest = 1 << 16; // chunks of the other tables, and what HDF5 needs to find them again
    if (points_++ % chunk_rows_ == 0) file_->reserve(chunk_bytes_ + rest);
    const void *rows[] = {point.coefficients.data(),
                          &point.omega,
                          &point.arclength,
                          &point.residual,
                          &point.seconds,
                          &point.stick,
                          &point.slip,
                          &point.open,
                          &point.newton,
                          &point.linear,
                          point.contact.stick.data(),
                          point.contact.slip.data(),
                          point.contact.open.data(),
                          point.contact.dissipation.data(),
                          point.contact.events.data()};
    for (std::size_t i = 0; i < tables_.size(); ++i) tables_[i].append(rows[i]);
    file_->flush();
  });
}

} // namespace dovetail
