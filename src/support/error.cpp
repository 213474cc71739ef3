#include "support/error.hpp"

#include <vector>

namespace dovetail {
namespace {

std::string first_message; // of the error PETSc is unwinding; cleared when check() throws it

PetscErrorCode keep_first_message(MPI_Comm, int, const char *function, const char *, PetscErrorCode code,
                                  PetscErrorType type, const char *message, void *) {
  if (type == PETSC_ERROR_INITIAL)
    first_message = std::string(message ? message : "no message") + " [" + (function ? function : "?") + "]";
  return code;
}

enum class Outcome { ok, input, compute, write };

} // namespace

void install_error_handler() { PetscPushErrorHandler(keep_first_message, nullptr); }

void check(PetscErrorCode code, const char *doing) {
  if (!code) return;
  const char *generic = nullptr;
  PetscErrorMessage(code, &generic, nullptr);
  const std::string why = !first_message.empty() ? first_message : generic ? generic : "error " + std::to_string(code);
  first_message.clear();
  throw ComputeError(std::string("while ") + doing + ": " + why);
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
    outcome = Outcome::compute, message = error.what();
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
