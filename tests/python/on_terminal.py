"""A run seen on a terminal, where it shows every point as soon as it is in the file."""

import os
import pty
import re
import signal
import subprocess
import threading

from launch import SECONDS, SURROUNDINGS, kill, wait_for

POINT = re.compile(r"^ *(\d+) +[\d.]+ +\S+e[+-]\d\d ", re.MULTILINE)


def points_in(said):
    """Number of the last point shown, or 0."""
    shown = POINT.findall(said)
    return int(shown[-1]) if shown else 0


class Watched:
    """The process, and what it has said so far. Killed at the end of the `with` block if it still goes on.

    halt : a number of points; when it has shown them the process stands still until `go_on`, however late this one looks. A process
        that is some hundred points ahead of its reader waits by itself, so the curve must have at least 500 more. Not under mpirun,
        which reads on.
    """

    def __init__(self, command, halt=None):
        ours, theirs = pty.openpty()
        self.process = subprocess.Popen(command, env=SURROUNDINGS, stdin=theirs, stdout=theirs, stderr=theirs)
        os.close(theirs)
        self._said, self._halt = b"", halt
        self._reader = threading.Thread(target=self._read, args=(ours,), daemon=True)
        self._reader.start()

    def _read(self, terminal):
        try:
            while block := os.read(terminal, 65536):
                said = self._said + block
                if self._halt and points_in(said.decode(errors="replace").replace("\r", "")) >= self._halt:
                    self.process.send_signal(signal.SIGSTOP)
                    self._halt = None
                self._said = said
        except OSError:  # the far end is closed
            pass
        os.close(terminal)

    @property
    def said(self):
        """All of it, once the process has ended."""
        if self.process.poll() is not None:
            self._reader.join(SECONDS)
        return self._said.decode(errors="replace").replace("\r", "")

    def last_point(self):
        """Number of the last point shown, or 0."""
        return points_in(self.said)

    def go_on(self):
        self.process.send_signal(signal.SIGCONT)

    def wait_for_point(self, number):
        wait_for(lambda: self.last_point() >= number or self.process.poll() is not None, f"point {number}")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            kill(self.process)
