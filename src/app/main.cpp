// dovetail: forced response of structures with frictional joints. The command line, and how a run ends.
#include <slepc.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <new>
#include <string>
#include <vector>
#if defined(__SSE2__)
#include <pmmintrin.h>
#endif

#include "app/run.hpp"
#include "app/versions.hpp"
#include "case/keys.hpp"
#include "support/blas_buffer.hpp"
#include "support/blas_kernel.hpp"
#include "support/error.hpp"
#include "support/json.hpp"
#include "support/log.hpp"
#include "support/memory.hpp"
#include "support/mumps.hpp"
#include "support/petsc_begin.hpp"
#include "support/signals.hpp"
#include "support/version.hpp"

namespace {

constexpr const char *usage =
    "dovetail: forced response of structures with frictional joints\n\n"
    "  dovetail run CASE.toml [--out DIR] [--log text|json] [--restart] [--dry-run] [-petsc_options ...]\n"
    "  dovetail reduce CASE.toml [--out DIR] [--log text|json] [--dry-run] [-petsc_options ...]\n"
    "  dovetail modes CASE.toml [--out DIR] [--log text|json] [-petsc_options ...]\n"
    "  dovetail check CASE.toml [--out DIR] [--log text|json] [-petsc_options ...]\n"
    "  dovetail --help | --version [-v] | --schema\n\n"
    "run does the whole job, reduce stops after the reduction, modes shows where the structure resonates with its "
    "joint\n"
    "stuck, slipping and open, check says what is wrong or doubtful and writes nothing; all work under mpirun -n "
    "RANKS.\n"
    "  --out DIR    write there instead of output.directory\n"
    "  --log json   messages as JSON, one object a line, every point with its numbers\n"
    "  --restart    continue the run in the output directory where it was cut off or stopped\n"
    "  --dry-run    check the case, print every value in force with its unit and the forecast sizes, stop\n"
    "  --version -v the libraries, too, and which kernels of OpenBLAS compute\n"
    "  --schema     a JSON schema of the case file, for editors\n"
    "PETSc options reach the solvers by prefix: kee_ (factorisation of K_ee), preload_ (its solves), hb_ (Newton); "
    "-log_view shows the time.\n"
    "SIGTERM, SIGINT, SIGHUP and SIGUSR1 finish the point at hand and end the run with status 3, ready for "
    "--restart.\n"
    "Exit status: 0 done; 2 the input is wrong; 3 the computation could not go on, what was computed is saved.\n";

// Coefficients that vanish by symmetry come down to 1e-310 in Newton's method, where arithmetic is a hundred times
// slower.
void take_tiny_for_zero() {
#if defined(__SSE2__)
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
#endif
}

// With one dash PETSc would take them for its own, and nothing would come of them.
void refuse_one_dash(const std::string &word) {
  std::string name = word.substr(1);
  std::replace(name.begin(), name.end(), '_', '-');
  if (name == "dryrun") name = "dry-run";
  if (name == "o") name = "out";
  for (const char *ours : {"restart", "dry-run", "out", "log"})
    if (name == ours) throw dovetail::InputError(word + ": an option of dovetail has two dashes; write --" + name);
}

// Not started by mpirun or srun.
bool alone() { return !std::getenv("OMPI_COMM_WORLD_SIZE") && !std::getenv("PMIX_RANK") && !std::getenv("PMI_RANK"); }

dovetail::Request parse(std::vector<std::string> words) {
  using dovetail::InputError;
  dovetail::Request request;
  if (words.empty()) throw InputError(std::string("no command given\n\n") + usage);
  if (words[0] != "run" && words[0] != "reduce" && words[0] != "modes" && words[0] != "check")
    throw InputError("\"" + words[0] + "\" is not a command; run, reduce, modes, check, --help or --version are");
  request.reduce_only = words[0] == "reduce", request.modes_only = words[0] == "modes";
  request.check_only = words[0] == "check";
  bool petsc = false; // from the first word with a single dash on, words without two dashes are PETSc's
  for (std::size_t i = 1; i < words.size(); ++i) {
    const bool one_dash = words[i].rfind("-", 0) == 0 && words[i].rfind("--", 0) != 0;
    if (one_dash) refuse_one_dash(words[i]);
    petsc = petsc || one_dash;
    if (words[i] == "--dry-run" && !request.modes_only && !request.check_only)
      request.dry_run = true;
    else if (words[i] == "--restart" && words[0] == "run")
      request.restart = true;
    else if (words[i] == "--out") {
      if (++i == words.size()) throw InputError("--out wants a folder behind it");
      if (!request.out.empty()) throw InputError("--out is given twice: one folder is wanted");
      if (words[i].empty()) throw InputError("--out \"\": wants the name of a folder; write --out . for this one");
      request.out = words[i];
    } else if (words[i] == "--log") {
      const std::string form = ++i == words.size() ? "nothing" : "\"" + words[i] + "\"";
      if (form != "\"text\"" && form != "\"json\"")
        throw InputError("--log wants text or json behind it, found " + form);
    } else if (words[i].rfind("--", 0) == 0)
      throw InputError(
          words[i] +
          " is not an option here; --out DIR, --log json, for run and reduce --dry-run, and for run --restart are");
    else if (petsc)
      continue;
    else if (request.file.empty())
      request.file = words[i];
    else
      throw InputError("one case file is wanted, \"" + words[i] + "\" is a second");
  }
  if (request.file.empty())
    throw InputError("dovetail " + words[0] + " wants a case file, as in: dovetail " + words[0] + " case.toml");
  return request;
}

// PETSc itself would obey them without a word, and another folder would give another answer.
void tell_unread_options() {
  const char *home = std::getenv("HOME");
  std::vector<std::filesystem::path> files{".petscrc", "petscrc"};
  if (home) files.insert(files.begin(), std::filesystem::path(home) / ".petscrc");
  std::error_code error;
  for (const std::filesystem::path &file : files)
    if (std::filesystem::exists(file, error))
      dovetail::log_error("note: options in " + file.string() + " are not read; -options_file " + file.string() +
                              " reads them",
                          "note");
}

void tell_unused_options() {
  PetscInt count = 0;
  char **names = nullptr, **values = nullptr;
  PetscOptionsLeftGet(nullptr, &count, &names, &values);
  for (PetscInt i = 0; i < count; ++i)
    dovetail::log_error("note: the option -" + std::string(names[i]) + " was not used; is it spelt right?", "note");
  PetscOptionsLeftRestore(nullptr, &count, &names, &values);
}

} // namespace

