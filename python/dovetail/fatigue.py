"""From the course of a stress tensor over a period to a mean and an amplitude, and to how much of a material's strength they use.

Formulas and sources: docs/theory/stress.md.
"""

import csv
from dataclasses import dataclass

import numpy as np

from . import fourier

LEAST, PER_HARMONIC = 32, 16  # instants of a period: at least, and per period of the highest harmonic
SHARP = 8  # so many times as many where maxima are taken from samples
POLISHING_STEPS, FLAT = 6, 1e-6  # Newton steps on a chord; curvature below this part of the other is none
BLOCK = 1 << 17  # numbers at a time: they stay in the cache
HEADER = ("material", "fatigue_strength", "tensile_strength")  # of the table


@dataclass(frozen=True)
class Strength:
    """fatigue : amplitude that is endured under R = -1; tensile : tensile strength; both [Pa]."""

    fatigue: float
    tensile: float

    def __post_init__(self):
        if not (0 < self.fatigue < np.inf and 0 < self.tensile < np.inf):
            raise ValueError(f"strengths must be positive and finite, found fatigue strength {self.fatigue:g}, tensile strength "
                             f"{self.tensile:g}")


def von_mises(stress):
    """(...,) of tensors (..., 6)."""
    return np.linalg.norm(deviator(stress), axis=-1)


def deviator(stress):
    """(..., 5) coordinates of the deviator, whose length is the von Mises stress."""
    xx, yy, zz, xy, yz, zx = np.moveaxis(np.asarray(stress), -1, 0)
    shear = np.sqrt(3) * np.stack([(yy - zz) / 2, xy, yz, zx], axis=-1)
    return np.concatenate([((2 * xx - yy - zz) / 2)[..., None], shear], axis=-1)


def trace(stress):
    """I1 (...,) of tensors (..., 6)."""
    return np.asarray(stress)[..., :3].sum(axis=-1)


def principal(stress):
    """(..., 3) principal stresses, the largest first."""
    xx, yy, zz, xy, yz, zx = np.moveaxis(np.asarray(stress), -1, 0)
    rows = [np.stack(row, axis=-1) for row in ((xx, xy, zx), (xy, yy, yz), (zx, yz, zz))]
    return np.linalg.eigvalsh(np.stack(rows, axis=-1))[..., ::-1]


def sines(series):
    """Mean and amplitude (P,), (P,) by Sines (1959): the middle of I1, and the von Mises stress of half the longest chord of the path
    of the deviator.

    series : (2H+1, P, 6) Fourier coefficients, mean a0/2
    """
    lowest, highest = fourier.extremes(trace(series).T)
    mean = trace(series[0]) / 2 + (lowest + highest) / 2
    path = np.moveaxis(deviator(series[1:]), 0, 1)  # (P, 2H, 5)
    step = max(1, BLOCK // (6 * _instants(len(series) // 2)))
    parts = [_half_chord(path[i:i + step]) for i in range(0, len(path), step)]
    return mean, np.concatenate([np.zeros(0), *parts])


def signed_von_mises(series):
    """Mean and amplitude (P,), (P,) of the von Mises stress with the sign of I1, from samples; series as of `sines`."""
    basis = fourier.basis(len(series) // 2, fourier.phases(SHARP * _instants(len(series) // 2)))
    step = max(1, BLOCK // (6 * len(basis)))
    lowest, highest = (np.zeros(series.shape[1]) for _ in range(2))
    for i in range(0, series.shape[1], step):
        stress = np.tensordot(basis, series[:, i:i + step], 1)
        value = np.where(trace(stress) < 0, -1, 1) * von_mises(stress)
        lowest[i:i + step], highest[i:i + step] = value.min(axis=0), value.max(axis=0)
    return (highest + lowest) / 2, (highest - lowest) / 2


CRITERIA = {"sines": sines, "signed-von-mises": signed_von_mises}


def goodman(mean, amplitude, strength):
    """Utilisation (P,): amplitude / fatigue strength + mean / tensile strength, 1 on the line; compression is no help.

    strength : Strength
    """
    return amplitude / strength.fatigue + np.maximum(mean, 0.0) / strength.tensile


def read_strengths(path):
    """Dict of material to Strength, from a table with the columns HEADER, in the unit of stress of the model."""
    with open(path, newline="", encoding="utf-8-sig", errors="replace") as file:
        rows = [[word.strip() for word in row] for row in csv.reader(file)]
    if not rows or tuple(rows[0]) != HEADER:
        raise ValueError(f"{path}, line 1: wanted the header {','.join(HEADER)}, found {','.join(rows[0]) if rows else 'nothing'}")
    found = {}
    for number, row in enumerate(rows[1:], start=2):
        if not any(row):
            continue
        try:
            name, *values = row
            found[name] = Strength(*map(float, values))
        except (TypeError, ValueError) as error:
            raise ValueError(f"{path}, line {number}: wanted a material and two strengths, found {','.join(row)[:60]} ({error})") from None
    return found


def _instants(harmonics):
    return max(LEAST, PER_HARMONIC * harmonics)


def _half_chord(path):
    """Half the longest chord (P,) of closed curves given by coefficients (P, 2H, d): the longest between samples, polished."""
    harmonics = path.shape[1] // 2
    if not harmonics:
        return np.zeros(len(path))
    theta = fourier.phases(_instants(harmonics))
    ends = _longest_sampled(path, theta)
    longest = np.zeros(len(path))
    for _ in range(POLISHING_STEPS):
        at, slope, bend = (np.einsum("pek,pkd->ped", fourier.basis(harmonics, ends, i)[..., 1:], path) for i in range(3))
        chord = at[:, 0] - at[:, 1]
        longest = np.maximum(longest, np.linalg.norm(chord, axis=1))
        sign = np.array([1, -1])
        gradient = sign * np.einsum("pd,ped->pe", chord, slope)
        curvature = np.einsum("ped,pfd,e,f->pef", slope, slope, sign, sign)
        curvature[:, [0, 1], [0, 1]] += sign * np.einsum("pd,ped->pe", chord, bend)
        value, axes = np.linalg.eigh(curvature)
        along = np.einsum("pef,pe->pf", axes, gradient)
        uphill = value < -FLAT * np.abs(value).max(axis=1, keepdims=True)
        move = np.einsum("pef,pf->pe", axes, np.where(uphill, -along / np.where(uphill, value, 1), 0.0))
        ends = ends + np.clip(move, -theta[1], theta[1])
    return longest / 2


def _longest_sampled(path, theta):
    """Phases (P, 2) of the ends of the longest chord between samples."""
    basis = fourier.basis(path.shape[1] // 2, theta)[:, 1:]
    values = np.einsum("tk,pkd->dtp", basis, path, optimize=True)
    square = np.einsum("dtp,dtp->tp", values, values)
    longest, begin, end = (np.zeros(len(path), kind) for kind in (float, int, int))
    for lag in range(1, len(theta) // 2 + 1):
        other = np.roll(values, -lag, axis=1)
        apart = square + np.roll(square, -lag, axis=0) - 2 * np.einsum("dtp,dtp->tp", values, other)
        first = apart.argmax(axis=0)
        length = apart[first, np.arange(len(path))]
        more = length > longest
        longest[more], begin[more], end[more] = length[more], first[more], (first[more] + lag) % len(theta)
    return theta[np.stack([begin, end], axis=1)]
