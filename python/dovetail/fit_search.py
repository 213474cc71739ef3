"""Relative errors of computed curves at what was measured, by the factors that are looked for: one curve, or several weighted."""

import sys
from dataclasses import dataclass

import numpy as np

STEP = 1e-3  # of the logarithm of a parameter, for derivatives
NOISE = 1e-8  # of amplitudes: two runs agree no better, for Newton's method stops there and sums are rounded
MISSED = 1.0  # error, as a logarithm, where a curve has no point at a frequency, or could not be computed
LEAST_SCATTER = 0.1  # of the largest: no curve weighs more than ten times another


@dataclass(frozen=True)
class Unknown:
    """A factor that is looked for, on what the case has: of a parameter, maybe at the points of one joint alone, (k,) numbers."""

    name: str
    joint: str = ""
    points: np.ndarray | None = None

    def __str__(self):
        return f"{self.name} of {self.joint}" if self.joint else self.name


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


def under(force, changes):
    """The same with all loads times a factor."""
    return changes | {"force": ("factor", force * changes.get("force", (None, 1.0))[1])} if force != 1 else changes


class Search:
    """Errors of one curve by the logarithms x of the factors, and their derivatives by differences.

    `force`: factor on the loads of the case with which it was measured; `name`: of the curve on the screen, or nothing.
    """

    def __init__(self, runs, unknowns, measured, at, harmonic, force=1.0, name=""):
        self.runs, self.unknowns, self.measured, self.harmonic = runs, unknowns, measured, harmonic
        self.force, self.name = force, name
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
        wanted = [under(self.force, changes_of(self.unknowns, np.exp(key), size)) for key in missing]
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
        factors = ", ".join(f"{unknown} {factor:.4g}x" for unknown, factor in zip(self.unknowns, np.exp(x)))
        print(f"{self.name}  relative error {np.sqrt(np.mean(found**2)):.3g} with {factors}", file=sys.stderr)
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


class Curves:
    """Several Search objects with the same unknowns: their errors and derivatives one behind the other, each divided by its curve's
    scatter."""

    def __init__(self, searches):
        self.searches, self.scatter = searches, np.ones(len(searches))

    def errors(self, x):
        return np.concatenate([search.errors(x) / scatter for search, scatter in zip(self.searches, self.scatter)])

    def derivative(self, x):
        return np.vstack([search.derivative(x) / scatter for search, scatter in zip(self.searches, self.scatter)])

    def plain_errors(self, x):
        """Of each curve, not divided; NaN where it has no point."""
        return [np.log(search.amplitudes(x) / search.measured.amplitude) for search in self.searches]

    def failed(self, x):
        return any(search.failed(x) for search in self.searches)

    def weigh(self, x):
        """Takes the scatter that the curves leave at x. Returns the largest change of a weight, as a logarithm.

        Of all that the errors of m frequencies leave, p unknowns take a share of p / m.
        """
        errors = [found[np.isfinite(found)] for found in self.plain_errors(x)]
        free = 1 - len(x) / max(sum(map(len, errors)), len(x) + 1)
        scatter = np.array([np.sqrt(np.mean(found**2) / free) if len(found) else np.nan for found in errors])
        most = np.nanmax(scatter, initial=NOISE)
        scatter = np.maximum(np.nan_to_num(scatter, nan=most), LEAST_SCATTER * most)
        before, self.scatter = self.scatter, scatter
        change = np.log(scatter / before)
        return float(np.ptp(change))


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
