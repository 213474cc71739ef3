"""Forced responses from one nonlinear mode: peaks for any load, whole curves, how far they may be off, and how to repair that.

Equations: docs/theory/one-mode.md. Complex amplitudes are Z_k = q_ck - i q_sk.
"""

import warnings
from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from . import fourier
from .reduced_system import equations, stuck
from .results import Results
from .travelling_wave import along

GRID = 24  # places between two points of the backbone
NEAR_PEAK = 24  # places of a curve between the last of the grid and its end, where its slope is infinite
LARGEST = 4000  # unknowns of the dense equations, for the estimate and `refine`
NEAR_TOP = 0.5  # of the largest modal amplitude on a curve: where its peak is looked for
SMALLEST = 1e-3  # of the amplitude of the first point: how far down the linear part is followed


@dataclass(frozen=True)
class Motion:
    """A synthesised motion: excitation frequency `omega`, modal amplitude `alpha`, `force` (a factor on the loads of the case), and
    coefficients (dofs, 2H+1) from the preload state, in the harmonics of the excitation."""

    omega: float
    alpha: float
    force: float
    coefficients: np.ndarray

    def of(self, row):
        """Coefficients (2H+1,) of an unknown (its row), or of a combination of them, (dofs,), of a sector (H+1, dofs)."""
        return self.coefficients[row] if np.ndim(row) == 0 else along(np.asarray(row), self.coefficients[None])[0]

    def amplitude(self, row):
        """Half the peak-to-peak of an unknown, or of a combination."""
        return float(fourier.amplitude(self.of(row)[None])[0])


