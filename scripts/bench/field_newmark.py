"""Time integration as it is commonly done: Newmark's method (constant mean acceleration) in plain NumPy, with equal steps.

The contact forces at the end of each step are found by fixed-point iteration, in which the mass rules; sliders move once per step. It
shares nothing with Dovetail but the contact law.
"""

import numpy as np

MOST_PERIODS, MOST_ITERATIONS = 2000, 100
WINDOW = 6  # periods whose largest change is taken, as changes beat


def contact_force(x, w, contact):
    """Forces (N_x, 3) at displacement x (N_x, 3) from sliders that stand at w (N_x, 2), and where they stand then."""
    normal = contact.kn * np.maximum(x[:, 2] - contact.gap, 0)
    reach = contact.mu * normal[:, None] / contact.kt
    w = np.minimum(np.maximum(w, x[:, :2] - reach), x[:, :2] + reach)
    return np.column_stack([contact.kt * (x[:, :2] - w), normal]), w


def steady_harmonic(system, static, omega, steps, accuracy, watched):
    """First harmonic (complex) of a combination of the unknowns in the steady state, and the periods that it took from rest.

    system : reference.HarmonicBalance, for its matrices, contact, preload state and excitation (cosine)
    static : (n,) force that holds the preload state; watched : (n,) weights
    The march ends when what is left to come, by the rate at which that harmonic settles, is below `accuracy` of it.
    """
    K, M, C, contact, preload = system.K, system.M, system.C, system.contact, system.preload
    modes, force = system.modes, system.excitation[:, 1]
    h = 2 * np.pi / omega / steps
    inverse = np.linalg.inv(K + 2 / h * C + 4 / h**2 * M)
    rest = np.concatenate([np.zeros(modes), preload.xp.ravel()])
    u, v, w, g = rest.copy(), np.zeros(len(rest)), preload.w, preload.g
    total = np.zeros(len(rest))
    total[modes:] = g.ravel()
    a = np.linalg.solve(M, force + static - C @ v - K @ u - total)
    tolerance = 1e-3 * accuracy * np.abs(inverse @ force).max()
    angles = 2 * np.pi * np.arange(1, steps + 1) / steps
    wave, course = 2 / steps * np.exp(-1j * angles), np.empty(steps)
    last, changes = 0.0, []
    for period in range(1, MOST_PERIODS + 1):
        for j in range(steps):
            known = force * np.cos(angles[j]) + static + M @ (4 / h**2 * u + 4 / h * v + a) + C @ (2 / h * u + v)
            new = u + h * v + h**2 / 2 * a
            for _ in range(MOST_ITERATIONS):
                g, foot = contact_force(new[modes:].reshape(-1, 3), w, contact)
                total[modes:] = g.ravel()
                before, new = new, inverse @ (known - total)
                if np.abs(new - before).max() < tolerance:
                    break
            else:
                raise RuntimeError(f"the contact forces do not settle within a step of 1/{steps} period")
            velocity = 2 / h * (new - u) - v
            u, v, a, w = new, velocity, 2 / h * (velocity - v) - a, foot
            course[j] = watched @ u
        now = course @ wave
        changes.append(abs(now - last))
        last = now
        if period >= 2 * WINDOW:
            older, newer = max(changes[-2 * WINDOW:-WINDOW]), max(changes[-WINDOW:])
            rate = (newer / older) ** (1 / WINDOW) if older else 0.0
            if rate < 1 and newer / (1 - rate) < accuracy * abs(now):
                return now, period
    raise RuntimeError(f"not settled after {MOST_PERIODS} periods")
