#pragma once
// The two ways a run can end early, and the bridge between C++ exceptions, PETSc error codes and MPI ranks.
#include <mpi.h>
#include <petscsys.h>

#include <exception>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>

namespace dovetail {

/// The user's input is wrong (exit status 2). The text names file, line or dataset, key, value found, value wanted.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The computation cannot go on (exit status 3). What was computed before stays saved.
struct ComputeError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A file could not be written (exit status 3). HDF5 still holds what it could not get rid of and would crash on trying
/// again while MPI shuts down: the program ends without that.
struct WriteError : ComputeError {
  using ComputeError::ComputeError;
};

/// Memory ran out (exit status 3). A library that got none may be left with half of what it was making: the program
/// ends without shutting it down.
struct MemoryError : ComputeError {
  using ComputeError::ComputeError;
};

/// Throws ComputeError when a PETSc, SLEPc or MPI call failed; `doing` completes "while ...".
void check(PetscErrorCode code, const char *doing);

/// What an exception says; where memory ran out, what to do about it.
std::string text_of(const std::exception &error);

/// Replaces PETSc's traceback printer: the first message is kept for the exception that check() throws. An error of MPI
/// ends the run on all ranks, with a message: PETSc would have it returned, and few look.
void install_error_handler();

/// From here on a library that ends the program is told of, with status 3: Fortran's does so where MUMPS gets no
/// memory, with a status that means something else. Until main_leaves().
void expect_no_exit();
void main_leaves();

/// True if a collective call that does not block is complete within a few seconds. An error can strike one rank alone,
/// and the others then wait for it elsewhere, inside some collective call, for ever.
bool all_arrive(MPI_Request request);

/// Makes a number the least that any rank gives (collective). False on a rank that has failed if the others do not
/// arrive.
bool least_of_all(MPI_Comm comm, int &number, bool failed);

/// Runs `work` on every rank of `comm` (collective). If it throws on any rank, the message of the lowest such rank is
/// thrown on all of them, so that no rank is left waiting in a later collective call. Where the others do not arrive,
/// because they wait in a call that `work` did not come to, a rank throws alone.
void on_all_ranks(MPI_Comm comm, const std::function<void()> &work);

/// Carries a C++ exception through a C library: run() turns it into an error code, rethrow() brings it back.
class Courier {
public:
  template <class Work> PetscErrorCode run(Work &&work) noexcept {
    try {
      work();
      return 0;
    } catch (...) {
      if (!held_) held_ = std::current_exception();
      return PETSC_ERR_LIB;
    }
  }
  void rethrow() {
    if (held_) std::rethrow_exception(std::exchange(held_, nullptr));
  }

private:
  std::exception_ptr held_;
};

} // namespace dovetail
