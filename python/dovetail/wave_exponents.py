"""Hill's method for a travelling wave, by the nodal diameters of what may disturb it.

A wave and its sectors repeat: sector j does what sector 0 does, j EO / N of the period later. So a small change of it can be taken as
exp(lambda t) p(t), times exp(-2 pi i m j / N) in sector j at the same place of its period, p a sum of waves exp(i k Omega t) of index
k EO + m. Changes of different m know nothing of each other, and one sector is enough for all of them. As in the program, waves are whole
and half numbers k, which together have all exponents lambda within a quarter of Omega of the real axis.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse.linalg as sla

from .wave_contacts import contact_blocks

STRIP = 0.25  # of Omega, in which exponents are looked for to either side of the real axis
SHIFT = 1e-3 + 7e-4j  # of Omega: where they are sought around, as 0 itself may be one
FURTHER = 0.15  # of Omega: than the strip is wide, exponents that must be found
FIRST = 24  # exponents sought, twice as many as long as these are not enough
TOLERANCE = 1e-9  # of exponents, relative


@dataclass(frozen=True)
class Exponent:
    """value : lambda / Omega; half : of half waves
    share : (N/2+1,) parts of the nodal diameters in the kinetic energy of the motion that grows with it, over a period
    """

    value: complex
    half: bool
    share: np.ndarray

    @property
    def multiplier(self):
        """Modulus: by how much it grows in a period."""
        return float(np.exp(2 * np.pi * self.value.real))


def exponents(system, q, omega, wave):
    """The Exponent with the largest real part for every m and kind of waves, of a `SectorBalance` in the motion q; largest first."""
    found = []
    for half in (False, True):
        k = np.arange(-system.H, system.H + (not half))
        blocks = contact_blocks(system, q, k + half / 2)
        for m in different(wave, half):
            h = (k * wave.engine_order + m) % wave.sectors
            h = np.where(2 * h > wave.sectors, h - wave.sectors, h)
            found.append(_largest(system, blocks, k + half / 2, h, omega, wave.sectors // 2))
    return sorted((Exponent(value, i >= len(different(wave, False)), share) for i, (value, share) in enumerate(found)),
                  key=lambda exponent: -exponent.value.real)


def different(wave, half):
    """The m of which the others are conjugates: -m of whole waves, EO - m of half ones."""
    return sorted({min(m, (half * wave.engine_order - m) % wave.sectors) for m in range(wave.sectors)})


def _largest(system, blocks, k, h, omega, most):
    """lambda / Omega and the shares of the nodal diameters 0 .. most; h: index of each wave."""
    n, w = system.shape[0], len(k)
    pairs = [system.of_index(index) for index in h]
    K, M = (np.array([pair[i] for pair in pairs], complex) for i in (0, 1))
    C = np.array([system.damping.viscous(*pair) for pair in pairs])
    springs = np.column_stack([system.contact.kt, system.contact.kn])
    springs[system.contact.kind > 1, :2] = 0
    K[:, range(system.modes, n), range(system.modes, n)] += springs.ravel()
    s = ((SHIFT + 1j * k) * omega)[:, None, None]
    compliance = np.linalg.inv(K + s * (C + s * M))
    solve = _woodbury(compliance, blocks, springs, system.modes)
    D = omega * (C + 2 * s * M)
    M = omega**2 * M

    def inverse(v):  # of exponents beyond the shift, with p and p times that of Q(lambda) p = 0
        p, r = v.reshape(2, w, n, 1)
        return np.concatenate([-solve(D @ p + M @ r), p]).ravel()

    size, number = 2 * n * w, min(FIRST, 2 * n * w - 2)
    operator = sla.LinearOperator((size, size), inverse, dtype=complex)
    start = np.random.default_rng(1).normal(size=size) + 0j
    while True:
        values, vectors = sla.eigs(operator, number, which="LM", v0=start, tol=TOLERANCE)
        if np.abs(1 / values).max() > STRIP + FURTHER or number == size - 2:
            break
        number = min(2 * number, size - 2)
    values = SHIFT + 1 / values
    inside = np.flatnonzero(np.abs(values.imag) < STRIP + 1e-6)
    if not len(inside):
        return -STRIP - 0j, np.zeros(most + 1)
    best = inside[np.argmax(values[inside].real)]
    p = vectors[:n * w, best].reshape(w, n, 1)
    energy = (np.abs(values[best] + 1j * k)**2) * (p.conj().transpose(0, 2, 1) @ M @ p).real.ravel()
    return complex(values[best]), np.bincount(np.abs(h), energy, most + 1) / energy.sum()


def _woodbury(compliance, blocks, springs, modes):
    """Solves with the structure, its contact points on springs, and what contact forces are besides; right-hand sides (w, n, 1)."""
    w, eye = blocks.shape[2], np.eye(blocks.shape[2])
    rest = blocks - np.einsum("pi,ij,kl->pikjl", springs, np.eye(3), eye)
    active = np.flatnonzero(np.abs(rest).max(axis=(1, 2, 3, 4)) > 1e-12 * springs.max(axis=1))
    if not len(active):
        return lambda force: compliance @ force
    rows = (modes + 3 * active[:, None] + np.arange(3)).ravel()
    rest, size = rest[active], 3 * len(active) * w
    near = compliance[:, rows][:, :, rows].reshape(w, len(active), 3, len(rows))
    coupling = np.einsum("pikjl,lpjc->pikcl", rest, near, optimize=True).reshape(size, len(rows), w)
    coupling = coupling.reshape(size, size) + np.eye(size)
    factors, columns = scipy.linalg.lu_factor(coupling), compliance[:, :, rows]

    def solve(force):
        plain = compliance @ force
        x = plain[:, rows, 0].T.reshape(len(active), 3, w)
        more = scipy.linalg.lu_solve(factors, np.einsum("pikjl,pjl->pik", rest, x).ravel())
        return plain - columns @ more.reshape(len(rows), w).T[:, :, None]

    return solve
