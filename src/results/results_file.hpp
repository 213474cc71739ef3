#pragma once
// results.h5 (docs/reference/files.md): every accepted point appended and flushed at once, in user units. The file
// opens at any moment, with every point whose append has returned.
#include <functional>
#include <memory>

#include "case/case.hpp"
#include "results/point_record.hpp"
#include "support/hdf5.hpp"

namespace dovetail {

class ResultsFile {
public:
  /// What a continued run keeps of the file that it finds.
  struct Kept {
    hsize_t points = 0, events = 0;
  };

  /// Opens the file on rank 0; what is kept is copied from the file of that name, which stays until the new one is
  /// ready to take its place. `preloaded`: the model in user units. Collective.
  ResultsFile(const std::filesystem::path &path, const Case &study, const std::filesystem::path &reduced,
              const PreloadedModel &preloaded, const Kept &kept);
  /// Writes one point and flushes. Rank 0 writes, all ranks learn of a failure. Collective.
  void append(const PointRecord &point);
  void append(const EventRecord &event);
  /// All events so far, those of earlier parts of the run included; on rank 0 only.
  const std::vector<EventRecord> &events() const { return events_; }
  /// Likewise the estimated errors of all points; empty where none are estimated.
  const std::vector<EstimateRecord> &estimates() const { return estimates_; }

private:
  template <class Record> struct Column {
    h5::Table table;
    std::function<const void *(const Record &)> value;
  };
  void describe_run(const Case &study, const std::filesystem::path &reduced, const ReducedModel &model);
  void write_model(const PreloadedModel &preloaded); // collective
  void make_columns(const Case &study, const ReducedModel &model);
  void take_over(const std::filesystem::path &path, const Kept &kept);
  void widen(hsize_t width);

  MPI_Comm comm_;
  std::unique_ptr<h5::Writer> file_;         // rank 0 only, as all that follows
  std::vector<Column<PointRecord>> columns_; // coefficients first
  std::vector<Column<EventRecord>> event_columns_;
  std::vector<EventRecord> events_;
  bool estimated_ = false, modes_estimated_ = false;
  std::vector<EstimateRecord> estimates_;
};

} // namespace dovetail
