"""One attempt of an adversary: a folder with an earlier run in it, something bad, a command, and the judgement of what came of it."""

import hashlib
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable

import h5py
import hdf5_edits
import numpy as np
from fuzz_restart import FOREIGN

from dovetail import Results, verify
from launch import SURROUNDINGS, kill

CASE = {"model": '"model.h5"', "reduction.modes": "2", "damping.stiffness": "0.05", "excitation.fourier": "[0, 0, 1]",
        "harmonic_balance.harmonics": "2", "harmonic_balance.samples": "32", "continuation.omega": "[0.9, 1.3]",
        "continuation.max_points": "4", "output.directory": '"out"'}
SECONDS, ALL_SECONDS = 40, 300  # of the processor for a run that takes a tenth of one; and in all, on a busy machine
MEMORY = 8 << 30
GOOD = ("right", "taken", "refused", "stopped")
BAD = {"wrong": "silent and wrong", "crash": "crashes", "hang": "hangs", "loss": "losses", "mute": "without words"}
CRASH = re.compile(FOREIGN.pattern + r"|Traceback|Segmentation|Caught signal|terminate called|Assertion .* failed")


def nothing(folder):
    """Changes nothing."""


@dataclass
class Attempt:
    """What is done to a folder, the words behind the program's name, and what is expected."""

    kind: str
    name: str
    change: Callable = nothing
    words: tuple = ("run", "case.toml")
    package: bool = False  # python3 -m dovetail in place of the program
    ranks: int = 1
    refuse: bool = False  # no answer is a right one
    surroundings: dict = field(default_factory=dict)
    largest_file: int = 0  # in bytes, as a full disk; 0: without limit
    interrupt: tuple = ()  # signal, and after which part of the time of an undisturbed run
    stdout: str = os.devnull
    closed: int = None  # a stream
    outcome: str = ""
    why: str = ""


def case_text(**keys):
    """The case file of the earlier run with keys changed ("__" for a dot, None without), in TOML."""
    values = CASE | {name.replace("__", "."): value for name, value in keys.items()}
    return "".join(f"{name} = {value}\n" for name, value in values.items() if value is not None)


def rewrite(**keys):
    return lambda folder: (folder / "case.toml").write_text(case_text(**keys))


many_points = rewrite(continuation__adaptive="false", continuation__step="2e-4", continuation__max_points="400")  # half a second


