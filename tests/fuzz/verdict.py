"""What a Python reader may do with any input: take it, or raise ValueError or OSError with a message that names a file."""

import signal
import traceback
from contextlib import contextmanager

SECONDS = 10  # of the processor, for one input
PATIENCE = 30  # times as long as that by the clock: for a process of a reader's own, or what waits for ever, on a machine that is busy


class Hang(BaseException):
    """An input took longer than SECONDS."""


def fault(read, names):
    """Runs read(); None if all is well, else (where in few words, the whole traceback)."""
    try:
        with _limit():
            read()
    except (Exception, Hang, SystemExit) as error:
        refused = type(error) is ValueError or isinstance(error, OSError)  # subclasses of ValueError come from elsewhere
        if refused and any(str(name) in str(error) for name in names):
            return None
        frames = [frame for frame in traceback.extract_tb(error.__traceback__) if "/dovetail/" in frame.filename]
        place = f"{frames[-1].filename.rpartition('/dovetail/')[2]}:{frames[-1].lineno}" if frames else "?"
        return f"{type(error).__name__} at {place}", "".join(traceback.format_exception(error))
    return None


@contextmanager
def _limit():
    def ring(*_):
        raise Hang(f"more than {SECONDS} s of the processor, or {PATIENCE * SECONDS} s")

    clocks = {signal.SIGPROF: (signal.ITIMER_PROF, SECONDS), signal.SIGALRM: (signal.ITIMER_REAL, PATIENCE * SECONDS)}
    before = {number: signal.signal(number, ring) for number in clocks}
    for clock, seconds in clocks.values():
        signal.setitimer(clock, seconds)
    try:
        yield
    finally:
        for clock, _ in clocks.values():
            signal.setitimer(clock, 0)
        for number, action in before.items():
            signal.signal(number, action)
