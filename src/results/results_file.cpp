#include "results/results_file.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <string>
#include <type_traits>
#include <utility>

namespace dovetail {
namespace {

// Device and number of a file; zeros where there is none.
std::pair<std::uintmax_t, std::uintmax_t> identity_of(const std::filesystem::path &path) {
  struct stat now {};
  if (stat(path.c_str(), &now) != 0) return {0, 0};
  return {now.st_dev, now.st_ino};
}

int rank_of(MPI_Comm comm) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  return rank;
}

} // namespace

ResultsFile::ResultsFile(const std::filesystem::path &path, const std::string &run, const Case &study,
                         const std::filesystem::path &reduced, const PreloadedModel &preloaded, const Kept &kept,
                         std::function<void()> make_room)
    : comm_(preloaded.reduced.comm), wave_(study.wave(preloaded.reduced.sectors)), path_(path), partial_(path),
      make_room_(std::move(make_room)), continued_(kept.points > 0), agreement_(comm_) {
  partial_ += ".partial";
  on_all_ranks(comm_, [&] {
    if (rank_of(comm_) != 0) return;
    file_ = std::make_unique<h5::Writer>(h5::Writer::that_survives(partial_));
    describe_run(run, study, reduced, preloaded.reduced);
  });
  write_model(preloaded);
  on_all_ranks(comm_, [&] {
    if (!file_) return;
    make_columns(study, preloaded.reduced);
    if (kept.points > 0) take_over(path, kept);
    file_->flush();
    identity_ = identity_of(partial_);
  });
}

ResultsFile::~ResultsFile() {
  agreement_.hold([&] { flush(); });
  std::error_code error;
  if (file_ && !named_) std::filesystem::remove(partial_, error);
}

void ResultsFile::take_name() {
  make_room_();
  std::filesystem::rename(partial_, path_);
  file_->was_renamed(path_);
  named_ = true;
}

bool ResultsFile::finish() {
  int named = 0;
  on_all_ranks(comm_, [&] {
    agreement_.hold([&] { flush(); });
    agreement_.rethrow();
    if (!file_) return;
    if (!named_ && (continued_ || !std::filesystem::exists(path_))) take_name();
    named = named_;
    columns_.clear(), event_columns_.clear(), sensitivity_columns_.clear(), indices_.reset();
    file_->flush();
    if (!named_) std::filesystem::remove(partial_);
    file_->close();
    file_.reset();
    if (named_ && identity_of(path_) != identity_)
      throw ComputeError(path_.string() +
                         ": is not the file of this run any more: it was removed or replaced while the "
                         "run went on, and the points are lost with it");
  });
  MPI_Bcast(&named, 1, MPI_INT, 0, comm_);
  return named != 0;
}

