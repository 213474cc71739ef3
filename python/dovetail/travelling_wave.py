"""One sector of a cyclic structure under a load that travels round it: what the other sectors do, and which nodal diameters.

Sector j does what sector 0 does, j EO / N of the period later: harmonic k turns by j phi_k, phi_k = 2 pi h_k / N.
"""

from dataclasses import dataclass

import numpy as np

from .checked import whole_number
from .hdf5_read import attribute, numbers, whole


@dataclass(frozen=True)
class TravellingWave:
    """sectors, engine_order : N and EO
    index : (H+1,) h of every harmonic, -N/2 < h <= N/2: the nodal diameter, positive where the wave runs with the numbers of the sectors
    frequencies : (N/2+1, m) array or None; lowest ones of the stuck structure [rad/s], by nodal diameter
    """

    sectors: int
    engine_order: int
    index: np.ndarray
    frequencies: np.ndarray | None = None

    def checked(self, sector):
        """The number of a sector; ValueError where there is none of it."""
        return whole_number(sector, "sector", 0, self.sectors - 1)

    def of_sector(self, coefficients, sector):
        """Coefficients (..., 2H+1) of another sector, from those of sector 0."""
        phase = 2 * np.pi * (self.checked(sector) * self.index % self.sectors) / self.sectors
        return coefficients if sector == 0 else series(amplitudes(coefficients) * np.exp(-1j * phase))


def spatial_index(harmonics, engine_order, sectors):
    """h of harmonics 0 to H, (H+1,)."""
    h = np.arange(harmonics + 1) * (engine_order % sectors) % sectors
    return np.where(2 * h > sectors, h - sectors, h)


def amplitudes(coefficients):
    """Complex amplitudes a_k - i b_k (..., H+1) of coefficients [a0, a1, b1, ...]; a0 of the mean."""
    Z = np.empty((*coefficients.shape[:-1], coefficients.shape[-1] // 2 + 1), complex)
    Z[..., 0] = coefficients[..., 0]
    Z[..., 1:] = coefficients[..., 1::2] - 1j * coefficients[..., 2::2]
    return Z


def series(Z):
    """The coefficients of complex amplitudes."""
    coefficients = np.empty((*Z.shape[:-1], 2 * Z.shape[-1] - 1))
    coefficients[..., 0], coefficients[..., 1::2], coefficients[..., 2::2] = Z[..., 0].real, Z[..., 1:].real, -Z[..., 1:].imag
    return coefficients


def along(row, coefficients):
    """(points, 2H+1) of coefficients (points, dofs, 2H+1) along a row (dofs,), or along one for every harmonic, complex (H+1, dofs)."""
    if row.ndim == 1:
        return np.tensordot(coefficients, row, (1, 0))
    return series(np.einsum("pqk,kq->pk", amplitudes(coefficients), row))


def read_wave(file, harmonics):
    """The TravellingWave of an open results file, or None."""
    if "sectors" not in file.attrs:
        return None
    sectors, order = whole(file, "sectors"), np.asarray(attribute(file, "engine_order", "nothing"))
    if sectors < 2:
        raise ValueError(f"attribute sectors must be a whole number from 2 on, found {sectors}")
    if order.size != 1 or order.dtype.kind not in "iu":
        raise ValueError(f"attribute engine_order must be one whole number, found {str(order)[:40]}")
    order, frequencies = int(order.reshape(-1)[0]), None
    if "cyclic/frequencies" in file:
        frequencies = numbers(file, "cyclic/frequencies", (sectors // 2 + 1, None))
    return TravellingWave(sectors, order, spatial_index(harmonics, order, sectors), frequencies)
