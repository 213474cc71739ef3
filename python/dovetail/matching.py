"""Nodes of two surfaces that lie at the same place."""

import numpy as np

from .nearest import tree


def partners(points, b, tolerance, name):
    """Row of b's node at each of the points (m, 3), (m,), or None when some point has none within the tolerance [m].

    Raises ValueError when two points have the same partner.
    """
    if not tolerance >= 0:
        raise ValueError(f"joint {name!r}: tolerance must not be negative, found {tolerance!r}")
    distance, row = tree(b.points).query(points)
    if np.any(distance > tolerance):
        return None
    taken, counts = np.unique(row, return_counts=True)
    if counts.max() > 1:
        raise ValueError(f"joint {name!r}: node {b.labels[taken[counts.argmax()]]} of {b.name!r} is the partner of {counts.max()} contact "
                         f"points; make the tolerance ({tolerance:.3g}) smaller than the distance between nodes")
    return row