void ResultsFile::make_columns(const Case &study, const ReducedModel &model) {
  constexpr hsize_t short_rows = 256;
  const hsize_t dofs = model.modes + model.contact_dofs(), points = model.points;
  const hsize_t width = coefficient_count(study.harmonics);
  const hsize_t chunk = chunk_ = std::clamp<hsize_t>((1 << 18) / (8 * dofs * width), 1, short_rows); // about 256 KiB
  const auto real = [&](const std::string &name, double PointRecord::*value) {
    columns_.push_back({{*file_, "/points/" + name, {}, H5T_NATIVE_DOUBLE, short_rows},
                        [=](const PointRecord &point) -> const void * { return &(point.*value); }});
  };
  const auto whole = [&](const std::string &name, int PointRecord::*value) {
    columns_.push_back({{*file_, "/points/" + name, {}, H5T_NATIVE_INT, short_rows},
                        [=](const PointRecord &point) -> const void * { return &(point.*value); }});
  };
  const auto per_contact = [&](const std::string &name, hid_t type, auto ContactRecord::*values) {
    columns_.push_back({{*file_, "/points/contact/" + name, {points}, type, chunk},
                        [=](const PointRecord &point) -> const void * { return (point.contact.*values).data(); }});
  };
  columns_.push_back({{*file_, "/points/coefficients", {dofs, width}, H5T_NATIVE_DOUBLE, chunk, true},
                      [](const PointRecord &point) -> const void * { return point.coefficients.data(); }});
  if (!study.mode) {
    columns_.push_back({{*file_, "/points/tangent", {dofs, width}, H5T_NATIVE_DOUBLE, chunk, true},
                        [](const PointRecord &point) -> const void * { return point.tangent.data(); }});
    wide_ = columns_.size();
    real("tangent_parameter", &PointRecord::tangent_parameter);
  }
  if (points > 0) { // HDF5 has no chunks of nothing
    per_contact("stick", H5T_NATIVE_DOUBLE, &ContactRecord::stick);
    per_contact("slip", H5T_NATIVE_DOUBLE, &ContactRecord::slip);
    per_contact("open", H5T_NATIVE_DOUBLE, &ContactRecord::open);
    per_contact("dissipation", H5T_NATIVE_DOUBLE, &ContactRecord::dissipation);
    per_contact("events", H5T_NATIVE_INT, &ContactRecord::events);
  }
  if (study.stability.value_or(false)) {
    whole("stable", &PointRecord::stable);
    whole("instability", &PointRecord::instability);
    real("multiplier", &PointRecord::multiplier);
  }
  if ((estimated_ = study.estimates)) {
    real("error_harmonics", &PointRecord::harmonics_error);
    real("error_sampling", &PointRecord::sampling_error);
    real("error_between", &PointRecord::between_error);
    if ((modes_estimated_ = !model.left_out.squares.empty())) real("error_modes", &PointRecord::modes_error);
  }
  whole("harmonics", &PointRecord::harmonics);
  whole("located", &PointRecord::located);
  whole("newton_iterations", &PointRecord::newton);
  whole("linear_iterations", &PointRecord::linear);
  real("arclength", &PointRecord::arclength);
  real("residual", &PointRecord::residual);
  real("seconds", &PointRecord::seconds);
  real("stick", &PointRecord::stick);
  real("slip", &PointRecord::slip);
  real("open", &PointRecord::open);
  over_path_ = !study.range().is_sweep();
  if (study.path) real("parameter", &PointRecord::parameter);
  if (study.follows_peaks()) {
    real("tracked_amplitude", &PointRecord::tracked);
    real("tangent_omega", &PointRecord::tangent_omega);
  }
  if (study.mode) {
    real("damping_ratio", &PointRecord::damping_ratio);
    real("friction_energy", &PointRecord::friction_energy);
    real("force_level", &PointRecord::force_level);
    real("energy_error", &PointRecord::energy_error);
    real("modal_amplitude", &PointRecord::parameter);
  }
  real("omega", &PointRecord::omega); // grows last: who sees a frequency finds all that belongs to it

  const auto event = [&](const std::string &name, hid_t type, auto EventRecord::*value) {
    event_columns_.push_back({{*file_, "/events/" + name, {}, type, short_rows},
                              [=](const EventRecord &record) -> const void * { return &(record.*value); }});
  };
  event("kind", H5T_NATIVE_INT, &EventRecord::kind);
  event("point", H5T_NATIVE_INT, &EventRecord::point);
  event("amplitude", H5T_NATIVE_DOUBLE, &EventRecord::amplitude);
  event("unknown", H5T_NATIVE_INT, &EventRecord::unknown);
  if (over_path_) event("parameter", H5T_NATIVE_DOUBLE, &EventRecord::parameter);
  event("omega", H5T_NATIVE_DOUBLE, &EventRecord::omega);
  if (study.sensitivity) make_sensitivity_columns(points);
  std::string names;
  for (const char *name : event_names()) names += (names.empty() ? "" : " ") + std::string(name);
  file_->attribute("names", names, "/events/kind");
}