class Backbone:
    """A nonlinear mode over its amplitude, and what the loads of a case make of it.

    Parameters
    ----------
    alpha, omega, damping_ratio : (n,) arrays, alpha rising
    coefficients : (n, dofs, 2H+1), the motion from the preload state
    system : reference.HarmonicBalance, the equations with the loads of the case
    linear_below : whether the mode is linear up to the first amplitude, so that smaller ones are known

    `harmonic` below is that of the load which excites the mode, `force` a factor on all loads.
    """

    def __init__(self, alpha, omega, damping_ratio, coefficients, system, linear_below=True):
        if len(alpha) < 2 or np.any(np.diff(alpha) <= 0):
            raise ValueError("a backbone needs two points or more, with rising amplitudes")
        self.alpha, self.omega, self.damping_ratio = (np.asarray(values, dtype=float) for values in (alpha, omega, damping_ratio))
        self.coefficients, self.system, self.linear_below = np.asarray(coefficients, dtype=float), system, linear_below
        self.H = self.coefficients.shape[2] // 2
        shapes = complex_amplitudes(self.coefficients)
        for i in range(1, len(shapes)):  # instants from which time counts go over into each other
            turn = np.exp(1j * np.angle(np.vdot(shapes[i][:, 1], shapes[i - 1][:, 1])))
            shapes[i] *= turn ** np.arange(self.H + 1)
        shapes[:, :, 1:] /= self.alpha[:, None, None]
        parts = np.concatenate([shapes.real, shapes.imag], axis=2).reshape(len(shapes), -1)
        with np.errstate(over="ignore"):  # of slopes that are next to nothing
            self._table = PchipInterpolator(np.log(self.alpha), np.column_stack([self.omega, self.damping_ratio, parts]))
        load = complex_amplitudes(system.excitation[None])[0]
        self.load = load[:, 1:]  # of harmonic k in column k - 1
        self._levels, self._modes = {}, {}

    @classmethod
    def read(cls, path, samples=None):
        """From the results of a run with [mode]; `samples`: as for `reduced_system.equations`."""
        results = path if isinstance(path, Results) else Results(path)
        try:
            alpha, zeta = results.points("modal_amplitude"), results.points("damping_ratio")
        except KeyError:
            raise ValueError(f"{results.path}: follows no nonlinear mode ([mode])") from None
        rising = np.concatenate([[True], alpha[1:] > np.maximum.accumulate(alpha)[:-1]]) if len(alpha) else np.zeros(0, bool)
        if np.count_nonzero(rising) < 2:
            raise ValueError(f"{results.path}: {len(alpha)} points; a backbone needs two or more")
        if not rising.all():
            tops = ", ".join(f"{top:.6g}" for top in alpha[:-1][rising[:-1] & ~rising[1:]])
            warnings.warn(f"{results.path}: the mode turns back in its amplitude at {tops}; {np.count_nonzero(~rising)} points "
                          "behind it, which do not reach beyond, are left out", stacklevel=2)
        linear = bool(not results.contact_activity(0).events.any() and results.points("slip")[0] == 0)
        return cls(alpha[rising], results.omega[rising], zeta[rising], results.coefficients[rising], equations(results, samples), linear)

    @property
    def excited(self):
        """The lowest harmonic of the load that is not 0, 1 without a load."""
        return int(np.argmax(np.any(self.load != 0, axis=0))) + 1

    def at(self, alpha):
        """omega, damping ratio and complex shape (dofs, H+1), Psi_k but for the mean, which is as it is, at an amplitude.

        Between points by cubics without overshoot in log alpha.
        """
        if alpha > self.alpha[-1] * (1 + 1e-12) or alpha < self.alpha[0] * (1 - 1e-12) and not self.linear_below:
            raise ValueError(f"modal amplitude {alpha:g} is not between {self.alpha[0]:g} and {self.alpha[-1]:g}, where the mode is known")
        values = self._table(np.log(np.clip(alpha, self.alpha[0], self.alpha[-1])))
        parts = values[2:].reshape(-1, 2 * (self.H + 1))
        return float(values[0]), float(values[1]), parts[:, :self.H + 1] + 1j * parts[:, self.H + 1:]

    def forcing(self, shape, harmonic=1):
        """Psi^H F of a harmonic of the load. Raises ValueError where the load does no work on the mode."""
        self._need(harmonic)
        f = np.vdot(shape[:, 1], self.load[:, harmonic - 1])
        if abs(f) <= 1e-10 * np.linalg.norm(self.load) * np.linalg.norm(shape[:, 1]):
            raise ValueError(f"harmonic {harmonic} of the load does no work on this mode: no force makes it resonate")
        return f

    def force_levels(self, alpha, harmonic=1):
        """(s_1, s_2): factors on the loads at whose phase resonance and largest amplitude the mode swings with alpha."""
        omega, zeta, shape = self.at(alpha)
        s = 2 * zeta * omega**2 * alpha / abs(self.forcing(shape, harmonic))
        return s, s * np.sqrt(max(1 - zeta**2, 0.0))

    @cached_property
    def grid(self):
        """Amplitudes between those of the points, evenly in the logarithm, and below them where the mode is linear."""
        inside = [np.geomspace(a, b, GRID, endpoint=False) for a, b in zip(self.alpha, self.alpha[1:])]
        below = [np.geomspace(SMALLEST * self.alpha[0], self.alpha[0], GRID, endpoint=False)] if self.linear_below else []
        return np.concatenate([*below, *inside, self.alpha[-1:]])

    def levels(self, harmonic=1):
        """(s_1, s_2) of `force_levels` at every amplitude of `grid`, (m,) arrays."""
        if harmonic not in self._levels:
            self._levels[harmonic] = np.array([self.force_levels(alpha, harmonic) for alpha in self.grid]).T
        return self._levels[harmonic]

    def peaks(self, force=1.0, harmonic=1, others=True):
        """Motions at the peaks of the response under a force, by rising amplitude.

        Several where s_2 is not monotone: every other one of them is the least amplitude of a separate curve. None where the force is
        outside of what the backbone reaches.
        """
        grid, found = self.grid, []
        miss = self.levels(harmonic)[1] - force
        for i in np.flatnonzero(np.sign(miss[:-1]) != np.sign(miss[1:])):
            if miss[i + 1] == 0 and i + 2 < len(grid):
                continue  # counted with the next piece
            alpha = brentq(lambda a: self.force_levels(a, harmonic)[1] - force, grid[i], grid[i + 1], xtol=1e-14 * grid[i], rtol=1e-13)
            omega, zeta, _ = self.at(alpha)
            found.append(self.motion(alpha, omega * np.sqrt(max(1 - 2 * zeta**2, 0.0)) / harmonic, force, harmonic, others))
        return found

    def motion(self, alpha, excitation, force=1.0, harmonic=1, others=True):
        """The Motion of the mode with that amplitude under an excitation frequency, its phase by the load.

        others : add the linear response of the other modes of the stuck structure, to all harmonics of the load.
        """
        omega, zeta, shape = self.at(alpha)
        swing = harmonic * excitation
        turn = force * self.forcing(shape, harmonic) / ((omega**2 - swing**2 + 2j * zeta * omega * swing) * alpha)
        turn /= abs(turn)
        Z = np.zeros((len(shape), self.H + 1), complex)
        Z[:, 0] = shape[:, 0]
        for k in range(1, self.H // harmonic + 1):
            Z[:, k * harmonic] = alpha * shape[:, k] * turn**k
        if others:
            Z[:, 1:] += force * self.other_modes(excitation, harmonic)
        return Motion(float(excitation), float(alpha), float(force), real_coefficients(Z))

    def curve(self, force=1.0, harmonic=1, others=True):
        """The response under a force: a list of pieces, each a list of Motions along it. A piece that closes is a curve of its own.

        O^2 = omega^2 (1 - 2 zeta^2) -+ sqrt(force^2 f^2 / alpha^2 - 4 zeta^2 omega^4 (1 - zeta^2)), O the frequency of the mode.
        """
        pieces = [[self.motion(alpha, swing / harmonic, force, harmonic, others) for alpha, swing in places]
                  for _, places in self._tracks(force, harmonic)]
        return [motions for motions in pieces if len(motions) > 1]

    def tops(self, row, force=1.0, harmonic=1):
        """(number, Motion) for each piece of `curve`: the Motion has the largest amplitude of an unknown (its row, or a combination),
        beside that of the mode, as other modes swing along; None where the piece has no peak on what the backbone reaches.

        Pieces of one curve, left and right of a peak beyond the backbone, share a number; 0 is that which begins at rest.
        It is looked for where the mode swings with half of its largest amplitude or more, as resonances of other modes are none of it.
        """
        found = []
        for number, places in self._tracks(force, harmonic):
            most = max((alpha for alpha, _ in places), default=0.0)
            motions = [self.motion(alpha, swing / harmonic, force, harmonic) for alpha, swing in places if alpha >= NEAR_TOP * most]
            if not motions:
                found.append((number, None))
                continue
            size = fourier.amplitude(np.array([motion.of(row) for motion in motions]))
            i = int(np.argmax(size))
            inside = 0 < i < len(size) - 1
            found.append((number, self._between(motions[i - 1:i + 2], size[i - 1:i + 2], force, harmonic) if inside else None))
        return found

    def highest(self, row, force=1.0, harmonic=1):
        """The largest of `tops`. Where the last piece has no peak on what the backbone reaches, ValueError."""
        tops = [motion for _, motion in self.tops(row, force, harmonic)]
        if not tops or tops[-1] is None:  # the last piece is that of the largest modal amplitudes
            raise ValueError(f"force {force:g}: no peak on the backbone, which reaches amplitude {self.alpha[-1]:g}")
        return max((motion for motion in tops if motion), key=lambda motion: motion.amplitude(row))

    def _between(self, near, size, force, harmonic):
        """The Motion at the top of a parabola through three of them."""
        middle = near[1].omega
        place = np.array([motion.omega for motion in near]) - middle
        if len(set(place)) < 3:
            return near[1]
        curve, alpha = np.polyfit(place, size, 2), np.polyfit(place, [motion.alpha for motion in near], 2)
        top = np.clip(-curve[1] / (2 * curve[0]), place.min(), place.max()) if curve[0] < 0 else 0.0
        return self.motion(min(float(np.polyval(alpha, top)), self.alpha[-1]), middle + top, force, harmonic)

    def other_modes(self, excitation, harmonic=1):
        """(dofs, H): linear response of the stuck structure to unit force in every harmonic, in `harmonic` without the mode itself."""
        first = complex_amplitudes(self.coefficients[:1])[0][:, 1]
        response = np.zeros((len(first), self.H), complex)
        for k in np.flatnonzero(np.any(self.load != 0, axis=0)) + 1:
            squares, phi, (viscous, hysteretic) = self._linear(int(k))
            dynamic = squares - (k * excitation) ** 2 + 1j * (k * excitation * viscous + hysteretic)
            modal = phi.conj().T @ self.load[:, k - 1] / dynamic
            if k == harmonic:
                modal[np.argmax(np.abs(phi.conj().T @ self.system.matrices(1)[1] @ first))] = 0
            response[:, k - 1] = phi @ modal
        return response

    def correction(self, motion):
        """One Newton step of the true equations at a motion, (dofs, 2H+1): to be added to its coefficients."""
        system = self.under(motion.force)
        q, omega = motion.coefficients, motion.omega
        return np.linalg.solve(system.jacobian(q, omega), -system.residual(q, omega).ravel()).reshape(q.shape)

    def error(self, motion, row=None):
        """Estimated error: the size of `correction` relative to the motion's, without means. With a row (or combination, (dofs,)), by how
        much the amplitude of that unknown changes, relative."""
        step = self.correction(motion)
        if row is None:
            return float(np.linalg.norm(step[:, 1:]) / np.linalg.norm(motion.coefficients[:, 1:]))
        better = Motion(motion.omega, motion.alpha, motion.force, motion.coefficients + step)
        return abs(better.amplitude(row) / motion.amplitude(row) - 1)

    def refine(self, motion):
        """The solution of the true equations at the motion's frequency, by Newton's method from there."""
        return Motion(motion.omega, motion.alpha, motion.force, self.under(motion.force).solve(motion.omega, motion.coefficients))

    @property
    def judges(self):
        """Whether errors can be estimated: the dense equations are not too large."""
        return int(np.prod(self.system.shape)) <= LARGEST

    def under(self, force):
        """The dense equations with loads of so many times those of the case. Raises ValueError where they are too large."""
        if not self.judges:
            raise ValueError(f"{int(np.prod(self.system.shape))} unknowns; the dense equations are for at most {LARGEST}")
        system = copy(self.system)
        system.excitation = self.system.excitation.copy()
        system.excitation[:, 1:] *= force
        return system

    def _linear(self, k):
        """Squares of frequencies, shapes and (viscous, hysteretic) damping of the modes of the stuck structure, in harmonic k."""
        system, h = self.system, int(self.system.index[k])
        if h not in self._modes:
            K, M = system.matrices(k)
            squares, phi = scipy.linalg.eigh(stuck(system, harmonic=k), M)
            self._modes[h] = squares, phi, [np.einsum("ij,ij->j", phi.conj(), matrix @ phi).real
                                            for matrix in (system.damping.viscous(K, M), system.damping.hysteretic(K))]
        return self._modes[h]

    def _room(self, alpha, force, harmonic):
        """What the root is drawn of in `curve`: negative where the force does not reach so far."""
        omega, zeta, shape = self.at(alpha)
        return (force * abs(self.forcing(shape, harmonic)) / alpha) ** 2 - 4 * zeta**2 * omega**4 * (1 - zeta**2)

    def _tracks(self, force, harmonic):
        """(number of the curve, [(modal amplitude, frequency of the mode), ...]) along each piece of the response under a force."""
        grid, tracks = self.grid, []
        room = force - self.levels(harmonic)[1]  # of the same sign as _room
        for number, (begin, end) in enumerate(_runs(room >= 0), start=int(room[0] < 0)):
            alphas = list(grid[begin:end])
            first = begin > 0 and self._end(grid[begin - 1], grid[begin], force, harmonic)
            last = end < len(grid) and self._end(grid[end - 1], grid[end], force, harmonic)
            if last:
                alphas += list(last - (last - alphas[-1]) * np.linspace(1, 0, NEAR_PEAK + 1)[1:] ** 2)
            if first:
                alphas = list(first + (alphas[0] - first) * np.linspace(0, 1, NEAR_PEAK + 1)[:-1] ** 2) + alphas
            left, right = ([(alpha, self._swing(alpha, force, harmonic, side)) for alpha in alphas] for side in (-1, 1))
            places = [*left, *right[-2 if last else -1::-1]] if last else None
            tracks += [(number, [place for place in track if place[1] > 0]) for track in ([places] if last else [left, right])]
        return tracks

    def _end(self, inner, outer, force, harmonic):
        return brentq(lambda alpha: self._room(alpha, force, harmonic), inner, outer, xtol=1e-14 * inner, rtol=1e-13)

    def _swing(self, alpha, force, harmonic, side):
        """Frequency of the mode on one side of the peak; 0 where there is none."""
        omega, zeta, _ = self.at(alpha)
        square = omega**2 * (1 - 2 * zeta**2) + side * np.sqrt(max(self._room(alpha, force, harmonic), 0.0))
        return np.sqrt(max(square, 0.0))

    def _need(self, harmonic):
        if not 1 <= harmonic <= self.H:
            raise ValueError(f"harmonic must lie in 1 to {self.H}, found {harmonic}")
        if (own := self.system.index[harmonic]) != (wanted := self.system.index[1]):
            raise ValueError(f"harmonic {harmonic} of the load has index {own}, the mode of a sector {wanted}: it does no work on the mode")


def complex_amplitudes(coefficients):
    """Z (n, dofs, H+1) of coefficients (n, dofs, 2H+1); column 0 is a0, of which the mean is a half."""
    Z = np.empty((*coefficients.shape[:2], coefficients.shape[2] // 2 + 1), complex)
    Z[:, :, 0] = coefficients[:, :, 0]
    Z[:, :, 1:] = coefficients[:, :, 1::2] - 1j * coefficients[:, :, 2::2]
    return Z


def real_coefficients(Z):
    """The inverse for one motion: (dofs, 2H+1) of Z (dofs, H+1)."""
    q = np.empty((len(Z), 2 * Z.shape[1] - 1))
    q[:, 0] = Z[:, 0].real
    q[:, 1::2], q[:, 2::2] = Z[:, 1:].real, -Z[:, 1:].imag
    return q


def _runs(holds):
    """(begin, end) of the stretches where an array of bool is true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], holds.astype(int), [0]])))
    return list(zip(edges[::2], edges[1::2]))
