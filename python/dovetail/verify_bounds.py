"""How large the residual of a point may be: what Newton's method leaves, what lies between samples, and last bits."""

import functools
import tomllib

import numpy as np

from . import reference
from .hdf5_read import numbers, patiently

ROUND = 1e-9  # of the force of a cone, ten times what it may have changed by when a period is taken for the last
NEWTON = 1e-8  # default of newton.residual_tolerance
HARDLY = 1e-3  # of a force: a mode that is moved by less than another sets no unit
LAST_BITS = 256  # of a force and its parts: numbers are scaled, written, and added up in another order


def scaled_forces(results, system):
    """Residuals of the modes and of the contact points that count as 1 in the scaled variables of the run: section 7 of the theory."""
    scaling = tomllib.loads(results.case).get("scaling", {})
    if scaling.get("kind", "auto") == "none":
        return 1.0, 1.0
    if scaling.get("kind", "auto") == "manual":
        modal = scaling["modal"] * scaling["frequency"]**2
        return modal, modal * scaling["modal"] / scaling["contact"]
    if results.modal_amplitude is not None:
        return _of_the_mode(results)
    K, M = (np.real(np.diag(matrix)) for matrix in system.matrices(1))
    drive = np.linalg.norm(system.excitation[:, 1:], axis=1)
    modes, contact = system.modes, system.contact
    modal = functools.reduce(lambda chosen, force: force if chosen < HARDLY * force else chosen, drive[:modes], 0.0)
    w2, mass, force = K[0] if modes else _first_omega(results)**2, M[modes:].max(initial=0), drive[modes:].max(initial=0)
    rubs = contact.kind <= reference.contact.CONE
    pressed = np.abs(system.K[modes:, modes:] @ system.preload.xp.ravel() + system.preload.g.ravel()).reshape(-1, 3)  # R
    holds = contact.mu.max(axis=1) * np.maximum(pressed.max(axis=1), system.preload.g[:, 2])
    limit = holds / np.where(rubs, contact.kt.min(axis=1), 1)
    slip = np.max(limit[rubs], initial=0.0)
    stiff = max(np.max(values, initial=0.0) for values in (np.abs(K[modes:]), contact.kn, contact.kt.min(axis=1)[rubs]))
    length = slip if slip > 0 else force / stiff if force > 0 and stiff > 0 else 1.0
    amplitude = modal / w2 if modal > 0 else np.sqrt(length * force / w2) if force > 0 else 1.0
    if modal > 0 and mass > 0:
        length = amplitude / np.sqrt(mass)
    return amplitude * w2, amplitude**2 * w2 / length


def _first_omega(results):
    """Where the run begins; where it follows a peak, the sweep before it."""
    if results.tracked_amplitude is None:
        return results.omega[0]
    settings = tomllib.loads(results.case)["continuation"]
    return settings["omega"][0] / (results.unit.hertz(1.0) if settings.get("unit") == "Hz" else 1.0)


def _of_the_mode(results):
    """The same of a nonlinear mode, which has no load to scale by: by the onset, or without one by the amplitude it begins with."""
    def scales(file):
        omega, onset, shape = (numbers(file, f"mode/{name}", (None, ...)) for name in ("omega", "onset", "shape"))
        shape = shape if shape.ndim == 1 else np.hypot(*shape.T)
        return omega[0], onset[0], np.abs(shape[results.modes:]).max(initial=0.0)
    omega, onset, largest = patiently(results.path, scales)
    modal = (onset if np.isfinite(onset) else tomllib.loads(results.case)["mode"]["amplitude"][0]) * omega**2
    return modal, modal / (largest if largest > 0 else 1.0)


def between_samples(system, q, samples, sampled, G):
    """By how much the coefficients (N_x, 3) of forces that the run has exact may be off here, where a period has samples.

    Sliders turn, slip and lift off between two samples. The motion leaves the straight line between them by x'' dt^2 / 8 at most.
    Forces of `sampled` points are the run's own, but for the cone, whose period is taken for the last when little changes.
    """
    X, contact = system.contact_part(q), system.contact
    bend = np.hypot(X[..., 1::2], X[..., 2::2]) @ np.arange(1, system.H + 1)**2 * (2 * np.pi / samples)**2 / 8
    normal = (contact.kn * bend[:, 2])[:, None]
    off = 2 * np.hstack([contact.kt * bend[:, :2] + contact.mu * normal, normal])  # no coefficient is more than twice the largest value
    round_off = ROUND * (contact.kind == reference.contact.CONE) * np.linalg.norm(G)
    return np.where(sampled[:, None], round_off[:, None], off)


def last_bits(system, q, omega):
    """By how much forces (n, 2H+1) may be off because numbers have 16 digits."""
    def parts(k):
        K, M = system.matrices(k)
        return np.abs(K) + (k * omega)**2 * np.abs(M)
    shift = np.abs(q)
    shift[system.modes:, 0] += np.abs(system.preload.xp).ravel()
    size = np.hypot(shift[:, 1::2], shift[:, 2::2])
    both = np.zeros_like(q)
    both[:, 0] = parts(0) @ shift[:, 0]
    for k in range(1, system.H + 1):
        both[:, 2 * k - 1] = parts(k) @ size[:, k - 1]
    springs = np.column_stack([system.contact.kt, system.contact.kn]).ravel()
    both[system.modes:] += springs[:, None] * shift[system.modes:]
    return LAST_BITS * np.finfo(float).eps * both


def residual_told(results, point):
    """What the file says Newton's method has left at a point, in scaled variables; where it says nothing, the tolerance."""
    try:
        return float(results.points("residual")[point])
    except KeyError:
        return newton_tolerance(results)


def newton_tolerance(results):
    return tomllib.loads(results.case).get("newton", {}).get("residual_tolerance", NEWTON)