int main(int argc, char **argv) {
  dovetail::take_better_kernel(argv);
  dovetail::note_ignored_signals();
  std::vector<std::string> words(argv + 1, argv + argc);
  const bool verbose = std::find(words.begin(), words.end(), "-v") != words.end();
  for (const std::string &word : words) {
    if (word == "--help" || word == "-h" || word == "-help") return std::fputs(usage, stdout), 0;
    if (word == "-version") return std::fputs("dovetail: -version: write --version, or --version -v\n", stderr), 2;
    if (word == "--schema") return std::fputs(dovetail::case_schema().c_str(), stdout), 0;
    if (word == "--version" && verbose) return std::fputs(dovetail::versions().c_str(), stdout), 0;
    if (word == "--version") return std::printf("dovetail %s (%s)\n", dovetail::version, dovetail::git_revision), 0;
  }
  for (std::size_t i = 1; i + 1 < words.size(); ++i)
    if (words[i] == "--log" && words[i + 1] == "json") dovetail::log_as_json();
  dovetail::order_the_same_way();
  // PETSc gets its own options only: ours would confuse it. Of files that lie about it reads none,
  // and to signals it would answer with a traceback.
  char no_files[] = "-skip_petscrc", no_signals[] = "-no_signal_handler";
  std::vector<char *> petsc{argv[0], no_files, no_signals};
  for (int i = 1; i < argc; ++i) {
    const bool ours = std::strncmp(argv[i], "--", 2) == 0;
    if (!ours && (petsc.size() > 3 || argv[i][0] == '-')) petsc.push_back(argv[i]);
    if (std::strcmp(argv[i], "--out") == 0 || std::strcmp(argv[i], "--log") == 0) ++i;
  }
  int petsc_argc = static_cast<int>(petsc.size());
  petsc.push_back(nullptr);
  char **petsc_argv = petsc.data();
  // Without mpirun Open MPI would start a daemon, and fail where it finds no ssh on the path.
  setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
  if (alone()) {
    setenv("OMPI_MCA_pml", "ob1", 0); // which looks for no networks: a fifth of a second
    // All such runs would share one folder, which the first to end removes while another is beginning.
    setenv("OMPI_MCA_orte_create_session_dirs", "0", 0);
  }
  dovetail::begin_petsc(&petsc_argc, &petsc_argv);
  dovetail::give_back_large_blocks();
  if (dovetail::logs_json()) PETSC_STDOUT = stderr; // for what PETSc's options print
  dovetail::install_error_handler();
  dovetail::expect_no_exit();
  dovetail::catch_signals();
  take_tiny_for_zero();

  MPI_Comm roll_call;
  MPI_Comm_dup(PETSC_COMM_WORLD, &roll_call);
  int rank = 0, status = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  std::string failure;
  bool in_order = true; // PETSc, MPI and HDF5 can be shut down
  try {
    dovetail::take_blas_buffer();
    const dovetail::Request request = parse(words);
    if (rank == 0) tell_unread_options();
    dovetail::run_case(PETSC_COMM_WORLD, request);
    if (rank == 0) tell_unused_options();
  } catch (const dovetail::InputError &error) {
    status = 2, failure = error.what();
  } catch (const dovetail::WriteError &error) {
    status = 3, failure = error.what(), in_order = false;
  } catch (const dovetail::MemoryError &error) {
    status = 3, failure = error.what(), in_order = false;
  } catch (const std::bad_alloc &error) {
    status = 3, failure = dovetail::text_of(error), in_order = false;
  } catch (const std::exception &error) {
    status = 3, failure = error.what();
  }
  dovetail::main_leaves();
  if (!failure.empty()) {
    dovetail::ignore_signals(); // by which the launcher ends what is left when the first rank has gone
    MPI_Request here;           // on a communicator of its own, apart from what others wait in
    MPI_Ibarrier(roll_call, &here);
    const bool together = dovetail::all_arrive(here);
    if (rank == 0 || !together) dovetail::log_error(failure, "error", dovetail::member("status", status));
    if (!together) MPI_Abort(PETSC_COMM_WORLD, status);
    if (!in_order) std::fflush(nullptr), std::_Exit(status);
  }
  MPI_Comm_free(&roll_call);
  PetscBool asked = PETSC_TRUE;
  PetscOptionsHasName(nullptr, nullptr, "-options_left", &asked);
  if (!asked) PetscOptionsSetValue(nullptr, "-options_left", "no"); // PETSc of late tells of unused ones a second time
  SlepcFinalize();
  return status;
}
