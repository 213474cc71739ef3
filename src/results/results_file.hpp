#pragma once
// results.h5 (docs/files.md): every accepted point appended and flushed at once, in user units.
#include <memory>

#include "case/case.hpp"
#include "continuation/branch.hpp"
#include "results/gather.hpp"
#include "support/hdf5.hpp"

namespace dovetail {

/// What every contact point did over the period; (N_x,) each.
struct ContactRecord {
  std::vector<double> stick, slip, open; ///< shares of the period
  std::vector<double> dissipation;       ///< energy per period [J]
  std::vector<int> events;
};

/// What one line on the screen and one row of the file need of a point, complete on rank 0 only.
struct PointRecord {
  double omega = 0;     ///< [rad/s]
  double arclength = 0; ///< scaled
  int newton = 0, linear = 0;
  double residual = 0;                  ///< scaled
  double seconds = 0;                   ///< since the point before
  double stick = 0, slip = 0, open = 0; ///< shares of the contact points
  double progress = 0;
  ContactRecord contact;
  std::vector<double> coefficients; ///< (N_a + 3 N_x, 2H+1) [user units]
};

/// Collects a point from all ranks. Collective.
PointRecord collect(const HarmonicSystem &system, const BranchPoint &point, double seconds);

class ResultsFile {
public:
  /// `preloaded`: the model in user units. Opens the file on rank 0. Collective.
  ResultsFile(const std::filesystem::path &path, const Case &study, const std::filesystem::path &reduced,
              const PreloadedModel &preloaded);
  /// Writes one point and flushes. Rank 0 writes, all ranks learn of a failure. Collective.
  void append(const PointRecord &point);

private:
  MPI_Comm comm_;
  std::unique_ptr<h5::Writer> file_; // rank 0 only
  std::vector<h5::Table> tables_;
  hsize_t points_ = 0, chunk_rows_ = 1, chunk_bytes_ = 0; // of the tables whose rows grow with the model
};

} // namespace dovetail
