"""Response curves: pieces between jumps of the branch, peaks, what happens at the ends."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from . import fourier
from .checked import whole_number

AT_ONCE = 1 << 14  # series whose amplitudes are taken together: few calls, and little memory
DRAWN = 8  # values on a piece of the curve between two points, for pictures
FINE = 64  # the same, where a maximum is sought
JUMPS = ("leap", "integration", "outside")  # events behind which the branch goes on elsewhere


@dataclass(frozen=True)
class Response:
    """The curve of one unknown or node.

    name, unit : str
    omega, frequency : (n,) excitation frequency in units of the model, and in Hz
    along : (n,) what it is followed over, `omega` or the parameter that is varied
    arclength : (n,)
    amplitude : (n,) half the peak-to-peak of the motion
    coefficients : (n, 2H+1) of its motion from the preload state
    jumps : numbers of the points behind which the branch goes on elsewhere
    located : points that the run has located as its maxima
    slopes : a function without arguments, which gives the slopes of `along` (n,) and `coefficients` (n, 2H+1) by arc length; or None
    breaks : numbers of the points behind which other harmonics are kept: from there to the next the curve is a straight line
    omega_slopes : (n,) of peaks that are followed, the slopes of `omega` by arc length; or None
    """

    name: str
    unit: str
    omega: np.ndarray = field(repr=False)  # a notebook that shows a curve shows no pages of numbers
    frequency: np.ndarray = field(repr=False)
    along: np.ndarray = field(repr=False)
    arclength: np.ndarray = field(repr=False)
    amplitude: np.ndarray = field(repr=False)
    coefficients: np.ndarray = field(repr=False)
    jumps: np.ndarray = field(repr=False)
    located: np.ndarray = field(repr=False)
    slopes: Callable | None = field(default=None, repr=False)
    breaks: np.ndarray = field(default=(), repr=False)
    omega_slopes: np.ndarray | None = field(default=None, repr=False)

    def curve(self, n=DRAWN):
        """(along, amplitude) of the curve as it is drawn, NaN behind each jump: n values from each point to the next, by the cubic with
        their tangents; the points themselves where the run has stored none."""
        whole_number(n, "n", 1)
        if self.slopes is None:
            return with_gaps(self.along, self.jumps), with_gaps(self.amplitude, self.jumps)
        along, coefficients = self._drawn(self.coefficients, *self.slopes(), n)
        parts = np.array_split(coefficients, 1 + len(coefficients) // AT_ONCE)
        return along, np.concatenate([fourier.amplitude(part) for part in parts])

    def omega_curve(self, n=DRAWN):
        """(along, omega) likewise, of peaks that are followed."""
        if self.omega_slopes is None:
            return with_gaps(self.along, self.jumps), with_gaps(self.omega, self.jumps)
        along, omega = self._drawn(self.omega[:, None], self.slopes()[0], self.omega_slopes[:, None], n)
        return along, omega[:, 0]

    def _drawn(self, values, slope, slopes, n):
        """`along`, of this slope, and values (n, ...) with theirs as they are drawn."""
        parts = (part for piece in pieces(len(self.along), self.jumps) for part in self._cubics(piece, values, slope, slopes, n))
        along, drawn = zip(*parts)
        return np.concatenate(along)[:-1], np.concatenate(drawn)[:-1]

    def _cubics(self, piece, values, slope, slopes, n):
        """Parts (along, values) of a piece without jumps, then one that is no number."""
        part = np.arange(n) / n
        for i in range(piece.start, piece.stop - 1):
            step = self.arclength[i + 1] - self.arclength[i]
            if i in self.breaks:
                yield self.along[i:i + 1], values[i:i + 1]
            elif step > 0:
                yield (cubic(self.along[i:i + 2], slope[i:i + 2], step, part), cubic(values[i:i + 2], slopes[i:i + 2], step, part))
        yield self.along[piece.stop - 1:piece.stop], values[piece.stop - 1:piece.stop]
        yield np.array([np.nan]), np.full((1, values.shape[1]), np.nan)

    def _top(self, i):
        """(along, amplitude) of the maximum near point i."""
        if self.slopes is None:
            return top(self.along, self.arclength, self.amplitude, i)
        found = list(self._cubics(slice(i - 1, i + 2), self.coefficients, *self.slopes(), FINE))[:-1]
        along, coefficients = (np.concatenate(parts) for parts in zip(*found))
        amplitude = fourier.amplitude(coefficients)
        highest = int(np.clip(np.argmax(amplitude), 1, len(along) - 2))
        return top(along, np.arange(len(along), dtype=float), amplitude, highest)

    def peaks(self):
        """As `Results.peaks`."""
        located = set(self.located)
        return [(float(self.along[i]), float(self.amplitude[i])) if i in located else
                self._top(i) for i in maxima(self.amplitude, self.jumps)]

    def peak_point(self):
        """As `Results.peak_point`; None where there is no peak."""
        tops = maxima(self.amplitude, self.jumps)
        return int(tops[np.argmax(self.amplitude[tops])]) if len(tops) else None

    def largest_point(self):
        """As `Results.largest_point`."""
        return int(np.argmax(self.amplitude))

    def ends(self):
        """As `Results.ends`."""
        return [(float(self.along[i]), float(self.amplitude[i]), words) for i, words in at_the_ends(self.amplitude)]

    def harmonic(self, k):
        """As `Results.harmonic`."""
        whole_number(k, "harmonic", 0, self.coefficients.shape[1] // 2)
        return np.abs(self.coefficients[:, 0]) / 2 if k == 0 else np.hypot(self.coefficients[:, 2 * k - 1], self.coefficients[:, 2 * k])


def is_reduced(dof):
    """Whether a name is that of a reduced unknown (or a row), and not of the motion of a node, "tip.y"."""
    return re.fullmatch(r".+\.[xyz]", str(dof)) is None


def moves_most(coefficients):
    """Number of the unknown with the largest amplitude anywhere; coefficients (n, m, 2H+1)."""
    bound = np.abs(coefficients[:, :, 1:]).sum(axis=2).max(axis=0, initial=0.0)
    best, found = -1.0, 0
    for row in np.argsort(-bound, kind="stable"):
        if bound[row] <= best:
            break
        if (largest := fourier.amplitude(coefficients[:, row]).max(initial=0.0)) > best:
            best, found = largest, int(row)
    return found


def pieces(n, jumps):
    """Slices of n points without a jump between any of them; jumps are the numbers of the points before one."""
    ends = [-1, *(int(i) for i in np.unique(jumps) if 0 <= i < n - 1), n - 1]
    return [slice(a + 1, b + 1) for a, b in zip(ends, ends[1:])]


def maxima(amplitude, jumps):
    """Numbers of the points that are larger than their neighbours: strictly inside a piece, as an end is no peak."""
    found = []
    for piece in pieces(len(amplitude), jumps):
        a = amplitude[piece]
        inside = (a[1:-1] > a[:-2]) & (a[1:-1] >= a[2:])
        found += list(piece.start + 1 + np.flatnonzero(inside))
    return np.array(found, int)


def cubic(ends, slopes, step, part):
    """The cubic with these values (2, ...) and slopes at its ends, `step` apart, at parts (m,) of the way: (m, ...)."""
    p = np.reshape(part, (-1, *[1] * (np.ndim(ends) - 1)))
    q = 1 - p
    return q * q * (ends[0] * (1 + 2 * p) + step * slopes[0] * p) + p * p * (ends[1] * (1 + 2 * q) - step * slopes[1] * q)


def top(omega, arclength, amplitude, i):
    """(omega, amplitude) between points i - 1 and i + 1: one parabola for each, as functions of arc length."""
    near = slice(i - 1, i + 2)
    s = arclength[near] - arclength[i]
    if not s[0] < 0 < s[2]:
        s = np.array([-1.0, 0.0, 1.0])
    curve, frequency = np.polyfit(s, amplitude[near], 2), np.polyfit(s, omega[near], 2)
    highest = np.clip(-curve[1] / (2 * curve[0]), s[0], s[2]) if curve[0] < 0 else 0.0
    return float(np.polyval(frequency, highest)), float(np.polyval(curve, highest))


def at_the_ends(amplitude):
    """(number of a point, words) for each end of the curve where the amplitude is still rising outwards."""
    if len(amplitude) < 2:
        return []
    found = [(0, "falling from the beginning of the curve")] if amplitude[0] > amplitude[1] else []
    return found + ([(len(amplitude) - 1, "still rising at the end of the curve")] if amplitude[-1] > amplitude[-2] else [])


def with_gaps(values, jumps):
    """The values with NaN behind each jump, so that no line is drawn there."""
    return np.concatenate([part for piece in pieces(len(values), jumps) for part in (values[piece], [np.nan])][:-1])