class Adversary:
    """A folder that attempts are made on copies of, and the program."""

    def __init__(self, program, folder):
        self.program, self.folder, self.start = Path(program).resolve(), Path(folder), Path(folder) / "start"
        self.start.mkdir()
        hdf5_edits.write(self.start / "model.h5", "model", [])
        rewrite()(self.start)
        status, said = self.run(Attempt("", ""), self.start)
        assert status == 0, said
        self.run_before = run_name(self.start)
        interrupted = Path(shutil.copytree(self.start, self.folder / "whole"))
        many_points(interrupted)
        begin = time.monotonic()
        status, said = self.run(Attempt("", ""), interrupted)
        assert status == 0, said
        self.seconds, self.whole = time.monotonic() - begin, coefficients(interrupted / "out/results.h5")

    def run(self, attempt, folder):
        """Exit status (None: it hangs) and what was said on standard error."""
        limits = [shutil.which("prlimit"), f"--cpu={SECONDS}:{SECONDS + 5}", f"--as={MEMORY}"]
        limits += [f"--fsize={attempt.largest_file}"] if attempt.largest_file else []
        closed = ["/bin/sh", "-c", f'exec "$@" {attempt.closed}>&-', "sh"] if attempt.closed is not None else []
        program = [sys.executable, "-W", "ignore", "-m", "dovetail"] if attempt.package else [str(self.program)]
        mpirun = ["mpirun", "-n", str(attempt.ranks)] if attempt.ranks > 1 else []
        surroundings = {"MPLBACKEND": "agg"} | SURROUNDINGS | {"OMPI_MCA_orte_tmpdir_base": str(folder.parent), "OMPI_MCA_pml": "ob1"}
        with open(attempt.stdout, "wb") as stdout:
            process = subprocess.Popen([*limits, *closed, *mpirun, *program, *attempt.words], cwd=folder, stdin=subprocess.DEVNULL,
                                       stdout=stdout, stderr=subprocess.PIPE, env=surroundings | attempt.surroundings)
        try:
            if attempt.interrupt:
                time.sleep(attempt.interrupt[1] * self.seconds)
                process.send_signal(attempt.interrupt[0])
            said = process.communicate(timeout=ALL_SECONDS)[1]
        except subprocess.TimeoutExpired:
            kill(process)
            return None, ""
        status = None if process.returncode in (-signal.SIGXCPU, 128 + signal.SIGXCPU) else process.returncode
        return status, said.decode(errors="replace")

    def attempt(self, attempt):
        """Makes it in a folder of its own, and says in the attempt what came of it."""
        folder = Path(tempfile.mkdtemp(dir=self.folder)) / "attempt"
        shutil.copytree(self.start, folder)
        attempt.change(folder)
        before = contents(folder)
        status, said = self.run(attempt, folder)
        try:
            attempt.outcome, attempt.why = self.judge(attempt, folder, before, status, said)
        except (OSError, KeyError, ValueError, AssertionError) as error:
            attempt.outcome, attempt.why = "loss", f"status {status}, then {error!r}: {said[-300:]}"
        shutil.rmtree(folder.parent, ignore_errors=True)
        return attempt

    def judge(self, attempt, folder, before, status, said):
        crash = CRASH.search(said)
        if status is None:
            return "hang", said[-300:]
        killed = attempt.interrupt and status in (-attempt.interrupt[0], 128 + attempt.interrupt[0])
        if crash or status not in (0, 2, 3) and not killed:
            return "crash", f"status {status}: {said[max(0, crash.start() - 200) if crash else -300:][:600]}"
        after = contents(folder)
        changed = sorted(name for name, value in before.items() if after.get(name) != value)
        if status == 2 and changed:
            return "loss", f"refused, but changed {changed}"
        if others := [name for name in changed if not name.startswith(("out/", "earlier/"))]:
            return "loss", f"changed {others}"
        if status and not killed and not said.strip():
            return "mute", f"status {status}"
        if status == 0 and attempt.refuse:
            return "wrong", f"taken: {said[-300:]}"
        ours = run_name(folder) not in (self.run_before, None) or "--restart" in attempt.words
        if any(name.startswith("out/results.h5") for name in changed):
            check_readable(folder / "out/results.h5")
        if attempt.interrupt:
            self.recover(folder, ours)
        if status:
            return ("refused" if status == 2 else "stopped"), said.strip().splitlines()[-1] if said.strip() else ""
        if not ours or attempt.package or "run" not in attempt.words:
            return "taken", ""
        complaints = judged_by_reference(folder / "out/results.h5")
        return ("wrong", complaints) if complaints else ("right", "")

    def recover(self, folder, ours):
        """What was interrupted is continued, or begun anew where it had no state, and comes to the curve of an undisturbed run."""
        results = folder / "out/results.h5"
        restart = ("--restart",) if ours and ((folder / "out/state.h5").exists() or len(Results(results).omega) > 3) else ()
        status, said = self.run(Attempt("", "", words=("run", "case.toml", *restart)), folder)
        assert status == 0, f"afterwards {status}: {said[-300:]}"
        found = coefficients(results)
        same = found.shape == self.whole.shape and np.allclose(found, self.whole, rtol=0, atol=1e-8 * np.abs(self.whole).max())
        assert same, "another curve than that of an undisturbed run"


def contents(folder):
    """Hashes of all files by name, but of what an earlier run leaves to say who holds the folder."""
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(folder.rglob("*")) if path.is_file() and path.name != "dovetail.lock"}


def run_name(folder):
    try:
        with h5py.File(folder / "out/results.h5", "r") as file:
            return file.attrs["run"]
    except (OSError, KeyError):
        return None


def coefficients(path):
    with h5py.File(path, "r") as file:
        return file["points/coefficients"][()]


def check_readable(path):
    found = coefficients(path)
    assert len(found) > 0 and np.isfinite(found).all(), f"{len(found)} points in {path.name}"


def judged_by_reference(path):
    """What the NumPy reference finds wrong with the first and the last point, in words; "" where nothing is."""
    results = Results(path)
    return "; ".join(text for point in {0, len(results.omega) - 1} for text in verify.verdict(results, point, 4096).complaints)
