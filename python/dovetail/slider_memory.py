"""What sliders remember of a small change exp(lambda t) p(t) of a periodic motion, in terms that are linear in lambda.

Where one sticks since t_0, its force is k_t x_t - v with v(t) = exp(-lambda (t - t_0)) (k_t x_t + b x_n)(t_0). Over the stick, s from 0
to 1, v / k_t = sum of c_j phi_j, phi_j = sqrt(2j+1) P_j(2s-1), with every phi_i tested:

    integral of phi_i (dv/ds + L lambda / Omega v) ds + phi_i(0) (v(0) - v(t_0)) = 0,

L its length [rad]. That is discontinuous Galerkin: exact for lambda = 0, and v dies out for all Re lambda > 0.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import spherical_jn

TERMS = 8  # v is right to 2e-7 for |lambda| = 0.4 Omega in a stick as long as the period, to 1e-9 in half of that


class Stick(NamedTuple):
    """From one instant of the period to another [rad], point and direction t of a slider; v(t_0) = kt (x_t + by_n x_n)(t_0)."""

    point: int
    t: int
    begin: float
    end: float
    kt: float
    by_n: float


class SliderMemory:
    """Of a list of Stick, for waves k and lambda / Omega near a shift."""

    def __init__(self, sticks, k, shift):
        point, t, begin, end, kt, self.by_n = np.array(sticks).reshape(-1, len(Stick._fields)).T
        self.point, self.t, j = point.astype(int), t.astype(int), np.arange(TERMS)
        norm, length, middle = np.sqrt(2 * j + 1), (end - begin)[:, None, None], (begin + end)[:, None] / 2
        turned = np.where(k < 0, 1j, -1j)[:, None]**j  # SciPy 1.10 has j_n of positive numbers alone
        polynomials = turned * norm * spherical_jn(j, np.abs(k)[:, None] * length / 2)
        galerkin = np.outer(norm, norm) * np.where((j[:, None] < j) | ((j[:, None] + j) % 2 == 0), 1, -1)
        forced = kt[:, None, None] * length / (2 * np.pi) * np.exp(-1j * k * middle)[:, :, None] * polynomials
        inverse = np.linalg.inv(galerkin + shift * length * np.eye(TERMS))
        self.value = np.exp(1j * k * begin[:, None])  # of a wave at t_0
        self.decay, self.beginning = length * inverse, inverse @ ((-1.0)**j * norm)  # c = beginning v(t_0) / k_t - decay (c t)
        self.force = forced @ self.decay
        self.at_shift = (forced @ self.beginning[:, :, None])[:, :, 0]

    @property
    def size(self):
        """How many c there are."""
        return self.beginning.size

    def add_to(self, blocks):
        """Adds the forces for lambda / Omega = shift to blocks (N_x, 3, w, 3, w)."""
        remembered = self.at_shift[:, :, None] * self.value[:, None]
        for point, t, by_n, more in zip(self.point, self.t, self.by_n, remembered):
            blocks[point, t, :, t] -= more
            blocks[point, t, :, 2] -= by_n * more

    def push(self, ct, force):
        """With lambda / Omega = shift + t and c t: adds to force (w, N_x, 3) what forces are besides."""
        more = np.einsum("slj,sj->sl", self.force, ct.reshape(-1, TERMS))
        np.add.at(force, (slice(None), self.point, self.t), more.T)

    def follow(self, ct, x):
        """c of motions x (w, N_x, 3)."""
        value = np.einsum("sl,ls->s", self.value, x[:, self.point, self.t] + self.by_n * x[:, self.point, 2])
        return (self.beginning * value[:, None] - np.einsum("sij,sj->si", self.decay, ct.reshape(-1, TERMS))).ravel()
