#pragma once
// summary.json beside the results, and the same in words at the end of a run.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "results/told.hpp"
#include "stuck/resonances.hpp"
#include "stuck/stuck_mode.hpp"
#include "support/stage.hpp"

namespace dovetail {

struct ReductionFigures {
  std::string ordering;
  double flops = 0;          ///< of one factorisation of K_ee
  double forecast_mib = 0;   ///< most memory this rank was expected to take
  double backward_error = 0; ///< of a solve with K_ee
  bool kept_psi = true;      ///< false: Psi was computed a block at a time
};

/// Something that the user should look at: a word for programs, and a sentence.
struct Warning {
  std::string kind, text;
};

/// Of a nonlinear mode, besides its curve.
struct ModeStory {
  int number = 0;        ///< of the stuck structure
  double omega = 0;      ///< of that [rad/s]
  Onset onset;           ///< [m kg^1/2]
  double omega_last = 0; ///< at the last point
  double ratio_most = 0; ///< largest damping ratio, and the amplitude there
  double amplitude_most = 0;
  double energy_error = 0; ///< largest of all points, as a damping ratio
  double force_level = 0;  ///< at the last point; infinite where the load does no work on the mode
};

/// What became of the branch.
struct BranchStory {
  BranchSummary summary;
  CurveRange range;
  double scale = 1;                ///< of its values
  double omega = 0;                ///< of a path [rad/s]
  std::vector<EventRecord> events; ///< on rank 0, as the rest of it
  std::vector<EstimateRecord> estimates;
  double tolerance = 0;                ///< asked for; 0: none
  double closed_contact_frequency = 0; ///< [rad/s], where estimates are large; 0: not asked for
  std::optional<ModeStory> mode;
  std::optional<Resonances> resonances; ///< nothing where they could not be computed
  std::vector<Warning> warnings;
  Told told;
  CurveEnds ends;
  int parts = 1; ///< how often the run was begun or continued
  double seconds_all_parts = 0;
};

/// An estimated error of which nothing follows but that the point means nothing.
constexpr double no_error = 0.1;

/// How a branch ended, as it stands in summary.json.
const char *name_of(BranchSummary::End end);

/// What a run amounts to; `branch` is null when only the reduction was wanted, `reduction` when none was made.
/// Collective: stages are collected from all ranks; rank 0 writes, unless `directory` is empty, and prints.
void write_summary(MPI_Comm comm, const std::filesystem::path &directory, const BranchStory *branch,
                   const Stages &stages, const ReductionFigures *reduction);

/// summary.json of a run that ended by an exception, unless it has been written. For one rank alone.
void note_failure(const std::filesystem::path &directory, const std::string &failure) noexcept;

} // namespace dovetail
