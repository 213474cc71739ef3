#pragma once
// What the commands have in common before their own job: the input checked, the output folder taken, the preload.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/earlier_run.hpp"
#include "app/forecast.hpp"
#include "app/run.hpp"
#include "app/tell_resonances.hpp"
#include "support/folder_lock.hpp"

namespace dovetail {

/// Case, sizes and contact law: all that can be wrong in the input short of the matrices themselves.
struct Checked {
  Case study;
  Forecast sizes;
  std::vector<ContactPoint> contact;          ///< all points
  std::vector<double> initial;                ///< (3 N_x) [m]
  PetscInt dofs = 0;                          ///< of the reduced model
  PetscInt most_modes = 0;                    ///< that it may have, where a tolerance decides
  int sectors = 0;                            ///< of the whole, if the model is one
  bool has_c = false, has_structural = false; ///< damping matrices of the model
  Units units;
  std::optional<SavedRun> earlier; ///< the run to be continued
  bool has_results = false;        ///< on rank 0: results.h5 is this run's
};

/// Collective, as all below.
Checked check_input(MPI_Comm comm, const Request &request);

/// The folder is this run's from here on, or another's, which is told. On rank 0; nothing on the others.
std::unique_ptr<FolderLock> take_folder(MPI_Comm comm, const Case &study, const Voice &voice);

/// What hysteretic damping leaves out, and damping of the model that is not taken; or nothing.
std::vector<std::string> notes_on_damping(const Checked &checked);

/// Where the earlier run is gone on with.
std::string in_words(const SavedRun &earlier, const Case &study);

/// The state the vibration starts from (eq 7), told if it took more than plain Newton.
PreloadedModel preload(const Checked &checked, ReducedModel reduced, const Voice &voice);

/// Tells what was found, and what it warns of, which it returns.
std::vector<Warning> say(const Resonances &found, const Case &study, const Voice &voice);

} // namespace dovetail
