"""Slider positions that other orders of preload leave: residual friction of points that stick, and the load by which a run begins with it.

Where a point sticks in the preload its slider may be anywhere with |k_t (x_t - w)| <= mu N. The program loads in one step from sliders
at zero. It reaches any other state in coordinates x_t - w_0: the law is the same, and the load gains K_xx w_0.
"""

import numpy as np

from .hdf5_read import numbers, opened
from .reference.contact import CONE
from .sobol import sobol

ROUNDS = 30  # in which the bounds follow the normal forces
NAMED = {"no friction": (0.0, 0.0), "all along t1": (1.0, 0.0), "all against t1": (-1.0, 0.0), "all along t2": (0.0, 1.0),
         "all against t2": (0.0, -1.0)}  # friction forces as parts of their bounds


def slider_states(results, reduced, count, seed, factor=1.0):
    """(name, w_0 (N_x, 2)) of the states of NAMED and of `count` more, Sobol's points over all friction forces within their bounds.

    results : Results whose preload state and contact parameters they are of; reduced : its reduced file; factor : on the preload there
    """
    with opened(reduced) as file:
        K, R = np.asarray(file["Kxx"], dtype=float), factor * numbers(file, "R")
    points = results.contact_points
    parts = [(name, np.tile(part, (points, 1))) for name, part in NAMED.items()]
    rubs = sticking(results)
    if count and rubs.any():
        for i, row in enumerate(sobol(2 * rubs.sum(), count, seed)):
            part = np.zeros((points, 2))
            part[rubs] = row.reshape(-1, 2)
            parts.append((f"state {i + 1}", part))
    at = np.arange(2, len(K), 3)[_closed(results)]
    K[at, at] += results.contact["normal_stiffness"][_closed(results)]
    flexibility = np.linalg.pinv(K, hermitian=True)
    return [(name, sliders(results, flexibility, R, part)) for name, part in parts]


def sticking(results):
    """(N_x,) whether a point has friction and presses in the preload."""
    return (results.contact["law"] <= CONE) & (results.g.reshape(-1, 3)[:, 2] > 0)


def sliders(results, flexibility, R, parts):
    """w_0 (N_x, 2) for which friction forces in the preload are these parts (N_x, 2) of their bounds mu N, as far as loads allow it.

    flexibility : (3 N_x, 3 N_x) of the structure on the normal springs of the points that press, a pseudo-inverse where it is loose
    """
    contact, rubs = results.contact, sticking(results)
    kn, kt, mu = contact["normal_stiffness"], contact["tangential_stiffness"], contact["friction"]
    closed, normal = _closed(results), results.g.reshape(-1, 3)[:, 2]
    parts = np.where((contact["law"] == CONE)[:, None], parts / np.maximum(np.linalg.norm(parts, axis=1, keepdims=True), 1), parts)
    for _ in range(ROUNDS):
        friction = np.where(rubs[:, None], parts * mu * np.maximum(normal, 0)[:, None], 0)
        force = np.column_stack([friction, np.where(closed, -kn * contact["gap"], 0)])
        x = (flexibility @ (-R - force.ravel())).reshape(-1, 3)
        normal = np.where(closed, kn * (x[:, 2] - contact["gap"]), 0)
    return np.where(rubs[:, None], x[:, :2] - friction / np.where(rubs[:, None], kt, 1), 0)


def _closed(results):
    """(N_x,) whether a point presses, or pulls where its law lets it."""
    return results.g.reshape(-1, 3)[:, 2] != 0


def shifted_load(file, w_0):
    """What the load R of an open reduced file gains where sliders begin at w_0."""
    shift = np.zeros((len(w_0), 3))
    shift[:, :2] = w_0
    return np.asarray(file["Kxx"], dtype=float) @ shift.ravel()