void ResultsFile::make_sensitivity_columns(hsize_t points) {
  constexpr hsize_t few = 16; // peaks
  const auto column = [&](const std::string &name, const h5::Extent &row, hid_t type, auto &&value) {
    sensitivity_columns_.push_back({{*file_, "/sensitivity/" + name, row, type, few}, value});
  };
  using Record = const SensitivityRecord &;
  const std::pair<const char *, SlopeRecord SensitivityRecord::*> of[] = {
      {"amplitude_by/", &SensitivityRecord::amplitude_by}, {"omega_by/", &SensitivityRecord::omega_by}};
  for (const auto &[folder, slope] : of) {
    const auto number = [&, slope = slope, folder = folder](const char *name, double SlopeRecord::*value) {
      column(std::string(folder) + name, {}, H5T_NATIVE_DOUBLE,
             [=](Record r) -> const void * { return &(r.*slope.*value); });
    };
    const auto list = [&, slope = slope, folder = folder](const char *name, std::vector<double> SlopeRecord::*values,
                                                          const h5::Extent &row) {
      if (points > 0)
        column(std::string(folder) + name, row, H5T_NATIVE_DOUBLE,
               [=](Record r) -> const void * { return (r.*slope.*values).data(); });
    };
    list("normal_stiffness", &SlopeRecord::normal_stiffness, {points});
    list("tangential_stiffness", &SlopeRecord::tangential_stiffness, {points, 2});
    list("friction", &SlopeRecord::friction, {points, 2});
    list("gap", &SlopeRecord::gap, {points});
    number("force", &SlopeRecord::force);
    number("preload", &SlopeRecord::preload);
    number("damping", &SlopeRecord::damping);
  }
  column("point", {}, H5T_NATIVE_INT, [](Record r) -> const void * { return &r.point; });
  column("amplitude", {}, H5T_NATIVE_DOUBLE, [](Record r) -> const void * { return &r.amplitude; });
  column("omega", {}, H5T_NATIVE_DOUBLE, [](Record r) -> const void * { return &r.omega; });
}

void ResultsFile::append(const SensitivityRecord &peak) {
  agreement_.hold([&] {
    if (!file_) return;
    flush();
    for (auto &column : sensitivity_columns_) column.table.append(column.value(peak));
    file_->flush();
  });
}

void ResultsFile::take_over(const std::filesystem::path &path, const Kept &kept) {
  const h5::Reader old(path);
  const auto copy = [&](h5::Table &table, hsize_t rows) {
    const h5::Extent extent = old.extent(table.name()), &wanted = table.row();
    hsize_t row = 1, block = 1;
    bool fits = extent.size() == wanted.size() + 1;
    for (std::size_t i = 1; i < extent.size(); ++i) {
      row *= extent[i];
      fits = fits && (extent[i] == wanted[i - 1] || (i == 2 && extent[i] > wanted[i - 1])); // more harmonics
    }
    if (!fits) throw InputError(old.place(table.name()) + ": of another shape; begin anew without --restart");
    block = std::max<hsize_t>(1, (1 << 20) / row);
    if (extent.size() == 3 && extent.back() > table.width()) widen(extent.back());
    for (hsize_t done = 0; done < rows; done += block) {
      h5::Extent offset(extent.size(), 0), count = extent;
      offset[0] = done, count[0] = std::min(block, rows - done);
      const hsize_t width = extent.size() == 3 ? extent.back() : 0;
      if (table.type() == H5T_NATIVE_INT) {
        const auto values = old.integers(table.name(), offset, count);
        const std::vector<int> numbers(values.begin(), values.end());
        table.append(numbers.data(), count[0], width);
      } else {
        table.append(old.doubles(table.name(), offset, count).data(), count[0], width);
      }
      file_->flush(); // what is not flushed is in memory
    }
  };
  for (auto &column : columns_) copy(column.table, kept.points);
  for (auto &column : event_columns_) copy(column.table, kept.events);
  if (!sensitivity_columns_.empty()) {
    hsize_t peaks = 0; // of points that are kept
    const h5::Extent all = old.extent("/sensitivity/point");
    for (const auto point : old.integers("/sensitivity/point", {0}, all)) peaks += hsize_t(point) < kept.points;
    for (auto &column : sensitivity_columns_) copy(column.table, peaks);
  }
  if (estimated_) {
    const h5::Extent first{0}, points{kept.points};
    const auto at = old.doubles("/points/omega", first, points),
               harmonics = old.doubles("/points/error_harmonics", first, points),
               sampling = old.doubles("/points/error_sampling", first, points),
               modes = modes_estimated_ ? old.doubles("/points/error_modes", first, points)
                                        : std::vector<double>(kept.points, 0.0),
               between = old.doubles("/points/error_between", first, points),
               parameter = over_path_ ? old.doubles("/points/parameter", first, points) : at,
               open = old.doubles("/points/open", first, points);
    for (hsize_t i = 0; i < kept.points; ++i)
      estimates_.push_back({at[i], harmonics[i], sampling[i], modes[i], between[i], parameter[i], open[i]});
  }
  const h5::Extent from{0}, count{kept.events};
  const auto kinds = old.integers("/events/kind", from, count), at = old.integers("/events/point", from, count),
             unknowns = old.integers("/events/unknown", from, count);
  const auto omegas = old.doubles("/events/omega", from, count),
             amplitudes = old.doubles("/events/amplitude", from, count),
             parameters = over_path_ ? old.doubles("/events/parameter", from, count) : omegas;
  for (hsize_t i = 0; i < kept.events; ++i)
    events_.push_back({static_cast<int>(kinds[i]), static_cast<int>(at[i]), omegas[i], amplitudes[i],
                       static_cast<int>(unknowns[i]), parameters[i]});
  events_written_ = events_.size();
}

