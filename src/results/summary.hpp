#pragma once
// summary.json beside the results, and the same in words at the end of a run.
#include <filesystem>
#include <string>

#include "continuation/branch.hpp"
#include "support/stage.hpp"

namespace dovetail {

struct ReductionFigures {
  std::string ordering;
  double flops = 0;          ///< of the factorisation of K_ee, over all ranks
  double forecast_mib = 0;   ///< most memory this rank was expected to take
  double backward_error = 0; ///< of a solve with K_ee
  bool kept_psi = true;      ///< false: Psi was computed a block at a time
};

/// What a run amounts to; `branch` is null when only the reduction was wanted, `reduction` when none was made.
/// Collective: stages are collected from all ranks; rank 0 writes and prints.
void write_summary(MPI_Comm comm, const std::filesystem::path &directory, const BranchSummary *branch,
                   double frequency_scale, const Stages &stages, const ReductionFigures *reduction);

/// summary.json of a run that ended by an exception, unless it has been written. For one rank alone.
void note_failure(const std::filesystem::path &directory, const std::string &failure) noexcept;

} // namespace dovetail
