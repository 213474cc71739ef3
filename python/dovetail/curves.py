"""Response curves: pieces between jumps of the branch, peaks, what happens at the ends."""

import re
from dataclasses import dataclass

import numpy as np

from . import fourier
from .units import with_unit

JUMPS = ("leap", "integration", "outside")  # events behind which the branch goes on elsewhere


@dataclass(frozen=True)
class Response:
    """The curve of one unknown.

    name, unit : str
    omega, frequency : (n,) excitation frequency in units of the model, and in Hz
    amplitude : (n,) half the peak-to-peak of the motion
    coefficients : (n, 2H+1) of its motion from the preload state
    """

    name: str
    unit: str
    omega: np.ndarray
    frequency: np.ndarray
    amplitude: np.ndarray
    coefficients: np.ndarray


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


class Curves:
    """The response curves of `Results`, in terms of the coefficients and events that it reads."""

    def amplitude(self, dof):
        """Half the peak-to-peak of the motion over the period at every point, (n,), of the trigonometric polynomial (not of samples).

        The mean does not count.
        """
        return fourier.amplitude(self._of_dof(dof))

    def response(self, dof):
        """The curve of an unknown or of a node, a `Response`; of a list of names, a list of them."""
        if isinstance(dof, (list, tuple)):
            return [self.response(name) for name in dof]
        coefficients = self._of_dof(dof)
        return Response(str(dof), self.unit_of(dof), self.omega, self.frequency, fourier.amplitude(coefficients), coefficients)

    def harmonic(self, dof, k):
        """Amplitude sqrt(a_k^2 + b_k^2) of harmonic k at every point, (n,); |a0|/2 for k = 0."""
        if not 0 <= k <= self.harmonics:
            raise ValueError(f"harmonic must lie in 0 to {self.harmonics}, found {k}")
        coefficients = self._of_dof(dof)
        return np.abs(coefficients[:, 0]) / 2 if k == 0 else np.hypot(coefficients[:, 2 * k - 1], coefficients[:, 2 * k])

    @property
    def jumps(self):
        """Numbers of the points behind which the branch goes on elsewhere: after a leap, or a stay outside the sweep."""
        return np.unique(self.events.of(*JUMPS).point)

    def peaks(self, dof):
        """(omega, amplitude) of each peak, in the order of the branch: local maxima strictly inside it, as an end is no peak.

        Over another parameter than the frequency, its value in place of omega. A peak that the run has located is that point. Else
        a point and its two neighbours give one parabola for the amplitude and one for omega, both as functions of arc length, so
        that a curve that leans over is no trouble.
        """
        amplitude, located = self.amplitude(dof), set(self.located_peaks(dof))
        return [(float(self.along[i]), float(amplitude[i])) if i in located else
                top(self.along, self.points("arclength"), amplitude, i) for i in maxima(amplitude, self.jumps)]

    def peak(self, dof):
        """(omega, amplitude) of the largest of `peaks`. Raises ValueError where there is none: an end of the sweep is no peak."""
        peaks = self.peaks(dof)
        if not peaks:
            raise ValueError(self._no_peak(dof))
        return max(peaks, key=lambda peak: peak[1])

    def peak_point(self, dof):
        """Index of the point with the largest amplitude of those that are peaks. Raises ValueError where there is none."""
        amplitude = self.amplitude(dof)
        tops = maxima(amplitude, self.jumps)
        if not len(tops):
            raise ValueError(self._no_peak(dof))
        return int(tops[np.argmax(amplitude[tops])])

    def largest_point(self, dof):
        """Index of the point with the largest amplitude, be it a peak or an end of the branch."""
        self._need_points()
        return int(np.argmax(self.amplitude(dof)))

    def ends(self, dof):
        """(omega, amplitude, words) where the amplitude rises towards an end of the branch, so that a peak may lie beyond."""
        amplitude = self.amplitude(dof)
        return [(float(self.along[i]), float(amplitude[i]), words) for i, words in at_the_ends(amplitude)]

    def located_peaks(self, dof):
        """Points that the run has located as maxima of this unknown or node: where it was the one watched, or moved most."""
        peaks = self.events.of("peak")
        if is_reduced(dof):
            return peaks.point[peaks.unknown == self.dof_index(dof)]
        return peaks.point[(peaks.unknown == -1) & (self.watch == dof)]

    def _no_peak(self, dof):
        self._need_points()
        said = " and ".join(f"{words}, {with_unit(f'{amplitude:.7g}', self.unit_of(dof))} at {self.place(value)}"
                            for value, amplitude, words in self.ends(dof))
        return f"{self.path}: {dof} has no peak between the ends of the sweep" + (f": it is {said}" if said else "")
