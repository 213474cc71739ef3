#pragma once
// summary.json beside the results, and the same in words at the end of a run.
#include <filesystem>

#include "continuation/branch.hpp"
#include "support/stage.hpp"

namespace dovetail {

/// What a run amounts to; `branch` is null when only the reduction was wanted. Collective: stages are collected from
/// all ranks; rank 0 writes and prints.
void write_summary(MPI_Comm comm, const std::filesystem::path &directory, const BranchSummary *branch,
                   double frequency_scale, const Stages &stages);

/// summary.json of a run that ended by an exception, unless it has been written. For one rank alone.
void note_failure(const std::filesystem::path &directory, const std::string &failure) noexcept;

} // namespace dovetail
