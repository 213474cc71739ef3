"""Studies from Python: a case with a grid of values of any of its keys, each computed once and kept."""

from __future__ import annotations

import functools
import hashlib
import itertools
import math
import os
import sys
from pathlib import Path

from .case_runs import Progress, largest_peak, need_own
from .checked import whole_number
from .frames import frame
from .results import Results
from .running import ANSWER, GivenCase, need_no_launcher
from .study_runs import Program, Run, compute, hash_of

MOST = 100_000  # runs: their folders and case files are made ready at once
NAME = 12  # characters of the fingerprint that name the folder of a run


class Study:
    """A case with every combination of some values of its keys.

        study = dovetail.Study("case.toml", {"contact.friction": [0.1, 0.2, 0.3], "harmonic_balance.harmonics": [3, 5]})
        table = study.run(jobs=2).to_frame()

    What was computed stays in the folder, and is taken over by a later study with the same case, files and program, also where its
    grid is another one.

    Parameters
    ----------
    case : path-like or dict
        As for `dovetail.run`.
    values : dict
        Lists of values by key, in units of the case file; None leaves the key out. Files are named from where those of the case are.
    out : path-like, optional
        Folder of the runs; default: CASE_runs beside the case. Needed for a dict.
    ranks : int, optional
        Processes of each run, by mpirun.
    binary : path-like, optional

    Attributes
    ----------
    settings : list of dict
        Value by key of every run, the last key fastest.
    results : list of Results or None
        In the same order; None where a run has failed or has not been done yet.
    """

    def __init__(self, case: str | os.PathLike | dict, values: dict, out: str | os.PathLike | None = None, ranks: int | None = None,
                 binary: str | os.PathLike | None = None):
        if out is None and isinstance(case, dict):
            raise ValueError("name a folder for the runs of a case that is no file: out=...")
        if not isinstance(values, dict):
            raise ValueError(f"values must be a dict with a list of values by key, found {values!r}")
        for key, some in values.items():
            if isinstance(some, (str, bytes)) or not hasattr(some, "__len__") or not len(some):
                raise ValueError(f"{key}: wanted is a list of values, found {some!r}")
        if (count := math.prod(map(len, values.values()))) > MOST:
            raise ValueError(f"every combination of these values makes {count} runs, more than {MOST}; take fewer values")
        self.folder = Path(out) if out else Path(case).with_name(f"{Path(case).stem}_runs")
        self.settings = [dict(zip(values, each)) for each in itertools.product(*values.values())]
        self._program, self._values = Program(binary, ranks), values
        hashed = functools.cache(hash_of)  # most settings name the same files
        self._runs = [self._run(GivenCase(case, setting), setting, hashed) for setting in self.settings]

    def _run(self, given, setting, hashed):
        text = given.text(self.folder / "run")  # all folders of runs lie as deep
        fingerprint = hashlib.sha256("\n".join([text, self._program.hash, *map(hashed, given.files().values())]).encode()).hexdigest()
        return Run(setting, self.folder / fingerprint[:NAME], text, fingerprint)

    def run(self, jobs: int = 1, progress: bool = True) -> Study:
        """Does the runs that are not there yet, `jobs` at a time; a line on stderr now and then unless `progress` is False.

        Returns the study itself. A run that could not go on is kept with its reason; wrong input raises ValueError, as all other runs
        of that key are likely to be wrong, too.
        """
        need_no_launcher()
        whole_number(jobs, "jobs", 1)
        waiting = list({run.fingerprint: run for run in self._runs if not run.recall()}.values())
        if progress and len(waiting) < len(self._runs):
            print(f"study: {len(self._runs) - len(waiting)} of {len(self._runs)} runs are there from before", file=sys.stderr)
        for run in waiting:
            need_own(run.folder)
        lines = Progress("study" if progress else "", len(waiting), jobs)
        for run in compute(waiting, self._program, jobs, self._reduced):
            if run.status == 2:
                raise ValueError(f"{words_of(run.setting)}: {run.reason}")
            lines.tell(run.seconds)
        for run in self._runs:
            run.recall()
        return self

    def _reduced(self, _):
        """The reduced file of a run that is there; the program takes it if it fits."""
        return next((file for run in self._runs if run.status == 0 and (file := run.folder / "reduced.h5").is_file()), None)

    @property
    def results(self) -> list:
        return [Results(run.folder / ANSWER) if run.status == 0 or run.recall() and run.status == 0 else None for run in self._runs]

    def columns(self, dof: str | None = None) -> dict:
        """One entry per run in every list: the keys; `status`, `reason`, `seconds`; `points`; `peak`, the largest amplitude of `dof` (by
        default what is watched), half the peak-to-peak, `peak_at`, the frequency [rad/s] or parameter there, and `inside`, whether it
        is a peak and no end of the curve. None where a run has failed or has not been done."""
        table = {key: [setting[key] for setting in self.settings] for key in self._values}
        found = [self._row(run, results, dof) for run, results in zip(self._runs, self.results)]
        return table | {name: [row[name] for row in found] for name in found[0]}

    @staticmethod
    def _row(run, results, dof):
        row = {"status": run.status, "reason": run.reason, "seconds": run.seconds}
        peak = largest_peak(results, dof or results.watched) if results is not None and len(results) else None
        values = (len(results), peak["amplitude"], peak["omega"], peak["peak"]) if peak else (None,) * 4
        return row | dict(zip(("points", "peak", "peak_at", "inside"), values))

    def to_frame(self, dof: str | None = None):
        """`columns` as a pandas.DataFrame. Raises ImportError where there is no pandas."""
        return frame(self.columns(dof))


def words_of(setting):
    """A setting in words."""
    return ", ".join(f"{key} = {value}" for key, value in setting.items()) or "the case as it stands"
