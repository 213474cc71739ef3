#pragma once
// A file that is there while a test lasts, and what is said of one that is wrong.
#include <mpi.h>
#include <petscsys.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace dovetail::testing {

inline int rank_here() {
  int rank;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  return rank;
}

/// A name of a file, the same on all ranks; the file goes with this.
struct TemporaryFile {
  std::filesystem::path path;
  explicit TemporaryFile(const std::string &name) {
    long number = getpid();
    MPI_Bcast(&number, 1, MPI_LONG, 0, PETSC_COMM_WORLD);
    path = std::filesystem::temp_directory_path() / (name + "_" + std::to_string(number) + ".h5");
  }
  ~TemporaryFile() {
    MPI_Barrier(PETSC_COMM_WORLD);
    if (rank_here() == 0) std::filesystem::remove(path);
  }
};

/// What `work` throws, as far as it is of that kind.
template <class Error, class Work> std::string said(Work &&work) {
  try {
    work();
  } catch (const Error &error) {
    return error.what();
  }
  return "nothing was thrown";
}

} // namespace dovetail::testing
