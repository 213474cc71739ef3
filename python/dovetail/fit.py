"""Parameters of a joint from a measured response curve: least squares of relative errors, with what the curve leaves open."""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.special import stdtrit

from .case_changes import CONTACT, need, need_damping, split
from .case_runs import CaseRuns, CurveCase
from .fit_report import write
from .measured import read_measured
from .motion import find_joint
from .study_runs import Program, RunFailed

USUAL = ("friction", "tangential_stiffness")
STEP = 1e-3  # of the logarithm of a parameter, for derivatives
NOISE = 1e-8  # of amplitudes: two runs agree no better, for Newton's method stops there and sums are rounded
WIDEST = np.log(100.0)  # a factor beyond is no fit
MISSED = 1.0  # error, as a logarithm, where a curve has no point at a frequency, or could not be computed
CONFIDENCE = 0.95
EVALUATIONS = 40


@dataclass(frozen=True)
class Unknown:
    """A factor that is looked for, on what the case has: of a parameter, maybe at the points of one joint alone, (k,) numbers."""

    name: str
    joint: str = ""
    points: np.ndarray | None = None

    def __str__(self):
        return f"{self.name} of {self.joint}" if self.joint else self.name


@dataclass
class Fit:
    """What `fit` finds.

    unknowns : list of Unknown
    factor : (p,); deviation (p,) standard deviation of its logarithm, correlation (p, p)
    low, high : (p,) ends of the confidence interval of the factor
    model : (m,) amplitudes of the fit at the measured frequencies, NaN where its curve does not come
    misfit : root mean square of the relative errors
    curve, start : `curves.Response` of the fit and of the case as it stands
    """

    case: object
    file: Path
    dof: str
    unit: object
    length: str
    measured: object
    harmonic: int | None
    contact: dict
    unknowns: list
    factor: np.ndarray
    deviation: np.ndarray
    correlation: np.ndarray
    low: np.ndarray
    high: np.ndarray
    model: np.ndarray
    misfit: float
    runs: int
    converged: bool = True
    beyond: tuple | None = None  # (case, measured) sweeps in the unit of the case, where the second reaches beyond the first
    curve: object = None
    start: object = None

    @property
    def undetermined(self):
        """Numbers of the unknowns that the curve hardly depends on: their interval is wider than a factor of 10 to either side."""
        return [i for i in range(len(self.factor)) if self.high[i] / self.factor[i] >= 10]

    @property
    def at_limit(self):
        """Numbers of the unknowns whose search ended at the widest factor."""
        return [i for i, factor in enumerate(self.factor) if limited(np.log(factor))]

    @property
    def changes(self):
        return changes_of(self.unknowns, self.factor, len(self.contact["law"]))


def fit(arguments):
    """The command: refuses wrong input, runs, writes and prints the report."""
    names = tuple(dict.fromkeys(arguments.parameters or USUAL))
    if arguments.jobs < 1:
        raise ValueError(f"--jobs {arguments.jobs}: must be at least 1")
    if arguments.harmonic is not None and arguments.harmonic < 1:
        raise ValueError(f"--harmonic {arguments.harmonic}: must be at least 1")
    keys = [split(name)[0] for name in names]
    if len(set(keys)) < len(keys) and any(split(name)[1] == slice(None) for name in names if keys.count(split(name)[0]) > 1):
        raise ValueError(f"--parameters {' '.join(names)}: one of them is part of another")
    case = CurveCase(arguments.case, None, arguments.watch)
    if "damping" in names:
        need_damping(case.content)
    program = Program(arguments.binary)
    program.check(case.path)
    out = Path(arguments.out) if arguments.out else case.path.with_name(case.path.stem + "_fit")
    try:
        found = fitted(CaseRuns(case, program, out, arguments.jobs), Path(arguments.measured), names, arguments.by_joint,
                       arguments.harmonic)
    except KeyboardInterrupt:
        raise RunFailed(f"broken off; what was computed is in {out}, and the same command goes on from there") from None
    write(found, out)


