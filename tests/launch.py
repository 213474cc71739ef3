"""Starts the program in the surroundings that scripts/environment gives, and reads what it leaves.

The program is $DOVETAIL, or build/dovetail.
"""

import json
import os
import signal
import subprocess
import time
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from dovetail import Results

ROOT = Path(__file__).resolve().parents[1]
BINARY = Path(os.environ.get("DOVETAIL", ROOT / "build" / "dovetail"))
SURROUNDINGS = os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMP_NUM_THREADS": "1",
                             "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_mpi_yield_when_idle": "1",
                             "OMPI_MCA_hwloc_base_binding_policy": "none", "OMPI_MCA_pml": "ob1",
                             "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe", "PRTE_MCA_hwloc_default_binding_policy": "none",
                             "PYTHONPATH": f"{ROOT}/python:{ROOT}/tests:{ROOT}/build/extras"}
SECONDS = int(os.environ.get("DOVETAIL_TEST_SECONDS", 300))  # far more than any run needs, also beside ten other jobs


@dataclass
class Done:
    """How a run ended: both texts, and the folder of its files."""

    out: str
    err: str
    folder: Path

    @property
    def points(self):
        return read_points(self.folder)

    @property
    def summary(self):
        return json.loads((self.folder / "summary.json").read_text(), parse_constant=refuse_constant)


def refuse_constant(word):
    raise ValueError(f"{word} is no JSON, though Python reads it")


def read_points(folder):
    """Every dataset under /points, whole, such as "omega" and "contact/slip"; opened as any user would."""
    with h5py.File(folder / "results.h5", "r") as file:
        return {name: values[()] for name, values in tables(file).items()}


def finite(points):
    """Whether every number is one, but for estimates between points where no two steps led there, and states of motions in time."""
    unknown = ("error_between", "state")
    return all(np.isfinite(values).all() or name in unknown and not np.isinf(values).any() for name, values in points.items())


def tables(file):
    """The datasets under /points of an open results file, by name."""
    names = [name for name in file["points"] if name != "contact"] + [f"contact/{name}" for name in file["points/contact"]]
    return {name: file["points"][name] for name in names}


def line(case, *options, ranks=None, command="run", out=None):
    """The command and the folder of its files: `out` beside the case file. Without `ranks`, without mpirun."""
    folder = case.path.parent / (out or "")
    mpirun = ["mpirun", "-n", str(ranks)] if ranks else []
    return [*mpirun, str(BINARY), command, str(case.path), "--out", str(folder), *map(str, options)], folder


def run(case, *options, status=0, prefix=(), **where):
    """Runs a case to its end and checks the exit status; `where`: keywords of `line`."""
    command, folder = line(case, *options, **where)
    return Done(*words_of([*prefix, *command], status), folder)


def words_of(command, status=0):
    """What a command says on stdout and stderr. A run that hangs is ended, with its ranks."""
    process = subprocess.Popen(command, env=SURROUNDINGS, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        out, err = process.communicate(timeout=SECONDS)
    except subprocess.TimeoutExpired:
        kill(process)
        raise
    told = f"{' '.join(map(str, command))} ended with {process.returncode}\n{out}\n{err}"
    assert process.returncode == status, told
    assert "PETSC ERROR" not in err and "Segmentation" not in err, told
    return out, err


def in_parts(case, stops, most=10**6):
    """The results of a run of a case file that was stopped after each of these numbers of points and restarted, up to `most` points."""
    text = case.read_text()
    for i, points in enumerate([*stops, most]):
        case.write_text(text + f"max_points = {points}\n")
        restart = ["--restart"] if i else []
        subprocess.run([BINARY, "run", case, "--out", case.parent / "parts", *restart], stdout=subprocess.DEVNULL, check=False)
    case.write_text(text)
    return Results(case.parent / "parts/results.h5")


@contextmanager
def going(case, *options, **where):
    """A run under way, as its process and the folder of its files; killed at the end, whatever happens meanwhile."""
    command, folder = line(case, *options, **where)
    process = subprocess.Popen(command, env=SURROUNDINGS, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield process, folder
        assert process.poll() is None, f"the run ended of itself, with {process.returncode}"
    finally:
        kill(process)


@contextmanager
def held(process):
    """The process stands still, wherever it is, for one look at its files."""
    process.send_signal(signal.SIGSTOP)
    wait_for(lambda: state(process.pid) == "T", "a halt")
    yield
    process.send_signal(signal.SIGCONT)


def kill(process):
    """SIGKILL to the program: the process itself, or under mpirun every rank; returns when all are gone."""
    ranks = children(process.pid)
    for rank in ranks:
        with suppress(ProcessLookupError):  # mpirun may have ended it, as another one is gone
            os.kill(rank, signal.SIGKILL)
    if not ranks:
        process.kill()
    try:
        process.wait(SECONDS)
    except subprocess.TimeoutExpired:
        process.kill()
        raise
    for rank in ranks:  # mpirun ends at the first one lost: the others may still hold files
        wait_for(lambda: gone(rank), f"the end of rank {rank}")


def state(process):
    """The letter by which /proc tells what a process does, Z for one that only waits to be counted; "" for one that is no more."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except OSError:
        return ""


def gone(process):
    """Whether it has ended, and with it all that it held."""
    return state(process) in ("", "Z")


def children(parent):
    """Process ids of this program's ranks below a process."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            name, fields = entry.read_text().rsplit(")", 1)
        except OSError:  # ended meanwhile
            continue
        if int(fields.split()[1]) == parent and name.endswith("(" + BINARY.name[:15]):
            found.append(int(entry.parent.name))
    return found


def wait_for(condition, what):
    """Until condition() is true; fails after SECONDS."""
    end = time.monotonic() + SECONDS
    while not condition():
        assert time.monotonic() < end, f"waited in vain for {what}"
        time.sleep(0.005)
