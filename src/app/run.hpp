#pragma once
// The job from case.toml to results.h5, as five steps.
#include <mpi.h>

#include <filesystem>

namespace dovetail {

struct Request {
  std::filesystem::path file; ///< case.toml
  std::filesystem::path out;  ///< --out, or empty
  bool dry_run = false;       ///< check, print what is in force, stop
  bool check_only = false;    ///< check, also by rules of physics, stop
  bool reduce_only = false;   ///< stop after the reduction
  bool modes_only = false;    ///< show the resonances, stop
  bool restart = false;       ///< continue the run in the output directory
};

/// Throws InputError (exit status 2) and ComputeError (3). Collective.
void run_case(MPI_Comm comm, const Request &request);

} // namespace dovetail
