#include "support/petsc_begin.hpp"

#include <slepc.h>

#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>

#include "support/log.hpp"

namespace dovetail {
namespace {

std::string why;

PetscErrorCode keep(MPI_Comm, int, const char *, const char *, PetscErrorCode code, PetscErrorType type,
                    const char *message, void *) {
  if (type == PETSC_ERROR_INITIAL && message) why = message;
  return code;
}

} // namespace

void begin_petsc(int *argc, char ***argv) {
  PetscPushErrorHandler(keep, nullptr); // for good: with -malloc_debug what was made before cannot be freed
  if (SlepcInitialize(argc, argv, nullptr, nullptr)) {
    int begun = 0, rank = 0;
    MPI_Initialized(&begun);
    if (begun) MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    if (rank > 0) std::this_thread::sleep_for(std::chrono::seconds(1)); // rank 0 has the word, and all end with it
    log_error("PETSc does not begin: " + why + "; look at its options here and in PETSC_OPTIONS");
    std::_Exit(2);
  }
}

} // namespace dovetail
