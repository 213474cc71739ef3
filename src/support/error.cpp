#include "support/error.hpp"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <thread>

#include "support/log.hpp"
#include "support/memory.hpp"

namespace dovetail {
namespace {

// Of the error PETSc is unwinding; cleared when check() throws it.
std::string first_message;
bool memory_ran_out = false;

// PETSC_ERR_MEM, or a failed allocation: PETSC 3.18 gives those a code without meaning.
bool is_of_memory(PetscErrorCode code, const char *function) {
  return code == PETSC_ERR_MEM || (function && (std::strncmp(function, "PetscMalloc", 11) == 0 ||
                                                std::strncmp(function, "PetscRealloc", 12) == 0));
}

PetscErrorCode keep_first_message(MPI_Comm, int, const char *function, const char *, PetscErrorCode code,
                                  PetscErrorType type, const char *message, void *) {
  memory_ran_out = memory_ran_out || is_of_memory(code, function);
  if (type == PETSC_ERROR_INITIAL)
    first_message = std::string(message ? message : "no message") + " [" + (function ? function : "?") + "]";
  return code;
}

enum class Outcome { ok, input, compute, write, memory };

constexpr const char *saved = "Every point that was computed is in the results file, and --restart goes on from there";
constexpr int could_not_go_on = 3; // exit status
bool leaving = false;

void on_exit() {
  if (leaving) return;
  log_error(std::string("a library ended the program; what it said stands above. ") + saved);
  std::_Exit(could_not_go_on);
}

void on_mpi_error(MPI_Comm *, int *code, ...) {
  char why[MPI_MAX_ERROR_STRING] = "";
  int length = 0;
  MPI_Error_string(*code, why, &length);
  log_error(std::string("a call of MPI failed: ") + why + ". " + saved);
  main_leaves();
  MPI_Abort(MPI_COMM_WORLD, could_not_go_on);
}

std::string out_of_memory() {
  char used[80];
  std::snprintf(used, sizeof used, "out of memory: this rank has had %.3g GiB, and got no more",
                peak_bytes() / (1024.0 * 1024 * 1024));
  return std::string(used) +
         "; what helps is more memory, ranks on more machines, or fewer harmonics, modes or contact points";
}

} // namespace

void install_error_handler() {
  PetscPushErrorHandler(keep_first_message, nullptr);
  MPI_Errhandler handler;
  MPI_Comm_create_errhandler(on_mpi_error, &handler);
  for (MPI_Comm comm :
       {MPI_COMM_WORLD, MPI_COMM_SELF}) { // communicators made of one inherit; PETSc's own are made already
    MPI_Comm of_petsc;
    PetscCommDuplicate(comm, &of_petsc, nullptr);
    for (const MPI_Comm one : {comm, of_petsc}) MPI_Comm_set_errhandler(one, handler);
    PetscCommDestroy(&of_petsc);
  }
  MPI_Errhandler_free(&handler);
}

void check(PetscErrorCode code, const char *doing) {
  if (!code) return;
  if (memory_ran_out || code == PETSC_ERR_MEM) {
    memory_ran_out = false, first_message.clear();
    throw MemoryError(std::string("while ") + doing + ": " + out_of_memory());
  }
  const char *generic = nullptr;
  PetscErrorMessage(code, &generic, nullptr);
  const std::string why = !first_message.empty() ? first_message : generic ? generic : "error " + std::to_string(code);
  first_message.clear();
  throw ComputeError(std::string("while ") + doing + ": " + why);
}

std::string text_of(const std::exception &error) {
  return dynamic_cast<const std::bad_alloc *>(&error) ? out_of_memory() : error.what();
}

void expect_no_exit() { std::atexit(on_exit); }

void main_leaves() { leaving = true; }

bool all_arrive(MPI_Request request) {
  constexpr double patience = 10; // [s]
  const double begin = MPI_Wtime();
  for (int arrived = 0; MPI_Wtime() - begin < patience;) {
    MPI_Test(&request, &arrived, MPI_STATUS_IGNORE);
    if (arrived) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

bool least_of_all(MPI_Comm comm, int &number, bool failed) {
  static int own, least; // a call that is given up may still look for them
  own = number;
  MPI_Request request;
  MPI_Iallreduce(&own, &least, 1, MPI_INT, MPI_MIN, comm, &request);
  if (!failed)
    MPI_Wait(&request, MPI_STATUS_IGNORE);
  else if (!all_arrive(request))
    return false;
  number = least;
  return true;
}

void on_all_ranks(MPI_Comm comm, const std::function<void()> &work) {
  int rank = 0, size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  Outcome outcome = Outcome::ok;
  std::string message;
  try {
    work();
  } catch (const InputError &error) {
    outcome = Outcome::input, message = error.what();
  } catch (const WriteError &error) {
    outcome = Outcome::write, message = error.what();
  } catch (const MemoryError &error) {
    outcome = Outcome::memory, message = error.what();
  } catch (const std::bad_alloc &error) {
    outcome = Outcome::memory, message = text_of(error);
  } catch (const std::exception &error) {
    outcome = Outcome::compute, message = error.what();
  }
  const bool failed = outcome != Outcome::ok;
  int first = failed ? rank : size;
  const bool together = least_of_all(comm, first, failed);
  if (first == size) return;
  int header[2] = {static_cast<int>(outcome), static_cast<int>(message.size())};
  if (together) {
    MPI_Bcast(header, 2, MPI_INT, first, comm);
    message.resize(header[1]);
    MPI_Bcast(message.data(), header[1], MPI_CHAR, first, comm);
  }
  if (header[0] == static_cast<int>(Outcome::input)) throw InputError(message);
  if (header[0] == static_cast<int>(Outcome::write)) throw WriteError(message);
  if (header[0] == static_cast<int>(Outcome::memory)) throw MemoryError(message);
  throw ComputeError(message);
}

} // namespace dovetail
