#pragma once

#include <mpi.h>

#include <string>

namespace dovetail {

/// Vector instructions in the order of their speed; kernels of OpenBLAS differ most by these.
enum class Vectors { unknown, sse, avx, avx2, avx512 };

/// What a kernel of this name is written for; unknown for any name that is not in the list.
Vectors vectors_of_kernel(const std::string &name);

/// What both processor and operating system allow; unknown where the processor is no x86.
Vectors vectors_of_processor();

/// A kernel that suits the processor, where this one is of a lower class; else empty.
std::string better_kernel(const std::string &name, Vectors processor);

/// The kernel of OpenBLAS at work, and whose choice it is.
struct BlasKernel {
  std::string name;         // empty: BLAS is not OpenBLAS
  std::string better;       // would suit the processor
  bool set_by_user = false; // by OPENBLAS_CORETYPE
  std::string asked;        // by the user or by Dovetail
  std::string replaced;     // OpenBLAS's own choice, where Dovetail asked for another

  bool worth_saying() const { return !replaced.empty() || !better.empty(); }
};

std::string in_words(const BlasKernel &kernel);

/// The kernel in this process. The first call takes what Dovetail asked for out of the environment.
const BlasKernel &blas_kernel();

/// What last bits of this process depend on: library, kernel, threads, vector instructions.
std::string kinds_of_arithmetic();

/// Whether all ranks come to the same bits where they do the same. Collective.
bool compute_alike(MPI_Comm comm);

/// OpenBLAS chooses its kernel when it is loaded, and without a word takes the slowest for a processor that it does not
/// know. Then this starts the program anew, once, asking for a better one; to be called before MPI_Init.
void take_better_kernel(char **argv);

/// Name and version of OpenBLAS, or the file that another BLAS comes from.
std::string blas_library();

} // namespace dovetail