def fitted(runs, file, names, by_joint=False, harmonic=None):
    """The Fit of a CaseRuns to a measured file."""
    results = runs.begin()
    for name in names:
        need(name, runs.contact)
    measured = read_measured(file, results.unit)
    unknowns = unknowns_of(results, names, by_joint)
    if len(measured.omega) <= len(unknowns):
        raise ValueError(f"{file}: has {len(measured.omega)} frequencies, {len(unknowns)} parameters need more than that")
    if harmonic and harmonic > results.harmonics:
        raise ValueError(f"--harmonic {harmonic}: the case has {results.harmonics}")
    start = results.response(runs.dof)
    in_case = results.unit.hertz(measured.omega) if runs.case.content["continuation"].get("unit") == "Hz" else measured.omega
    beyond = outside(file, in_case, runs.case)
    first, last = runs.case.content["continuation"]["omega"]
    ordered = np.asarray(in_case)[::1 if first < last else -1]
    runs.case.content["continuation"]["omega"] = [float(ordered[0]), float(ordered[-1])]
    search = Search(runs, unknowns, measured, ordered[1:-1], harmonic)
    solution = least_squares(search.errors, np.zeros(len(unknowns)), search.derivative, bounds=(-WIDEST, WIDEST), xtol=1e-5, ftol=1e-8,
                             max_nfev=EVALUATIONS)
    if search.failed(solution.x):
        raise RunFailed(f"{runs.case.path}: the case could not be computed with any parameters that were tried")
    there = np.isfinite(search.amplitudes(solution.x))
    deviation, correlation = uncertainty(solution.fun[there], solution.jac[there])
    free = np.count_nonzero(there) - len(unknowns)
    width = stdtrit(free, (1 + CONFIDENCE) / 2) * deviation if free > 0 else deviation
    width = np.where(limited(solution.x) | (solution.status == 0), np.nan, width)
    with np.errstate(over="ignore"):
        found = Fit(runs.case, file, runs.dof, results.unit, results.unit_of(runs.dof), measured, harmonic, runs.contact, unknowns,
                    np.exp(solution.x), deviation, correlation, np.exp(solution.x - width), np.exp(solution.x + width),
                    search.amplitudes(solution.x), float(np.sqrt(np.mean(solution.fun**2))), len(search.seen),
                    bool(solution.status != 0), beyond)
    found.start = start
    run, best = runs.whole("fitted", found.changes)
    if best is None:
        raise RunFailed(f"{runs.folder / 'fitted'}: the curve of the fit could not be computed: {run.reason}")
    found.curve = best.response(runs.dof)
    return found


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


def limited(x):
    """Whether logarithms of factors lie at the end of what is searched; the search stays inside by a little."""
    return np.abs(x) > 0.99 * WIDEST


def unknowns_of(results, names, by_joint):
    """An Unknown for each name, or, of the joint's parameters, for each joint."""
    if not by_joint:
        return [Unknown(name) for name in names]
    joint = find_joint(results)
    found = []
    for name in names:
        if name not in CONTACT:
            found.append(Unknown(name))
            continue
        for number in np.unique(joint["joint"]):
            found.append(Unknown(name, joint["names"][number], np.flatnonzero(joint["joint"] == number)))
    return found


def changes_of(unknowns, factors, points):
    """Changes as for `case_changes.apply`, by (p,) factors; `points`: contact points of the case."""
    changes = {}
    for unknown, factor in zip(unknowns, factors):
        if unknown.points is None:
            changes[unknown.name] = ("factor", float(factor))
        else:
            _, each = changes.setdefault(unknown.name, ("factor", np.full(points, np.nan)))
            each[unknown.points] = factor
    return changes


