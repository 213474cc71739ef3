"""Relative errors of computed curves where something was measured, by the factors that are looked for: one, or several weighted."""

import sys
from dataclasses import dataclass

import numpy as np

STEP = 1e-3  # of the logarithm of a parameter, for derivatives
NOISE = 1e-8  # of what is compared: two runs agree no better, for Newton's method stops there and sums are rounded
MISSED = 1.0  # error, as a logarithm, where a curve has no point, or could not be computed
LEAST_SCATTER = 0.1  # of the largest: no curve weighs more than ten times another, beside what is usual


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
    """Errors of one measured curve by the logarithms x of the factors, and their derivatives by differences of runs.

    `wanted`: (m,) what was measured; `name`: on the screen, or nothing. Who is one has `records` and `passes`.
    """

    usual = 1.0  # size of its errors beside those of others, before a fit has said it
    missed = MISSED

    def __init__(self, unknowns, wanted, name=""):
        self.unknowns, self.wanted, self.name = unknowns, wanted, name

    def records(self, places):
        """What runs with some x have given, computed together: dicts with `status`."""
        raise NotImplementedError

    def passes(self, record):
        """Of a run with status 0: for each that was measured, the values of each passage of the curve."""
        raise NotImplementedError

    def failed(self, x):
        return self.records([x])[0]["status"] != 0

    def values(self, x):
        """(m,) of the passage nearest to what was measured, NaN where there is none."""
        return self._nearest(self.records([x])[0])

    def plain_errors(self, x):
        """(m,) logarithms of computed over measured values: relative errors; NaN where there is no passage."""
        return np.log(self.values(x) / self.wanted)

    def errors(self, x):
        """The same with `missed` where there is none, and a line on the screen."""
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
            return np.full(len(self.wanted), np.nan)
        return np.array([min(values, key=lambda value: abs(np.log(value / wanted))) if values else np.nan
                         for values, wanted in zip(self.passes(record), self.wanted)])

    def _errors(self, record):
        errors = np.log(self._nearest(record) / self.wanted)
        return np.where(np.isfinite(errors), errors, self.missed)


class Curves:
    """Several Search objects with the same unknowns: their errors and derivatives one behind the other, each divided by its curve's
    scatter."""

    def __init__(self, searches):
        self.searches = searches
        self.scatter = self.usual = np.array([search.usual for search in searches])

    def errors(self, x):
        return np.concatenate([search.errors(x) / scatter for search, scatter in zip(self.searches, self.scatter)])

    def derivative(self, x):
        return np.vstack([search.derivative(x) / scatter for search, scatter in zip(self.searches, self.scatter)])

    def plain_errors(self, x):
        """Of each curve, not divided; NaN where it has no point."""
        return [search.plain_errors(x) for search in self.searches]

    def failed(self, x):
        return any(search.failed(x) for search in self.searches)

    def weigh(self, x):
        """Takes the scatter that the curves leave at x. Returns the largest change of a weight, as a logarithm.

        Of all that m errors leave, p unknowns take a share of p / m.
        """
        errors = [found[np.isfinite(found)] for found in self.plain_errors(x)]
        free = 1 - len(x) / max(sum(map(len, errors)), len(x) + 1)
        scatter = np.array([np.sqrt(np.mean(found**2) / free) if len(found) else np.nan for found in errors]) / self.usual
        most = np.nanmax(scatter, initial=NOISE)
        scatter = np.maximum(np.nan_to_num(scatter, nan=most), LEAST_SCATTER * most) * self.usual
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
