#pragma once
// How much memory this process has and this machine can still give (Linux).
#include <mpi.h>

namespace dovetail {

/// From now on blocks of 64 MiB and more come from the system, and go back to it when they are freed: MPI may have
/// turned that off (Open MPI does), and then no other block fits what was freed.
void give_back_large_blocks();

/// Resident memory of this process now [bytes].
double resident_bytes();

/// Largest resident memory of this process so far [bytes].
double peak_bytes();

/// What the machine of this rank can still give to all its ranks together [bytes]: free and reclaimable memory, or what
/// is left below the limit of a container or batch job if that is less.
double available_bytes();

/// Sum of `value` over the ranks that share this rank's machine. Collective.
double sum_on_machine(MPI_Comm comm, double value);

} // namespace dovetail
