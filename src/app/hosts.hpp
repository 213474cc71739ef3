#pragma once
// What ranks on several hosts need of each other, before work begins.
#include <mpi.h>

#include <filesystem>
#include <string>

namespace dovetail {

int ranks_of(MPI_Comm comm);

/// Throws InputError unless every rank sees in the folder what rank 0 has written there: `token`, the text of the
/// folder's lock, given on rank 0; empty: nothing to look for. Collective.
void refuse_unshared(MPI_Comm comm, const std::filesystem::path &folder, std::string token);

/// Throws InputError where some ranks see a file that others do not. Collective.
void refuse_unshared_file(MPI_Comm comm, const std::filesystem::path &file);

/// That ranks take turns on the cores of a host, or nothing. Collective.
std::string note_on_cores(MPI_Comm comm);

/// That last bits differ between ranks, which then share work in another way, or nothing. Collective.
std::string note_on_arithmetic(MPI_Comm comm);

/// That ranks have no contact point, or nothing.
std::string idle_ranks(int ranks, int points);

} // namespace dovetail
