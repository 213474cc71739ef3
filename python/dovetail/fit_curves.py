"""Measured response curves, and what a fit makes of them: a run for each, which goes over the measured frequencies."""

import copy
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .fit_search import Search, changes_of, under
from .measured import read_measured
from .study_runs import RunFailed


@dataclass
class FittedCurve:
    """One of the measured curves.

    force : factor on the loads of the case
    model : (m,) amplitudes of the fit at the measured frequencies, NaN where its curve does not come
    misfit : root mean square of the relative errors
    beyond : (case, measured) sweeps in the unit of the case, where the second reaches beyond the first, else None
    curve, start : `curves.Response` of the fit and of the case as it stands, under that force
    """

    file: Path
    force: float
    measured: object
    model: np.ndarray
    misfit: float
    beyond: tuple | None
    curve: object
    start: object


class CurveSearch(Search):
    """Of one response curve. `force`: factor on the loads of the case with which it was measured; `at`: frequencies within the sweep."""

    def __init__(self, runs, unknowns, measured, at, harmonic, force=1.0, name=""):
        super().__init__(unknowns, measured.amplitude, name)
        self.runs, self.measured, self.harmonic, self.force = runs, measured, harmonic, force
        self.at, self.seen = [float(value) for value in at], {}

    def digest(self, results):
        """Amplitudes of each passage of each measured frequency."""
        response = results.response(self.runs.dof)
        values = response.amplitude if self.harmonic is None else response.harmonic(self.harmonic)
        return {"passes": [values[np.abs(results.omega - omega) <= 1e-9 * omega].tolist() for omega in self.measured.omega]}

    def records(self, places):
        keys = [tuple(np.round(x, 12).tolist()) for x in places]
        missing = [key for key in dict.fromkeys(keys) if key not in self.seen]
        size = len(self.runs.contact["law"])
        wanted = [under(self.force, changes_of(self.unknowns, np.exp(key), size)) for key in missing]
        if wanted:
            self.seen.update(zip(missing, self.runs.each(wanted, self.digest, at=self.at, key=f"fit, harmonic {self.harmonic}")))
        return [self.seen[key] for key in keys]

    def passes(self, record):
        return record["passes"]


class CurvesToFit:
    """The measured files, each with a factor on the loads, and their searches."""

    def __init__(self, runs, results, unknowns, files, harmonic, forces):
        self.runs, self.results, self.files = runs, results, files
        measured = [read_measured(file, results.unit) for file in files]
        count = sum(len(curve.omega) for curve in measured)
        if count <= len(unknowns):
            raise ValueError(f"{', '.join(map(str, files))}: has {count} frequencies, {len(unknowns)} parameters need more than that")
        self.beyond, self.searches = [], []
        for file, curve, force in zip(files, measured, forces):
            in_case = results.unit.hertz(curve.omega) if runs.case.content["continuation"].get("unit") == "Hz" else curve.omega
            self.beyond.append(outside(file, in_case, runs.case))
            first, last = runs.case.content["continuation"]["omega"]
            ordered = np.asarray(in_case)[::1 if first < last else -1]
            own = copy.copy(runs)
            own.case = copy.deepcopy(runs.case)
            own.case.content["continuation"]["omega"] = [float(ordered[0]), float(ordered[-1])]
            self.searches.append(CurveSearch(own, unknowns, curve, ordered[1:-1], harmonic, force, file.name if len(files) > 1 else ""))

    @property
    def count(self):
        """Of runs."""
        return sum(len(search.seen) for search in self.searches)

    def outcome(self, x, changes, misfits):
        """What a `Fit` has of it: `curves`, a FittedCurve for each file."""
        return {"curves": [FittedCurve(file, search.force, search.measured, search.values(x), misfit, beyond,
                                       _curve(search.runs, self._folder("fitted", i), under(search.force, changes)),
                                       self.results.response(self.runs.dof) if search.force == 1 else
                                       _curve(self.runs, self._folder("case", i), under(search.force, {})))
                           for i, (file, search, misfit, beyond) in enumerate(zip(self.files, self.searches, misfits, self.beyond))]}

    def _folder(self, name, i):
        """Of a run that is kept."""
        return name if len(self.files) == 1 and name == "fitted" else f"{name}_{i + 1}"


def _curve(runs, name, changes):
    run, results = runs.whole(name, changes)
    if results is None:
        raise RunFailed(f"{runs.folder / name}: the curve could not be computed: {run.reason}")
    return results.response(runs.dof)


def outside(file, in_case, case):
    """(case, measured) sweeps where the measured one reaches beyond that of the case, else None; refuses two without overlap."""
    low, high = sorted(case.content["continuation"]["omega"])
    unit = case.content["continuation"].get("unit", "")
    words = (f"{file}: measured from {in_case.min():.6g} to {in_case.max():.6g}, "
             f"{case.path}: continuation.omega from {low:g} to {high:g} {unit}")
    if in_case.min() > high or in_case.max() < low:
        raise ValueError(f"{words.rstrip()}: wanted are frequencies that the sweep of the case has")
    slack = 1e-9 * high
    return None if low - slack <= in_case.min() and in_case.max() <= high + slack else ((low, high), (in_case.min(), in_case.max()))
