#pragma once
// SIGTERM and SIGUSR1, by which batch systems say that time is up, SIGINT of a keyboard, SIGHUP of a terminal that
// closes; and crashes, told in one line.
#include <mpi.h>

namespace dovetail {

/// Those that are ignored now, as by nohup, stay so. To be called before MPI and PETSc set their own handlers.
void note_ignored_signals();

/// From here on these four signals end the program with status 3 and a message, and so do, with the signal's own
/// status, those of a crash. A reader of the screen's lines that goes, or a limit on the size of files, is no reason to
/// end without a word. To be called once, after MPI and PETSc have set their own handlers.
void catch_signals();

/// From here on the first of them is only noted; a second one, more than a second later, ends the program
/// all the same.
void only_note_signals();

/// From here on none of them matters: the program is ending, and has said why.
void ignore_signals();

/// The signal that this rank has noted, or 0.
int noted_signal();

/// "SIGTERM", "SIGUSR1", "SIGINT" or "SIGHUP".
const char *signal_name(int signal);

} // namespace dovetail
