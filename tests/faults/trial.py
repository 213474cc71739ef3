"""One call of a run fails: the scenes in which it does, the run, and what is judged of it."""

import os
import re
import shutil
import signal
import subprocess
import time
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

import chain
from launch import SURROUNDINGS, tables

KINDS = {"alloc": "memory, 4 KiB and more: malloc, calloc, realloc, memalign, posix_memalign (operator new, ALLOCATE)",
         "full": "write, pwrite, writev, pwritev, posix_fallocate: no space, from that call on",
         "bad": "the same: an input/output error, once",
         "short": "the same: half of it is written",
         "sync": "fsync, fdatasync", "close": "close of a file that was written", "rename": "rename, renameat, unlink, remove",
         "open": "open, openat, fopen for writing", "mkdir": "mkdir", "truncate": "ftruncate",
         "mpi": "MPI calls, of C and Fortran", "hdf5": "HDF5 calls that dovetail makes", "mumps": "dmumps_c says INFO(1) = -9 or -13"}
SECONDS = 60  # for a run that takes one
CRASH = re.compile(r"Caught signal|Segmentation|Signal: |terminate called|free\(\): |malloc\(\): |corrupted|Assertion .* failed")
BEGINNING = 3  # points that are soon made again
NAMED = [0.85, 0.95, 1.05, 1.15, 1.25]  # frequencies that every path through the curve has [rad/s]
SOLUTION = {"coefficients", "omega", "contact/stick", "contact/slip", "contact/open", "contact/dissipation", "stick", "slip", "open"}
ACCURACY = 1e-8  # of the largest number of a table
ROUGH = 1e-3  # of estimates, which come from linear solves in single precision


@dataclass
class Trial:
    """The k-th call of a kind on one rank fails. What came of it: a verdict, "" where all is well, and the evidence."""

    scene: "Scene"
    kind: str
    rank: int
    k: int
    verdict: str = ""
    why: str = ""
    status: int = 0
    said: list = field(default_factory=list)
    call: str = ""  # what failed, with its callers


