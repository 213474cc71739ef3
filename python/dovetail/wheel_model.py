"""The whole wheel of a cyclic sector as an ordinary reduced model, and a travelling wave as a motion of it.

What sectors j = 0 .. N-1 do is c cos(2 pi h j / N) + s sin(2 pi h j / N), summed over h = 0 .. N/2. In c and s, an orthonormal basis
of the sectors, K^h = K_r + i K_i is [K_r, -K_i; K_i, K_r]. Modes stay in these coordinates: those of h = 0, then c and s of h = 1, 2, ...
Contact points are those of sector 0, then of sector 1, ... Nothing is lost.
"""

from dataclasses import dataclass

import h5py
import numpy as np

from .reduced_system import of_index, reduced_of
from .reference import Reduced
from .travelling_wave import amplitudes, series

REAL = 1e-8  # of the size: imaginary parts of N/2 nodal diameters, which are rounding errors
TURNED = np.array([[0.0, -1.0], [1.0, 0.0]])  # what i does to c and s


@dataclass(frozen=True)
class Wheel:
    """reduced : `reference.Reduced` of all sectors, with loads on one sector each
    loads : pattern and sector of each of them, all patterns of sector 0 first
    phases : (N_a,) by which modes of N/2 nodal diameters become real; None for odd N
    """

    reduced: Reduced
    loads: list
    phases: np.ndarray | None


def unrolled(file, results):
    """The Wheel of an open reduced file of a sector, that of the results."""
    N = results.wave.sectors
    first, names = reduced_of(file, results)
    models = [first, *(of_index(file, results, h) for h in range(1, N // 2 + 1))]
    phases = None if N % 2 else real_phases(np.hstack([models[-1].max, models[-1].fa.T]), results.path)
    n, m, L = len(first.kaa), len(first.r), len(names)
    kxx, mxx = np.zeros((N * m, N * m)), np.zeros((N * m, N * m))
    kaa, couplings, fa, fx = [], [], [], np.zeros((N, L, N * m))
    for h, model in enumerate(models):
        B, J = sectors_basis(N, h)
        couple, load = model.max, model.fa
        if phases is not None and h == N // 2:
            couple, load = phases[:, None] * couple, phases * load
        for whole, part in ((kxx, model.kxx), (mxx, model.mxx)):
            whole += np.kron(B @ B.T, part.real) + np.kron(B @ J @ B.T, part.imag)
        kaa.append(np.tile(model.kaa, B.shape[1]))
        couplings.append(np.kron(B.T, couple.real) + np.kron(J @ B.T, couple.imag))
        fa.append(_on_each(B, B @ J.T, load).reshape(N, L, -1))
        fx += _on_each(B @ B.T, B @ J.T @ B.T, model.fx).reshape(N, L, -1)
    fa = np.concatenate(fa, axis=2).reshape(N * L, N * n)
    reduced = Reduced(np.concatenate(kaa), np.concatenate(couplings), mxx, kxx, fa, fx.reshape(N * L, N * m), np.tile(first.r, N))
    return Wheel(reduced, [(name, j) for j in range(N) for name in names], phases)


def _on_each(cosine, sine, load):
    """(N, L, columns, width) of loads (L, width) on each sector."""
    return np.einsum("jc,lw->jlcw", cosine, load.real) + np.einsum("jc,lw->jlcw", sine, load.imag)


def sectors_basis(sectors, h):
    """Columns (N, 2) cos and sin of h over the sectors, orthonormal, and J; one column where there is no sine."""
    angle = 2 * np.pi * (h * np.arange(sectors) % sectors) / sectors
    if h in (0, sectors / 2):
        return np.cos(angle)[:, None].round() / np.sqrt(sectors), np.zeros((1, 1))
    return np.column_stack([np.cos(angle), np.sin(angle)]) * np.sqrt(2 / sectors), TURNED


def real_phases(rows, path):
    """Phases (n,) that make rows (n, k) real. Modes of N/2 nodal diameters are real but for such a phase."""
    largest = rows[np.arange(len(rows)), np.argmax(np.abs(rows), axis=1)]
    phases = np.where(np.abs(largest) > 0, np.conj(largest) / np.where(largest == 0, 1, np.abs(largest)), 1)
    if np.any(np.abs((phases[:, None] * rows).imag) > REAL * np.abs(rows).max(axis=1, keepdims=True)):
        raise ValueError(f"{path}: modes of N/2 nodal diameters are not real in its reduced file, so that they are no modes of a wheel")
    return phases


def wave_of_wheel(wave, coefficients, modes, phases):
    """Coefficients of the wheel (N (N_a + 3 N_x), 2H+1) in the travelling wave that sector 0 has with coefficients (N_a + 3 N_x, 2H+1)."""
    N, Z = wave.sectors, amplitudes(coefficients[:modes])
    parts = []
    for h in range(N // 2 + 1):
        forth, back = (np.where(wave.index == sign * h, Z, 0) for sign in (1, -1))
        if h == 0:
            parts.append(np.sqrt(N) * forth)
        elif 2 * h == N:
            parts.append(np.sqrt(N) * phases[:, None] * forth)
        else:
            parts += [np.sqrt(N / 2) * (forth + back), np.sqrt(N / 2) * -1j * (forth - back)]
    points = [wave.of_sector(coefficients[modes:], j) for j in range(N)]
    return np.concatenate([series(np.concatenate(parts)), *points])


def write_reduced(path, wheel, units):
    """The reduced file of the wheel."""
    reduced = wheel.reduced
    with h5py.File(path, "w") as file:
        for name, values in (("Kaa", reduced.kaa), ("Max", reduced.max), ("Mxx", reduced.mxx), ("Kxx", reduced.kxx), ("Fa", reduced.fa),
                             ("Fx", reduced.fx), ("R", reduced.r)):
            file[name] = values
        file.attrs["format"], file.attrs["version"], file.attrs["units"] = "dovetail-reduced", 1, units
        file.attrs["force_names"] = [f"{name}_{j}" for name, j in wheel.loads]
