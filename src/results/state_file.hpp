#pragma once
// state.h5 beside the results: where a run stands, so that --restart goes on from there. Scaled numbers, bit for bit.
#include <filesystem>
#include <string>

#include "analyses/branch.hpp"
#include "results/results_file.hpp"
#include "scaling/scaled_model.hpp"

namespace dovetail {

struct SavedRun {
  BranchState branch;
  Scales scales;
  std::string run;             ///< name of the run, in its results too: made when it was begun, kept over restarts
  std::string problem, limits; ///< problem_of() and limits_of() the case (case/restart.hpp)
  std::string end;             ///< how the run ended, as in summary.json; empty while it goes on, or was cut off
  int parts = 1;               ///< how often it was begun or continued
  double seconds = 0;          ///< along the branch, over all parts
  long events = 0;             ///< rows of /events so far
};

/// A name for a run that begins, like no other's.
std::string new_run_name();

/// Written aside and renamed: the file is always whole. One rank alone. WriteError.
void write_state(const std::filesystem::path &path, const SavedRun &run);

/// Throws InputError where there is none, or not a whole one. Each rank on its own.
SavedRun read_state(const std::filesystem::path &path);

/// Saves where a run stands now and then, and when it ends.
class StateKeeper {
public:
  /// `begin`: all but the branch; its seconds are those of the parts before.
  StateKeeper(MPI_Comm comm, std::filesystem::path path, SavedRun begin);
  /// Takes note, and writes unless that was done a moment ago. Ranks learn of a failure when the results agree.
  void take(BranchState state, ResultsFile &results);
  /// Writes what was noted last, if anything ever was. Collective.
  void finish(const std::string &end);
  double seconds() const; ///< along the branch, over all parts
  int parts() const { return run_.parts; }

private:
  void write();
  MPI_Comm comm_;
  std::filesystem::path path_;
  SavedRun run_;
  double before_, begin_;            ///< seconds of earlier parts; when this one began
  double written_ = -1e9, took_ = 0; ///< when, and how long
  bool speaks_ = false, noted_ = false;
};

} // namespace dovetail
