"""A reduced model integrated in time with equal steps: what becomes of a pushed periodic motion, period by period."""

import numpy as np
import scipy.linalg

from dovetail import reference


def periods(system, q, omega, count, steps, push):
    """(count, n) displacements of a `HarmonicBalance` at the beginning of each period, from the motion q moved by `push` (n,).

    The structure with springs at its contact points goes on exactly from step to step; what contact forces are besides is linear
    between two, and the feet of sliders are dragged, or set down, at every one.
    """
    n, modes, contact, preload = len(system.K), system.modes, system.contact, system.preload
    springs, step = np.column_stack([contact.kt, contact.kn]), 2 * np.pi / omega / steps
    K = system.K + np.diag(np.concatenate([np.zeros(modes), springs.ravel()]))
    A, inverse = np.zeros((4 * n, 4 * n)), np.linalg.inv(system.M)  # of u, v, forces, and by what these grow in a step
    A[:n, n:2 * n], A[2 * n:3 * n, 3 * n:] = step * np.eye(n), np.eye(n)
    A[n:2 * n] = -step * np.hstack([inverse @ K, inverse @ system.C, -inverse, np.zeros((n, n))])
    on, constant, growing = (part.copy() for part in np.split(scipy.linalg.expm(A)[:2 * n], [2 * n, 3 * n], axis=1))
    load = reference.synthesis(system.excitation, steps)
    load = (constant @ load + growing @ (np.roll(load, -1, axis=1) - load)).T
    constant, growing = constant[:, modes:], growing[:, modes:]

    def forces(x, last, feet, is_open):
        """Contact forces, feet and what is open after a step, from the total motion before it."""
        normal, before = contact.kn * (x[:, 2] - contact.gap), contact.kn * (last[:, 2] - contact.gap)
        opens = normal <= 0
        lands = (is_open & ~opens)[:, None]
        part = np.where(lands[:, 0], before / np.where(lands[:, 0], before - normal, 1), 0)[:, None]
        feet = np.where(lands, last[:, :2] + part * (x - last)[:, :2], feet)
        limit = contact.mu * np.where(opens, 0, normal)[:, None]
        friction = np.clip(contact.kt * (x[:, :2] - feet), -limit, limit)
        return np.column_stack([friction, np.where(opens, 0, normal)]), x[:, :2] - friction / contact.kt, opens

    def besides(force, x):
        return (springs * (x - preload.xp) - (force - preload.g)).ravel()

    x = np.swapaxes(reference.synthesis(system.contact_part(q), 4096), -1, -2)
    force, states = reference.law(x, preload.xp, preload.w, contact.kn, contact.kt, contact.mu, contact.gap)
    feet, is_open = x[:, 0, :2] + preload.xp[:, :2] - force[:, 0, :2] / contact.kt, states[:, 0, 0] == reference.OPEN
    z = np.concatenate([q[:, 0] / 2 + q[:, 1::2].sum(axis=1) + push, omega * q[:, 2::2] @ np.arange(1, q.shape[1] // 2 + 1)])
    x, found = z[modes:n].reshape(-1, 3) + preload.xp, np.empty((count, n))
    rest = besides(forces(x, x, feet, is_open)[0], x)
    for period in range(count):
        found[period] = z[:n]
        for i in range(steps):
            begun = on @ z + load[i] + constant @ rest
            z = begun
            for _ in range(2):
                now = z[modes:n].reshape(-1, 3) + preload.xp
                z = begun + growing @ (besides(forces(now, x, feet, is_open)[0], now) - rest)
            now = z[modes:n].reshape(-1, 3) + preload.xp
            force, feet, is_open = forces(now, x, feet, is_open)
            rest, x = besides(force, now), now
    return found
