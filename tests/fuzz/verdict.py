"""What a Python reader may do with any input: take it, or raise ValueError or OSError with a message that names a file."""

import signal
import traceback
from contextlib import contextmanager

SECONDS = 10  # for one input


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
        raise Hang(f"more than {SECONDS} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(SECONDS)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
