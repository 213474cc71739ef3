"""A run seen on a terminal, where it shows every point as soon as it is in the file."""

import os
import pty
import re
import subprocess
import threading

from launch import SURROUNDINGS, kill, wait_for

POINT = re.compile(r"^ *(\d+) +[\d.]+ +\S+e[+-]\d\d ", re.MULTILINE)


class Watched:
    """The process, and what it has said so far. Killed at the end of the `with` block if it still goes on."""

    def __init__(self, command):
        ours, theirs = pty.openpty()
        self.process = subprocess.Popen(command, env=SURROUNDINGS, stdin=theirs, stdout=theirs, stderr=theirs)
        os.close(theirs)
        self._said = b""
        self._reader = threading.Thread(target=self._read, args=(ours,), daemon=True)
        self._reader.start()

    def _read(self, terminal):
        try:
            while block := os.read(terminal, 65536):
                self._said += block
        except OSError:  # the far end is closed
            pass
        os.close(terminal)

    @property
    def said(self):
        """All of it, once the process has ended."""
        if self.process.poll() is not None:
            self._reader.join(10)
        return self._said.decode(errors="replace").replace("\r", "")

    def last_point(self):
        """Number of the last point shown, or 0."""
        shown = POINT.findall(self.said)
        return int(shown[-1]) if shown else 0

    def wait_for_point(self, number):
        wait_for(lambda: self.last_point() >= number or self.process.poll() is not None, f"point {number}")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            kill(self.process)
