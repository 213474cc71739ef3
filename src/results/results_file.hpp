#pragma once
// results.h5 (docs/reference/files.md): every accepted point, in user units. The file opens at any moment, with every
// point that was told of and every one that a saved state counts.
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "case/case.hpp"
#include "case/travelling_wave.hpp"
#include "results/point_record.hpp"
#include "results/sensitivity_record.hpp"
#include "stuck/sector_frequencies.hpp"
#include "stuck/stuck_mode.hpp"
#include "support/agreement.hpp"
#include "support/hdf5.hpp"

namespace dovetail {

/// Throws InputError unless these are results, of the version that this program reads.
void check_format(const h5::Reader &results);

class ResultsFile {
public:
  /// What a continued run keeps of the file that it finds.
  struct Kept {
    hsize_t points = 0, events = 0;
  };

  /// Opens the file on rank 0; what is kept is copied from the file of that name, which stays until the new one has a
  /// first point of its own and takes its place. `make_room` is called just before that, on rank 0. `run`: its
  /// name. `preloaded`: the model in user units. Collective.
  ResultsFile(const std::filesystem::path &path, const std::string &run, const Case &study,
              const std::filesystem::path &reduced, const PreloadedModel &preloaded, const Kept &kept,
              std::function<void()> make_room);
  /// Writes what still waits. Without a first point: the file goes again where an earlier one is in its place.
  ~ResultsFile();
  /// Points and events that come within a moment are written together, what took longer at once. `told` is called on
  /// rank 0, which writes, once it is in the file. All ranks learn of a failure when they agree.
  void append(PointRecord point, std::function<void(const PointRecord &)> told);
  void append(const EventRecord &event, std::function<void()> told);
  /// Writes what waits, before something that counts on it. Rank 0 alone, or nothing; throws.
  void flush();
  /// By which failures of this file are told, and of what is written beside it.
  Agreement &agreement() { return agreement_; }
  /// Of a nonlinear mode, the one of the stuck structure that it begins with. Collective.
  void describe(const StuckMode &mode);
  /// Of a cyclic sector, frequencies of its structure with the closed points stuck. Collective.
  void describe(const SectorFrequencies &stuck);
  void append(const SensitivityRecord &peak); ///< likewise, at once
  /// Closes the file. Returns whether it has its name: not so if it has no point and there is an earlier file, which
  /// then stays. Collective.
  bool finish();
  /// All events so far, those of earlier parts of the run included; on rank 0 only.
  const std::vector<EventRecord> &events() const { return events_; }
  /// Likewise the estimated errors of all points; empty where none are estimated.
  const std::vector<EstimateRecord> &estimates() const { return estimates_; }

private:
  template <class Record> struct Column {
    h5::Table table;
    std::function<const void *(const Record &)> value;
  };
  void describe_run(const std::string &run, const Case &study, const std::filesystem::path &reduced,
                    const ReducedModel &model);
  void write_model(const PreloadedModel &preloaded); // collective
  void make_columns(const Case &study, const ReducedModel &model);
  void make_sensitivity_columns(hsize_t points);
  void take_over(const std::filesystem::path &path, const Kept &kept);
  void widen(hsize_t width);
  void index_harmonics(int first, int last);
  void take_name();
  void wait_or_flush();
  template <class Record, class Records>
  void append_rows(std::vector<Column<Record>> &columns, const Records &records, std::size_t first);

  MPI_Comm comm_;
  TravellingWave wave_;                  // of a sector
  std::filesystem::path path_, partial_; // its name, and the one it has before a first point
  std::function<void()> make_room_;
  bool continued_, named_ = false;
  std::pair<std::uintmax_t, std::uintmax_t> identity_; // of the file, whatever its name
  std::unique_ptr<h5::Writer> file_;                   // rank 0 only, as all that follows
  std::vector<Column<PointRecord>> columns_;           // coefficients first, then tangents of a response
  std::optional<h5::Table> indices_;                   // of a sector, of every harmonic
  std::vector<Column<EventRecord>> event_columns_;
  std::vector<Column<SensitivityRecord>> sensitivity_columns_; // if asked for
  std::deque<PointRecord> points_;                             // that wait to be written
  std::vector<EventRecord> events_;
  std::size_t events_written_ = 0;
  std::vector<std::function<void()>> told_; // of what waits, in the order it came
  double written_ = 0;                      // when [s]
  std::size_t wide_ = 1;                    // columns whose rows grow with the harmonics: the first
  hsize_t chunk_ = 1;                       // rows of these that HDF5 keeps together
  bool estimated_ = false, modes_estimated_ = false, over_path_ = false;
  std::vector<EstimateRecord> estimates_;
  Agreement agreement_;
};

} // namespace dovetail