class Scene:
    """A folder with a case, and the run of it that must come out in the end.

    fresh: the first run in its folder. again: another run, which ended well, is there. restart: a run is continued.
    """

    def __init__(self, name, program, library, folder, ranks):
        self.name, self.program, self.library, self.ranks = name, program, library, ranks
        self.options = ["--restart"] if name == "restart" else []
        self.start, solver = folder / f"{name}{ranks}", "assembled" if name == "restart" else "modal"
        case = chain.write(self.start, 4, harmonics=3, solver=solver, omega=(0.8, 1.3), at=NAMED)
        text = case.read_text()
        self._finish(self.start, "whole")
        self.points, self.events = read(self.start / "whole" / "results.h5")
        earlier = {"again": text.replace("modes = 3", "modes = 2"),
                   "restart": text.replace("max_points = 20000", "max_points = 4")}.get(name)
        if earlier:
            case.write_text(earlier)
            self._finish(self.start, "out")
            case.write_text(text)
        self.before = read(self.start / "out" / "results.h5")[0] if earlier else None
        self.run_before = run_name(self.start)

    def _finish(self, folder, out):
        status, said = self.run(folder, out, [])
        assert status == 0, said

    def run(self, folder, out, options, **faults):
        """Exit status (None: it hangs) and stderr."""
        sessions = folder / "ompi"
        sessions.mkdir(exist_ok=True)
        with_fault = {"LD_PRELOAD": str(self.library), "FAULT_FOLDER": str(folder / out)} | faults if faults else {}
        mpirun = ["mpirun", "-n", str(self.ranks)] if self.ranks > 1 else []
        preload = ["env", *(f"{name}={value}" for name, value in with_fault.items())]
        command = [*mpirun, *preload, str(self.program), "run", str(folder / "case.toml"), "--out", str(folder / out), *options]
        process = subprocess.Popen(command, env=SURROUNDINGS | {"OMPI_MCA_orte_tmpdir_base": str(sessions), "OMPI_MCA_pml": "ob1"},
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace", start_new_session=True)
        try:
            said = process.communicate(timeout=SECONDS)[1]
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return None, process.communicate()[1]
        return process.returncode, said

    def copy(self, folder):
        shutil.copytree(self.start, folder, ignore=shutil.ignore_patterns("whole", "ompi"))
        return folder

    def count(self, folder):
        """How many calls of each kind every rank makes: a list of dictionaries."""
        log = self.copy(folder) / "log"
        status, said = self.run(folder, "out", self.options, FAULT_LOG=str(log))
        assert status == 0, said
        lines = sorted(line.split() for line in log.read_text().splitlines())
        return [dict(zip(line[2::2], map(int, line[3::2]))) for line in lines]

    def attempt(self, trial, folder):
        """Lets the call fail in a copy of the folder, and judges."""
        log = self.copy(folder) / "log"
        trial.status, said = self.run(folder, "out", self.options, FAULT_LOG=str(log), FAULT_KIND=trial.kind, FAULT_AT=str(trial.k),
                                      FAULT_RANK=str(trial.rank))
        trial.call = log.read_text() if log.exists() else ""
        trial.said = [line for line in said.splitlines() if line.startswith("dovetail: ") and ": note:" not in line]
        try:
            trial.verdict, trial.why = self.judge(trial, folder, said)
        except (OSError, KeyError, AssertionError) as error:
            trial.verdict, trial.why = "loss", str(error)

    def judge(self, trial, folder, said):
        if trial.status is None:
            return "hang", said[-500:]
        if not trial.call and trial.status:
            return "status", f"status {trial.status}, though no call failed: {said[:500]}"
        other_steps = trial.kind in ("alloc", "mumps")  # a factorisation that fails halves one
        self.check_kept(folder, other_steps)
        if trial.status == 0:
            try:
                self.check_whole(folder, other_steps)
            except (OSError, KeyError, AssertionError) as error:
                return "silent", str(error)
        self.recover(folder, other_steps)
        crash = CRASH.search(said)
        if crash or trial.status < 0 or trial.status > 128:
            return "told" if trial.said else "crash", said[crash.start() if crash else 0:][:500]
        if trial.status not in (0, 2, 3):
            return "status", f"status {trial.status}: {said[:500]}"
        if trial.status and not trial.said:
            return "mute", said[:500]
        return "", ""

    def check_kept(self, folder, other_steps):
        """Results there are readable and right as far as they go, and no fewer than before."""
        results = folder / "out" / "results.h5"
        if not results.exists():
            assert self.before is None, "results of before are gone"
            return
        points, _ = read(results)
        if self.before is not None and self.name == "again" and run_name(folder) == self.run_before:
            compare(points, self.before, "the run of before")
            return
        count = len(points["omega"])
        assert count >= (len(self.before["omega"]) if self.name == "restart" else 1), f"{count} points"
        compare(points, {name: values[:count] for name, values in self.points.items()}, "what was computed", other_steps)

    def check_whole(self, folder, other_steps):
        points, events = read(folder / "out" / "results.h5")
        assert {*NAMED, self.points["omega"][-1]} <= {*points["omega"]}, "the branch is not whole"
        if compare(points, self.points, "the branch", other_steps):
            compare(events, self.events, "the events")

    def recover(self, folder, other_steps):
        """The run is continued, or begun anew where it had not come to a second point; then all is there."""
        out = folder / "out"
        results = out / "results.h5"
        ours = results.exists() and (self.name != "again" or run_name(folder) != self.run_before)
        known = ours and ((out / "state.h5").exists() or len(read(results)[0]["omega"]) > BEGINNING)
        for _ in range(30):  # mpirun may end before the last rank does
            status, said = self.run(folder, "out", ["--restart"] if known else [])
            if "another run is writing there" not in said:
                break
            time.sleep(1)
        assert status == 0, f"afterwards: status {status}: {said[said.find('dovetail: '):][:500]}"
        self.check_whole(folder, other_steps)


def read(results):
    """Points and events of a results file: all whole."""
    with h5py.File(results, "r") as file:
        points = {name: values[()] for name, values in tables(file).items()}
        events = {name: values[()] for name, values in file["events"].items()}
    count = len(points["omega"])  # grows last
    return ({name: values[:count] for name, values in points.items()},
            {name: values[:len(events["omega"])] for name, values in events.items()})


def run_name(folder):
    results = Path(folder) / "out" / "results.h5"
    if not results.exists():
        return None
    with h5py.File(results, "r") as file:
        return file.attrs["run"]


def compare(found, wanted, what, other_steps=False):
    """Everything where both took the same steps; where they need not, solutions at frequencies that both passed."""
    assert found.keys() == wanted.keys(), f"{what}: {found.keys() ^ wanted.keys()}"
    effort = {"newton_iterations", "linear_iterations"} if other_steps else set()
    names, rows, others = wanted.keys() - {"seconds", "residual"} - effort, slice(None), slice(None)
    same_steps = "omega" not in wanted or np.shape(found["omega"]) == np.shape(wanted["omega"]) and np.allclose(
        found["omega"], wanted["omega"], rtol=ACCURACY)
    if not same_steps:
        assert other_steps, f"{what}: other steps"
        names, rows = SOLUTION, np.isin(found["omega"], NAMED)
        others = np.isin(wanted["omega"], found["omega"][rows])
        assert all(np.isfinite(found[name]).all() for name in names), f"{what}: not finite"
    for name in names:
        a, b = found[name][rows], wanted[name][others]
        assert a.shape == b.shape, f"{what}: {name}: {a.shape}, not {b.shape}"
        scale = np.nanmax(np.abs(b), initial=1e-300)
        near = np.allclose(a, b, rtol=0, atol=(ROUGH if name.startswith("error_") else ACCURACY) * scale, equal_nan=True)
        assert near, f"{what}: {name} differs by {np.nanmax(np.abs(a - b)) / scale:.3g}"
    return same_steps
