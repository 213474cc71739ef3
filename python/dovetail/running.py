"""Runs from Python: `dovetail.run`, and the changed copies of a case that it and `dovetail.Study` start."""

from __future__ import annotations

import copy
import os
import subprocess
import sys
from pathlib import Path

from .case_runs import COPY, need_own
from .results import Results
from .study_runs import CaseFile, Program, RunFailed, reason_in, toml

LAUNCHED = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK")  # in the surroundings of what mpirun or srun has started
ANSWER = "results.h5"


class GivenCase(CaseFile):
    """A case file, or a dict as if parsed from one whose files are named from the working directory, with changes.

    changes : values by key, as "contact.friction"; None leaves the key, or section, out. Files among them are named from where those of
    the case are.
    """

    def __init__(self, case, changes=()):
        if isinstance(case, dict):
            self.path, self.content = Path("case.toml"), copy.deepcopy(case)
        else:
            super().__init__(case)
        for key, value in dict(changes).items():
            *section, name = key.split(".")
            place = self.content.setdefault(section[0], {}) if section else self.content
            if len(section) > 1 or not name or not isinstance(place, dict):
                raise ValueError(f"{key}: no key of a case file; wanted is one such as contact.friction")
            if isinstance(value, dict):
                raise ValueError(f"{key}: a table would replace all that the case has there; change each key by its name, such as "
                                 f"{key}.{next(iter(value), 'friction')}")
            if value is None:
                place.pop(name, None)
            else:
                place[name] = value

    def text(self, folder):
        """A copy that lies in `folder` and leaves its results there."""
        content = self.moved(folder)
        content.get("output", {}).pop("directory", None)
        return COPY + toml(content)


def need_no_launcher():
    """Refuses to start runs from a script that mpirun has started, where every rank would start one."""
    if any(name in os.environ for name in LAUNCHED):
        raise ValueError("this script was itself started by mpirun, or srun; start it alone, and name the ranks of the run: "
                         "dovetail.run(case, ranks=4)")


def run(case: str | os.PathLike | dict, ranks: int | None = None, out: str | os.PathLike | None = None, *, progress: bool = False,
        binary: str | os.PathLike | None = None, **changes) -> Results:
    """Run a case to its end.

    Parameters
    ----------
    case : path-like or dict
        A case file, or what one would hold: {"model": "model.h5", "contact": {"friction": 0.3}, ...}, with files named from the working
        directory.
    ranks : int, optional
        Processes, by mpirun; default: one, without it.
    out : path-like, optional
        Folder of the results. Needed with a dict or with changes, of which the folder gets its `case.toml`; default: what the case says.
    progress : bool
        Print what the program says as it says it. Default: nothing.
    binary : path-like, optional
        The program; default: build/dovetail of this source tree, or dovetail on the path.
    **changes
        Values by key of the case file, in its units: run("case.toml", out="a", **{"contact.friction": 0.3}). None leaves a key, or a
        whole section, out. Files are named from where those of the case are.

    Returns
    -------
    Results

    Raises
    ------
    RunFailed
        With the program's message; its `status` is 2 where the input is wrong, 3 where the computation could not go on.
    ValueError
        Where nothing was started: no program, a script that mpirun has started, no folder.
    """
    need_no_launcher()
    program, given = Program(binary, ranks), GivenCase(case, changes)
    file, folder = given.path, Path(out) if out else file_folder(given)
    if isinstance(case, dict) or changes:
        if out is None:
            raise ValueError("name a folder for the results of a changed case: out=...")
        need_own(folder)
        text = given.text(folder)
        folder.mkdir(parents=True, exist_ok=True)
        file = folder / "case.toml"
        file.write_text(text, encoding="utf-8")
    process = program.start(file, subprocess.PIPE, "--out", str(folder))
    status, said = _heard(process, progress)
    if status != 0:
        raise RunFailed(reason_in(said) if status > 0 else f"ended by signal {-status}", status)
    return Results(folder / ANSWER)


def file_folder(given):
    """Where a run of the case as it stands leaves its results."""
    return given.path.parent / given.content.get("output", {}).get("directory", "")


def _heard(process, progress):
    """The exit status, and all that a process says, printed as well if asked for. It is ended when the caller breaks off."""
    said = []
    try:
        with process.stdout:
            for line in process.stdout:
                said.append(line.decode(errors="replace"))
                if progress:
                    print(said[-1], end="", flush=True, file=sys.stdout)
        return process.wait(), "".join(said)
    finally:
        if process.poll() is None:
            process.terminate()
            process.wait()
