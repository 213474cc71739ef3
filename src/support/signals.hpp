#pragma once
// SIGTERM and SIGUSR1, by which batch systems say that time is up; and crashes, told in one line.
#include <mpi.h>

namespace dovetail {

/// From here on SIGTERM and SIGUSR1 end the program with status 3 and a message, and so do, with the signal's own
/// status, those of a crash. To be called once, after MPI and PETSc have set their own handlers.
void catch_signals();

/// From here on the first SIGTERM or SIGUSR1 is only noted; a second one, more than a second later, ends the program
/// all the same.
void only_note_signals();

/// From here on neither matters: the program is ending, and has said why.
void ignore_signals();

/// The signal that any rank has noted, or 0: the same on all ranks. Collective.
int noted_signal(MPI_Comm comm);

/// "SIGTERM" or "SIGUSR1".
const char *signal_name(int signal);

} // namespace dovetail
