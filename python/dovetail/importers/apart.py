"""Readers of other packages in a process of their own: written in C, some read past the end of a damaged file and crash."""

import multiprocessing
import signal


def apart(read, path):
    """What read() returns, or the ValueError that names `path` when it raises, or ends its process. All goes through a pipe (pickle)."""
    fork = multiprocessing.get_context("fork")
    receiver, sender = fork.Pipe(duplex=False)
    process = fork.Process(target=_work, args=(read, path, sender), daemon=True)
    process.start()
    sender.close()  # only the process itself holds the other end now, so that its death is noticed
    try:
        good, result = receiver.recv()
    except EOFError:
        good, result = False, ValueError(f"{path}: its reader crashed; the file is damaged or cut off")
    finally:
        process.kill()
        process.join()
        receiver.close()
    if good:
        return result
    raise result


def _work(read, path, sender):
    for number in (signal.SIGSEGV, signal.SIGBUS, signal.SIGFPE, signal.SIGABRT):
        signal.signal(number, signal.SIG_DFL)  # MPI and PETSc, if they are there, would end the other process too
    try:
        sender.send((True, read()))
    except Exception as error:  # they raise many kinds for a file that is damaged or none at all
        ours = type(error) is ValueError and str(path) in str(error)
        sender.send((False, error if ours else ValueError(f"{path}: its reader cannot read it: {str(error) or type(error).__name__}")))
