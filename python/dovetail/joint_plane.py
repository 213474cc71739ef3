"""Contact points in the plane of their joint."""

import numpy as np


def in_plane(position, axes):
    """Coordinates (m, 2) [m] in the mean tangent plane of a joint, from the centre of its points; t1 to the right, t2 upwards."""
    normal = axes[:, 2].mean(axis=0)
    normal = normal / np.linalg.norm(normal) if np.linalg.norm(normal) > 1e-6 else axes[0, 2]
    first = axes[:, 0].mean(axis=0)
    first = first - (first @ normal) * normal
    if np.linalg.norm(first) < 1e-6:
        first = np.eye(3)[np.argmin(np.abs(normal))]
        first = first - (first @ normal) * normal
    first = first / np.linalg.norm(first)
    centred = position - position.mean(axis=0)
    return np.stack([centred @ first, centred @ np.cross(normal, first)], axis=1)


def lying(places):
    """The places with their longer side to the right, and the names of the axes."""
    x, y = np.ptp(places, axis=0)
    return (places, ("t1", "t2")) if y <= 1.2 * x else (places[:, ::-1], ("t2", "t1"))
