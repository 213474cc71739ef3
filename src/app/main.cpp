// dovetail: forced response of structures with frictional joints. The command line, and how a run ends.
#include <slepc.h>

#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "app/run.hpp"
#include "support/error.hpp"
#include "support/version.hpp"

namespace {

constexpr const char *usage =
    "dovetail: forced response of structures with frictional joints\n\n"
    "  dovetail run CASE.toml [--out DIR] [--dry-run] [-petsc_options ...]\n"
    "  dovetail reduce CASE.toml [--out DIR] [--dry-run] [-petsc_options ...]\n"
    "  dovetail --help | --version\n\n"
    "run does the whole job, reduce stops after the reduction; both work under mpirun -n RANKS.\n"
    "  --out DIR    write there instead of output.directory\n"
    "  --dry-run    check the case, print every value in force with its unit and the forecast sizes, stop\n"
    "PETSc options reach the solvers by prefix: kee_ (factorisation and modes), preload_, hb_ (Newton); -log_view "
    "shows the time.\n"
    "Exit status: 0 done; 2 the input is wrong; 3 the computation could not go on, what was computed is saved.\n";

dovetail::Request parse(std::vector<std::string> words) {
  using dovetail::InputError;
  dovetail::Request request;
  if (words.empty()) throw InputError(std::string("no command given\n\n") + usage);
  if (words[0] != "run" && words[0] != "reduce")
    throw InputError("\"" + words[0] + "\" is not a command; run, reduce, --help or --version are");
  request.reduce_only = words[0] == "reduce";
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (words[i] == "--dry-run")
      request.dry_run = true;
    else if (words[i] == "--out") {
      if (++i == words.size()) throw InputError("--out wants a folder behind it");
      request.out = words[i];
    } else if (words[i].rfind("--", 0) == 0)
      throw InputError(words[i] + " is not an option; --out DIR and --dry-run are");
    else if (words[i].rfind("-", 0) == 0)
      break; // from here on PETSc's
    else if (request.file.empty())
      request.file = words[i];
    else
      throw InputError("one case file is wanted, \"" + words[i] + "\" is a second");
  }
  if (request.file.empty())
    throw InputError("dovetail " + words[0] + " wants a case file, as in: dovetail " + words[0] + " case.toml");
  return request;
}

} // namespace

int main(int argc, char **argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  for (const std::string &word : words) {
    if (word == "--help" || word == "-h" || word == "-help") return std::fputs(usage, stdout), 0;
    if (word == "--version") return std::printf("dovetail %s (%s)\n", dovetail::version, dovetail::git_revision), 0;
  }
  // PETSc reads its own options, from the first word with a single dash on; ours would only confuse it
  std::vector<char *> petsc{argv[0]};
  for (int i = 1; i < argc; ++i)
    if (petsc.size() > 1 || (argv[i][0] == '-' && argv[i][1] != '-')) petsc.push_back(argv[i]);
  int petsc_argc = static_cast<int>(petsc.size());
  petsc.push_back(nullptr);
  char **petsc_argv = petsc.data();
  if (SlepcInitialize(&petsc_argc, &petsc_argv, nullptr, nullptr)) return 3;
  dovetail::install_error_handler();

  int rank = 0, status = 3;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  const auto tell = [&](const char *what) {
    if (rank == 0) std::fprintf(stderr, "dovetail: %s\n", what);
  };
  try {
    status = dovetail::run_case(PETSC_COMM_WORLD, parse(words));
  } catch (const dovetail::InputError &error) { // the same on all ranks
    tell(error.what());
    status = 2;
  } catch (const dovetail::ComputeError &error) {
    tell(error.what());
    status = 3;
  } catch (const std::exception &error) { // perhaps on this rank only: the others must not wait for it
    std::fprintf(stderr, "dovetail: rank %d: %s\n", rank, error.what());
    MPI_Abort(PETSC_COMM_WORLD, 3);
  }
  SlepcFinalize();
  return status;
}
