// What a results file says besides the points: the run, the model, a mode, frequencies of a sector.
#include "case/travelling_wave.hpp"
#include "results/results_file.hpp"
#include "support/version.hpp"

namespace dovetail {
namespace {

constexpr int version_of_format = 1; // to be raised whenever what is in the file means something else

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

} // namespace

void check_format(const h5::Reader &results) {
  if (const std::string format = results.text_attribute("format"); format != "dovetail-results")
    throw InputError(results.place("attribute format") + " is \"" + format + "\", \"dovetail-results\" wanted");
  if (const long found = results.integer_attribute("version", 1); found != version_of_format)
    throw InputError(results.place("attribute version") + " is " + std::to_string(found) +
                     "; this program reads version " + std::to_string(version_of_format) + " of the results format");
}

void ResultsFile::describe_run(const std::string &run, const Case &study, const std::filesystem::path &reduced,
                               const ReducedModel &model) {
  file_->attribute("format", "dovetail-results");
  file_->attribute("version", version_of_format);
  file_->attribute("run", run);
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
  file_->attribute("watch", study.watch.name);
  file_->attribute("reduced", reduced.string());
  file_->attribute("reduced_fingerprint", model.fingerprint);
  file_->attribute("harmonics", study.harmonics);
  file_->attribute("samples", study.samples);
  file_->attribute("modes", model.modes);
  file_->attribute("contact_points", model.points);
  if (wave_.sectors > 0) {
    file_->attribute("sectors", wave_.sectors);
    file_->attribute("engine_order", wave_.engine_order);
    indices_.emplace(*file_, "/cyclic/index", h5::Extent{}, H5T_NATIVE_INT, 64);
    index_harmonics(0, study.harmonics);
  }
  if (study.path) {
    file_->attribute("parameter", study.path->parameter->name);
    file_->attribute("parameter_unit", study.path->parameter->unit);
  }
  if (study.mode) {
    file_->attribute("parameter", "modal_amplitude");
    file_->attribute("parameter_unit", modal_amplitude().unit);
  }
}

void ResultsFile::index_harmonics(int first, int last) {
  for (int k = first; k <= last; ++k) {
    const int h = wave_.index(k);
    indices_->append(&h);
  }
}

void ResultsFile::write_model(const PreloadedModel &preloaded) {
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
}

void ResultsFile::describe(const StuckMode &mode) {
  std::vector<double> shape; // of a sector with the imaginary parts, dof by dof
  for (const auto *part : {&mode.modal, &mode.contact}) {
    std::vector<double> own;
    for (const std::complex<double> value : *part) {
      own.push_back(value.real());
      if (wave_.sectors > 0) own.push_back(value.imag());
    }
    const std::vector<double> all = gather(comm_, own);
    shape.insert(shape.end(), all.begin(), all.end());
  }
  on_all_ranks(comm_, [&] {
    if (!file_) return;
    file_->attribute("mode", mode.number);
    file_->rows("/mode/omega", {1}, 0, 1, &mode.omega);
    file_->rows("/mode/onset", {1}, 0, 1, &mode.onset.amplitude);
    const h5::Extent extent = wave_.sectors > 0 ? h5::Extent{shape.size() / 2, 2} : h5::Extent{shape.size()};
    file_->rows("/mode/shape", extent, 0, extent[0], shape.data());
    file_->flush();
  });
}

void ResultsFile::describe(const SectorFrequencies &stuck) {
  const hsize_t diameters = stuck.size(), count = stuck[0].size();
  std::vector<long> numbers;
  std::vector<double> flat;
  for (const std::vector<double> &of_one : stuck)
    numbers.push_back(static_cast<long>(numbers.size())), flat.insert(flat.end(), of_one.begin(), of_one.end());
  on_all_ranks(comm_, [&] {
    if (!file_) return;
    file_->rows("/cyclic/nodal_diameters", {diameters}, 0, diameters, numbers.data());
    file_->rows("/cyclic/frequencies", {diameters, count}, 0, diameters, flat.data());
    file_->flush();
  });
}

} // namespace dovetail
