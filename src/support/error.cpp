#include "support/error.hpp"

#include <cstdio>
#include <cstring>
#include <new>

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

std::string out_of_memory() {
  char used[80];
  std::snprintf(used, sizeof used, "out of memory: this rank has had %.3g GiB, and got no more",
                peak_bytes() / (1024.0 * 1024 * 1024));
  return std::string(used) +
         "; what helps is more memory, ranks on more machines, or fewer harmonics, modes or contact points";
}

enum class Outcome { ok, input, compute, write };

} // namespace

void install_error_handler() { PetscPushErrorHandler(keep_first_message, nullptr); }

void check(PetscErrorCode code, const char *doing) {
  if (!code) return;
  if (memory_ran_out || code == PETSC_ERR_MEM) {
    memory_ran_out = false, first_message.clear();
    throw ComputeError(std::string("while ") + doing + ": " + out_of_memory());
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
  } catch (const std::exception &error) {
    outcome = Outcome::compute, message = text_of(error);
  }
  int first = outcome == Outcome::ok ? size : rank;
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, comm);
  if (first == size) return;
  int header[2] = {static_cast<int>(outcome), static_cast<int>(message.size())};
  MPI_Bcast(header, 2, MPI_INT, first, comm);
  message.resize(header[1]);
  MPI_Bcast(message.data(), header[1], MPI_CHAR, first, comm);
  if (header[0] == static_cast<int>(Outcome::input)) throw InputError(message);
  if (header[0] == static_cast<int>(Outcome::write)) throw WriteError(message);
  throw ComputeError(message);
}

} // namespace dovetail
