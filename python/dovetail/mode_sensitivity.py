"""What frequency and damping ratio of a nonlinear mode depend on, at given amplitudes: derivatives by every contact parameter.

Dense, by the equations of the mode with sampled forces: M q'' + (C - 2 zeta omega M) q' + K q + g = constant load, |q_1|_M = alpha, and
no shift in time. du/dp = -J^-1 R_p; two transposed solves give all derivatives of omega and zeta.
"""

from dataclasses import dataclass, replace

import numpy as np

from .hdf5_read import opened
from .modes import LARGEST, Backbone, real_coefficients
from .parameters import CONTACT_WIDTH
from .recovery import reduced_file
from .reduced_system import FIELDS, equations, reduced_of
from .reference import contact_coefficients, contact_preload
from .results import Results

STEP = 1e-5  # relative, of the differences of R by a parameter
CLOSE, ITERATIONS = 1e-9, 30  # step at which the mode counts as solved, relative but for the damping ratio, and Newton iterations at most


@dataclass(frozen=True)
class ModeSensitivity:
    """Derivatives at m amplitudes, in user units.

    alpha, omega, damping_ratio : (m,)
    omega_by, damping_ratio_by : dicts by `normal_stiffness` (m, N_x), `tangential_stiffness` and `friction` (m, N_x, 2), `gap` (m, N_x)
    values : the parameters' own values, as `Results.contact`
    """

    alpha: np.ndarray
    omega: np.ndarray
    damping_ratio: np.ndarray
    omega_by: dict
    damping_ratio_by: dict
    values: dict

    def relative(self, name, of="damping_ratio"):
        """(p / y) dy/dp of y = omega or damping_ratio; for the gap (1 / y) dy/dgap. Shape as in `omega_by`."""
        slope, value = getattr(self, f"{of}_by")[name], getattr(self, of)
        factor = 1.0 if name == "gap" else self.values[name]
        return factor * slope / value.reshape(-1, *[1] * (slope.ndim - 1))


def mode_sensitivity(path, amplitudes, samples=None):
    """The ModeSensitivity of a run with [mode] at modal amplitudes between its first and last one; `samples` as for `equations`.

    Preload states go along with the parameters. Raises ValueError where the dense equations are too large.
    """
    results = path if isinstance(path, Results) else Results(path)
    if results.wave is not None:
        raise ValueError(f"{results.path}: is of one of {results.wave.sectors} sectors; derivatives of its modes are not computed")
    backbone, system = Backbone.read(results, samples), equations(results, samples)
    if (size := int(np.prod(system.shape))) > LARGEST:
        raise ValueError(f"{size} unknowns; the dense equations are for at most {LARGEST}")
    with opened(reduced_file(results)) as file:
        reduced, _ = reduced_of(file, results)
    found = []
    for alpha in amplitudes:
        omega, zeta, shape = backbone.at(alpha)
        shape = shape.copy()
        shape[:, 1:] *= alpha
        q, omega, zeta, J = solved_mode(system, real_coefficients(shape), omega, zeta, alpha)
        ends = np.zeros((len(J), 2))
        ends[-2, 0] = ends[-1, 1] = 1
        adjoint = np.linalg.solve(J.T, ends)[:-2]
        found.append((omega, zeta, {name: _slopes(system, reduced, results, name, q, adjoint) for name in CONTACT_WIDTH}))
    omega, zeta, slopes = zip(*found)
    by = [{name: np.array([each[name][..., i] for each in slopes]) for name in CONTACT_WIDTH} for i in (0, 1)]
    return ModeSensitivity(np.asarray(amplitudes, dtype=float), np.array(omega), np.array(zeta), *by, results.contact)


def solved_mode(system, q, omega, zeta, alpha):
    """q, omega, zeta of the mode with amplitude alpha by Newton's method, and the Jacobian in [q, omega, zeta] there."""
    constant = np.zeros_like(system.excitation)
    constant[:, 0] = system.excitation[:, 0]
    for _ in range(ITERATIONS):
        residual, J = _equations(system, q, omega, zeta, alpha, constant)
        step = np.linalg.solve(J, -residual)
        q, omega, zeta = q + step[:-2].reshape(q.shape), omega + step[-2], zeta + step[-1]
        if max(np.linalg.norm(step[:-2]) / np.linalg.norm(q), abs(step[-2]) / omega, abs(step[-1])) < CLOSE:
            return q, float(omega), float(zeta), _equations(system, q, omega, zeta, alpha, constant)[1]
    raise ValueError(f"amplitude {alpha:g}: Newton's method did not find the mode with sampled forces; take more samples")


def _equations(system, q, omega, zeta, alpha, constant):
    """Residual and Jacobian in [q, omega, zeta]; the last row keeps motions from shifting in time."""
    n, size = system.shape

    def fed(factor):
        return system.harmonic_blocks(lambda k: 0 * system.M, lambda k: factor * k * system.M)

    artificial = fed(-2 * zeta * omega**2)
    R = system.residual(q, omega).ravel() + (system.excitation - constant).ravel() + artificial @ q.ravel()
    by_omega = system.omega_derivative(q, omega).ravel() + fed(-4 * zeta * omega) @ q.ravel()
    by_zeta = fed(-2 * omega**2) @ q.ravel()
    c, s = system.M @ q[:, 1], system.M @ q[:, 2]
    norm, phase = np.zeros((2, n, size))
    norm[:, 1], norm[:, 2], phase[:, 1], phase[:, 2] = 2 * c, 2 * s, -s, c
    J = np.zeros((n * size + 2, n * size + 2))
    J[:-2, :-2] = system.jacobian(q, omega) + artificial
    J[:-2, -2], J[:-2, -1], J[-2, :-2], J[-1, :-2] = by_omega, by_zeta, norm.ravel(), phase.ravel()
    return np.concatenate([R, [q[:, 1] @ c + q[:, 2] @ s - alpha**2, 0.0]]), J


def _slopes(system, reduced, results, name, q, adjoint):
    """Derivatives of (omega, zeta) by a parameter, (N_x, 2) or (N_x, 2, 2)."""
    contact, field = system.contact, FIELDS[name]
    values = np.asarray(getattr(contact, field), dtype=float)
    size = np.abs(results.xp).max() if name == "gap" else 1.0
    slopes = np.zeros((*values.shape, 2))
    for place in np.ndindex(values.shape):
        step = STEP * (np.abs(values[place]) + (size if name == "gap" else 0.0))
        if step == 0:
            continue  # of a law without friction
        ends = []
        for sign in (1, -1):
            changed = values.copy()
            changed[place] += sign * step
            other = replace(contact, **{field: changed})
            ends.append(_contact_part(system, q, other, contact_preload(reduced, other, results.xp)))
        slopes[place] = -adjoint[system.modes * system.shape[1]:].T @ (ends[0] - ends[1]) / (2 * step)
    return slopes


def _contact_part(system, q, contact, preload):
    """Coefficients of the contact forces of a motion, flat."""
    return contact_coefficients(system.contact_part(q), contact, preload, system.N).ravel()