void ResultsFile::widen(hsize_t width) {
  for (std::size_t i = 0; i < wide_; ++i) columns_[i].table.widen(width);
  if (indices_) index_harmonics(static_cast<int>(indices_->rows()), static_cast<int>(width / 2));
  file_->flush(); // the attribute is never ahead of the tables
  file_->attribute("harmonics", static_cast<long>(width / 2));
}

// Rows from `first` on, each table's in one piece.
template <class Record, class Records>
void ResultsFile::append_rows(std::vector<Column<Record>> &columns, const Records &records, std::size_t first) {
  const std::size_t count = records.size() - first;
  if (count == 0) return;
  std::vector<unsigned char> block;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    h5::Table &table = columns[i].table;
    hsize_t width = 0;
    if constexpr (std::is_same_v<Record, PointRecord>)
      if (i < wide_) width = coefficient_count(records.back().harmonics);
    const std::size_t bytes = table.bytes_of_row(width);
    block.clear();
    for (std::size_t row = first; row < records.size(); ++row) {
      const auto *value = static_cast<const unsigned char *>(columns[i].value(records[row]));
      block.insert(block.end(), value, value + bytes);
    }
    table.append(block.data(), count, width);
  }
}

void ResultsFile::flush() {
  if (told_.empty()) return;
  if (!points_.empty()) {
    const hsize_t width = coefficient_count(points_.back().harmonics);
    if (width > columns_.front().table.width()) widen(width);
  }
  append_rows(columns_, points_, 0);
  append_rows(event_columns_, events_, events_written_);
  file_->flush();
  if (!named_ && !points_.empty()) take_name();
  for (const auto &tell : told_) tell();
  points_.clear(), told_.clear();
  events_written_ = events_.size(), written_ = MPI_Wtime();
}

void ResultsFile::wait_or_flush() {
  constexpr double moment = 0.05; // [s]: much more than writing takes, and less than a person notices
  const hsize_t rows = columns_.front().table.rows() + points_.size();
  if (!named_ || rows % chunk_ == 0 || MPI_Wtime() - written_ > moment) flush(); // the next chunk may find no room
}

void ResultsFile::append(PointRecord point, std::function<void(const PointRecord &)> told) {
  agreement_.hold([&] {
    if (!file_) return;
    if (!points_.empty() && points_.back().harmonics != point.harmonics) flush(); // rows of a block are of one width
    if (estimated_)
      estimates_.push_back({point.omega, point.harmonics_error, point.sampling_error, point.modes_error,
                            point.between_error, point.parameter, point.open});
    points_.push_back(std::move(point));
    told_.push_back([told = std::move(told), &row = points_.back()] { told(row); });
    wait_or_flush();
  });
}

void ResultsFile::append(const EventRecord &event, std::function<void()> told) {
  agreement_.hold([&] {
    if (!file_) return;
    events_.push_back(event);
    told_.push_back(std::move(told));
    wait_or_flush();
  });
}

} // namespace dovetail
