#include "app/versions.hpp"

#include <dmumps_c.h>
#include <hdf5.h>
#include <slepc.h>

#include "support/blas_kernel.hpp"
#include "support/version.hpp"

namespace dovetail {
namespace {

std::string dotted(long major, long minor, long patch) {
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
}

std::string petsc() {
  PetscInt major = 0, minor = 0, patch = 0;
  PetscGetVersionNumber(&major, &minor, &patch, nullptr);
  return dotted(major, minor, patch);
}

std::string slepc() {
  PetscInt major = 0, minor = 0, patch = 0;
  SlepcGetVersionNumber(&major, &minor, &patch, nullptr);
  return dotted(major, minor, patch);
}

std::string mpi() {
  char text[MPI_MAX_LIBRARY_VERSION_STRING] = "";
  int length = 0;
  MPI_Get_library_version(text, &length);
  const std::string whole(text);
  return whole.substr(0, whole.find_first_of(",\n")); // who built it, and how, comes after
}

std::string hdf5() {
  unsigned major = 0, minor = 0, patch = 0;
  H5get_libversion(&major, &minor, &patch);
  return dotted(major, minor, patch);
}

#if defined(__clang__) || defined(__INTEL_COMPILER)
constexpr const char *compiler = __VERSION__;
#else
constexpr const char *compiler = "GCC " __VERSION__;
#endif

} // namespace

std::string versions() {
  const BlasKernel &kernel = blas_kernel();
  return "dovetail  " + std::string(version) + " (" + git_revision + ")\nPETSc     " + petsc() + "\nSLEPc     " +
         slepc() + "\nMUMPS     " + MUMPS_VERSION + "\nMPI       " + mpi() + "\nBLAS      " + blas_library() +
         (kernel.name.empty() ? "" : ", kernel " + in_words(kernel)) + "\nHDF5      " + hdf5() + "\ncompiler  " +
         compiler + "\n";
}

} // namespace dovetail