class Search:
    """Errors by the logarithms x of the factors, and their derivatives by differences."""

    def __init__(self, runs, unknowns, measured, at, harmonic):
        self.runs, self.unknowns, self.measured, self.harmonic = runs, unknowns, measured, harmonic
        self.at, self.seen = [float(value) for value in at], {}

    def digest(self, results):
        """Amplitudes of each passage of each measured frequency."""
        response = results.response(self.runs.dof)
        values = response.amplitude if self.harmonic is None else response.harmonic(self.harmonic)
        return {"passes": [values[np.abs(results.omega - omega) <= 1e-9 * omega].tolist() for omega in self.measured.omega]}

    def records(self, places):
        """Those of some x, computed together."""
        keys = [tuple(np.round(x, 12).tolist()) for x in places]
        missing = [key for key in dict.fromkeys(keys) if key not in self.seen]
        size = len(self.runs.contact["law"])
        wanted = [changes_of(self.unknowns, np.exp(key), size) for key in missing]
        if wanted:
            self.seen.update(zip(missing, self.runs.each(wanted, self.digest, at=self.at, key=f"fit, harmonic {self.harmonic}")))
        return [self.seen[key] for key in keys]

    def failed(self, x):
        return self.records([x])[0]["status"] != 0

    def amplitudes(self, x):
        """(m,) of the passage nearest to what was measured, NaN where there is none."""
        return self._nearest(self.records([x])[0])

    def errors(self, x):
        """(m,) logarithms of computed over measured amplitudes: relative errors."""
        found = self._errors(self.records([x])[0])
        print(f"  relative error {np.sqrt(np.mean(found**2)):.3g} with " + ", ".join(f"{unknown} {factor:.4g}x" for unknown, factor in zip(
            self.unknowns, np.exp(x))), file=sys.stderr)
        return found

    def derivative(self, x):
        """(m, p); where x or the place beside it alone has a point, from the other side, and 0 where that does not help.

        Differences within the noise count as 0: divided by them, the search would go anywhere."""
        steps = STEP * np.eye(len(x))
        here, *beside = self.records([x, *(x + step for step in steps)])
        met = np.isfinite(self._nearest(here))
        columns = []
        for step, record in zip(steps, beside):
            both = met & np.isfinite(self._nearest(record))
            column = np.where(both, self._errors(record) - self._errors(here), 0.0)
            if np.any(met & ~both):
                [other] = self.records([x - step])
                back = np.where(np.isfinite(self._nearest(other)), self._errors(here) - self._errors(other), 0.0)
                column = np.where(met & ~both, back, column)
            columns.append(np.where(np.abs(column) > NOISE, column, 0.0) / STEP)
        return np.column_stack(columns)

    def _nearest(self, record):
        if record["status"] != 0:
            return np.full(len(self.measured.omega), np.nan)
        return np.array([min(values, key=lambda value: abs(np.log(value / wanted))) if values else np.nan
                         for values, wanted in zip(record["passes"], self.measured.amplitude)])

    def _errors(self, record):
        errors = np.log(self._nearest(record) / self.measured.amplitude)
        return np.where(np.isfinite(errors), errors, MISSED)


def uncertainty(errors, jacobian):
    """Standard deviation (p,) of each unknown and their correlation (p, p); infinite along what the errors do not depend on, and of
    all where there are not more errors than unknowns."""
    m, p = jacobian.shape
    if m <= p:
        return np.full(p, np.inf), np.eye(p)
    left, size, right = np.linalg.svd(jacobian, full_matrices=False)
    variance = np.sum(errors**2) / (m - p)
    with np.errstate(divide="ignore"):
        scale = np.where(size > 1e-10 * max(size[0], 1e-300), 1 / size, np.inf)
    known = np.isfinite(scale)
    covariance = variance * (right[known].T * scale[known] ** 2) @ right[known]
    deviation = np.sqrt(np.diag(covariance))
    deviation = np.where(np.any(np.abs(right[~known]) > 1e-3, axis=0), np.inf, deviation) if not known.all() else deviation
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = covariance / np.outer(deviation, deviation)
    return deviation, np.nan_to_num(correlation)
