"""Trigonometric polynomials in the convention of docs/theory/equations.md, equation (10): [a0, a1, b1, a2, b2, ...], mean a0/2."""

import numpy as np

from .checked import finite_numbers, whole_number

GRID_PER_HARMONIC = 16  # points of the search grid per period of the highest harmonic
POLISHING_STEPS = 8  # Newton steps on q' = 0 from the grid; quadratic, so rounding level is reached in 3 to 5


def basis(harmonics, theta, derivative=0):
    """Values of [1/2, cos th, sin th, cos 2th, ...], or of a derivative with respect to theta.

    Parameters
    ----------
    harmonics : int
        H.
    theta : (...) array
        Phase Omega t [rad].
    derivative : int
        0, 1 or 2.

    Returns
    -------
    (..., 2H+1) array
    """
    theta = np.asarray(theta, dtype=float)
    k = np.arange(1, harmonics + 1)
    angle = theta[..., None] * k + derivative * np.pi / 2  # each derivative turns the phase by a quarter and multiplies by k
    values = np.empty(theta.shape + (2 * harmonics + 1,))
    values[..., 0] = 0.5 if derivative == 0 else 0.0
    values[..., 1::2] = k**derivative * np.cos(angle)
    values[..., 2::2] = k**derivative * np.sin(angle)
    return values


def phases(n):
    """n equal steps over one period, [0, 2 pi)."""
    return 2 * np.pi * np.arange(whole_number(n, "n", 1)) / n


def course(coefficients, omega, n, times=None):
    """Values (N, k) of k series (k, 2H+1) at n equal steps of the period, or at some times [s]."""
    theta = phases(n) if times is None else omega * finite_numbers(times, "times")
    return basis(coefficients.shape[-1] // 2, theta) @ coefficients.T


def amplitude(coefficients):
    """Half the peak-to-peak of the motion over the period, (n,) of coefficients (n, 2H+1); taken as in `extremes`."""
    lowest, highest = extremes(coefficients)
    return (highest - lowest) / 2


def extremes(coefficients):
    """The lowest and the highest value over the period, from the mean, taken from the polynomial and not from samples of it.

    Parameters
    ----------
    coefficients : (n, 2H+1) array

    Returns
    -------
    (n,), (n,) arrays

    Notes
    -----
    Means do not count. On a grid of spacing h, q within h/2 of grid point j is at most q_j + h/2 |q'_j| + h^2/8 sum k^2 |c_k|. Only
    grid points where this reaches the largest grid value can have the maximum beside them; those are polished by Newton steps
    on q' = 0. The minimum is the maximum of -q.
    """
    coefficients = np.array(coefficients, dtype=float)
    coefficients[:, 0] = 0.0  # a large mean would cost digits
    harmonics = (coefficients.shape[-1] - 1) // 2
    theta = phases(GRID_PER_HARMONIC * max(harmonics, 1))
    value = coefficients @ basis(harmonics, theta).T  # (n, grid)
    slope = coefficients @ basis(harmonics, theta, 1).T
    size = np.hypot(coefficients[:, 1::2], coefficients[:, 2::2])
    beyond = theta[1] / 2 * np.abs(slope) + (theta[1] ** 2 / 8 * (size @ np.arange(1, harmonics + 1) ** 2))[:, None]
    return -_highest(-coefficients, -value, beyond, theta), _highest(coefficients, value, beyond, theta)


def _highest(coefficients, value, beyond, theta):
    """The largest q, (n,), from its values on the grid theta and how far they may be below those `beyond`."""
    largest, step, harmonics = value.max(axis=1), theta[1], (coefficients.shape[-1] - 1) // 2
    row, column = np.nonzero(value + beyond >= largest[:, None])
    c, start = coefficients[row], theta[column]
    position, best = start, value[row, column]
    for _ in range(POLISHING_STEPS):
        first = np.einsum("ij,ij->i", basis(harmonics, position, 1), c)
        second = np.einsum("ij,ij->i", basis(harmonics, position, 2), c)
        downhill = np.where(second < 0, second, 1.0)
        move = np.where(second < 0, -first / downhill, np.sign(first) * step / 4)
        position = np.clip(position + move, start - step / 2, start + step / 2)
        best = np.maximum(best, np.einsum("ij,ij->i", basis(harmonics, position), c))
    np.maximum.at(largest, row, best)
    return largest
