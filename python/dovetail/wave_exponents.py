"""Hill's method for a travelling wave, by the nodal diameters of what may disturb it.

Sector j does what sector 0 does, j EO / N of the period later. So a small change of a wave can be taken as exp(lambda t) p(t), times
exp(-2 pi i m j / N) in sector j at the same place of its period, p a sum of waves exp(i k Omega t) of index k EO + m. Changes of
different m know nothing of each other, and one sector is enough for all of them. Waves of whole and of half numbers k together have all
exponents lambda within a quarter of Omega of the real axis.

Where a slider sticks, it remembers an instant before, when the change was smaller or larger by exp(lambda ...). That is linear in lambda
with a few unknowns more (slider_memory.py), which lengthen vectors only: no matrix that is factored grows.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse.linalg as sla

from .wave_contacts import ContactWaves

STRIP = 0.251  # of Omega, to either side of the real axis: a quarter, where whole and half waves meet, and what both may be off by
SHIFT = 1e-3 + 7e-4j  # of Omega: where they are sought around, as 0 itself may be one
FURTHER = 0.15  # of Omega: than the strip is wide, exponents that must be found
FIRST = 24  # exponents sought, twice as many as long as these are not enough
TOLERANCE = 1e-9  # of exponents, relative
GIB = 2**30
MEMORY = 2 * GIB  # of the matrices of one m


@dataclass(frozen=True)
class Exponent:
    """value : lambda / Omega; share : (N/2+1,) parts of the nodal diameters in the kinetic energy of that motion
    k, h : numbers of its waves over a period, and their indices
    """

    value: complex
    share: np.ndarray
    k: np.ndarray
    h: np.ndarray

    @property
    def multiplier(self):
        """By how much the motion grows in a period."""
        return float(np.exp(2 * np.pi * self.value.real))


def largest(system, q, omega, wave):
    """The Exponent with the largest real part of all small motions about the wave q of a `SectorBalance`."""
    contacts, found = ContactWaves(system, q), []
    need_memory(system, wave)
    for half in (0, 1):
        k = np.arange(-system.H, system.H + 1 - half)
        answers = contacts.answers(k + half / 2, SHIFT)
        for m in different(wave, half):
            h = (k * wave.engine_order + m) % wave.sectors
            h = np.where(2 * h > wave.sectors, h - wave.sectors, h)
            found += _Changes(system, contacts.springs, omega, wave, k + half / 2, h).near_zero(*answers)
    return max(found, key=lambda exponent: exponent.value.real)


def different(wave, half):
    """The m of which the others are conjugates: -m of whole waves, EO - m of half ones."""
    return sorted({min(m, (half * wave.engine_order - m) % wave.sectors) for m in range(wave.sectors)})


def need_memory(system, wave):
    """ValueError where there are too many contact points and harmonics."""
    n, w = system.shape
    needed = 16 * (5 * w * n**2 + 3 * (3 * system.contact.points * w)**2)
    if needed > MEMORY:
        raise ValueError(f"{n} modes and contact dofs with {w // 2} harmonics take {needed / GIB:.1f} GiB of dense matrices for their "
                         f"stability, {MEMORY / GIB:.0f} GiB are the limit; run the case with fewer harmonics or contact points")


class _Changes:
    """Q(lambda) p = 0 of waves k with indices h, [K + s C + s^2 M + contact forces] p with s = lambda + i k Omega in each wave."""

    def __init__(self, system, springs, omega, wave, k, h):
        self.modes, self.springs, self.omega, self.k, self.h, self.most = system.modes, springs, omega, k, h, wave.sectors // 2
        pairs = [system.of_index(index) for index in h]
        self.K, self.M = (np.array([pair[i] for pair in pairs], complex) for i in (0, 1))
        self.C = np.array([system.damping.viscous(*pair) for pair in pairs])
        contact = range(self.modes, self.K.shape[1])
        self.K[:, contact, contact] += springs.ravel()

    def near_zero(self, blocks, memory):
        """All Exponents in the strip."""
        w, n = self.K.shape[:2]
        s = ((SHIFT + 1j * self.k) * self.omega)[:, None, None]
        solve = _woodbury(np.linalg.inv(self.K + s * (self.C + s * self.M)), blocks, self.springs, self.modes)
        D, M = self.omega * (self.C + 2 * s * self.M), self.omega**2 * self.M

        def contact(v):
            return v[:, self.modes:].reshape(w, -1, 3)

        def inverse(v):  # t = lambda / Omega - SHIFT: from (p, t p, c) to the same over t
            (p, r), c = v[:2 * n * w].reshape(2, w, n, 1), v[2 * n * w:]
            force = D @ p + M @ r
            memory.push(c, contact(force))
            over = -solve(force)
            return np.concatenate([over.ravel(), p.ravel(), memory.follow(c, contact(over))])

        number, size = FIRST, 2 * n * w + memory.size
        operator = sla.LinearOperator((size, size), inverse, dtype=complex)
        start = np.random.default_rng(1).normal(size=size) + 0j
        while True:
            number = min(number, size - 2)
            values, vectors = sla.eigs(operator, number, which="LM", v0=start, tol=TOLERANCE)
            if np.abs(1 / values).max() > STRIP + FURTHER or number == size - 2:
                found = [self._exponent(SHIFT + 1 / value, p) for value, p in zip(values, vectors[:n * w].T)]
                return [exponent for exponent in found if abs(exponent.value.imag) < STRIP]
            number *= 2

    def _exponent(self, value, p):
        p = p.reshape(self.K.shape[0], -1, 1)
        energy = np.abs(value + 1j * self.k)**2 * (p.conj().transpose(0, 2, 1) @ self.M @ p).real.ravel()
        return Exponent(complex(value), np.bincount(np.abs(self.h), energy, self.most + 1) / energy.sum(), self.k, self.h)


def _woodbury(compliance, blocks, springs, modes):
    """Solves with the structure, its contact points on springs, and what contact forces are besides; right-hand sides (w, n, 1)."""
    w = blocks.shape[2]
    rest = blocks - np.einsum("pi,ij,kl->pikjl", springs, np.eye(3), np.eye(w))
    active = np.flatnonzero(np.abs(rest).max(axis=(1, 2, 3, 4)) > 1e-12 * springs.max(axis=1))
    if not len(active):
        return lambda force: compliance @ force
    rows = (modes + 3 * active[:, None] + np.arange(3)).ravel()
    rest, size, columns = rest[active], len(rows) * w, compliance[:, :, rows]
    near = columns[:, rows].reshape(w, len(active), 3, len(rows))
    coupling = np.einsum("pikjl,lpjc->pikcl", rest, near, optimize=True).reshape(size, size)
    factors = scipy.linalg.lu_factor(coupling + np.eye(size), overwrite_a=True)

    def solve(force):
        plain = compliance @ force
        x = plain[:, rows, 0].T.reshape(len(active), 3, w)
        more = scipy.linalg.lu_solve(factors, np.einsum("pikjl,pjl->pik", rest, x).ravel())
        return plain - columns @ more.reshape(len(rows), w).T[:, :, None]

    return solve
