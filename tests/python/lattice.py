"""Surfaces of faces of one kind over a rectangle, for the tests."""

import numpy as np

from dovetail import Surface


def lattice(counts, kind, height, corner=(0.0, 0.0), edges=(2.0, 1.0), up=True):
    """A surface of faces of one kind over a rectangle, z = height(x, y), looking up or down; dofs from 0."""
    quadratic = kind in (6, 8)
    steps = 2 if quadratic else 1
    nx, ny = (steps * c + 1 for c in counts)
    x, y = np.meshgrid(np.linspace(corner[0], corner[0] + edges[0], nx), np.linspace(corner[1], corner[1] + edges[1], ny), indexing="ij")
    rows = []
    for i in range(0, nx - 1, steps):
        for j in range(0, ny - 1, steps):
            def at(a, b):
                return (i + a) * ny + j + b
            if kind == 4:
                rows.append([at(0, 0), at(1, 0), at(1, 1), at(0, 1)])
            elif kind == 8:
                rows.append([at(0, 0), at(2, 0), at(2, 2), at(0, 2), at(1, 0), at(2, 1), at(1, 2), at(0, 1)])
            elif kind == 3:
                rows += [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]]
            else:
                rows += [[at(0, 0), at(2, 0), at(2, 2), at(1, 0), at(2, 1), at(1, 1)],
                         [at(0, 0), at(2, 2), at(0, 2), at(1, 1), at(1, 2), at(0, 1)]]
    rows = np.array(rows)
    if not up:
        rows = rows[:, {3: [0, 2, 1], 4: [0, 3, 2, 1], 6: [0, 2, 1, 5, 4, 3], 8: [0, 3, 2, 1, 7, 6, 5, 4]}[kind]]
    points = np.stack([x.ravel(), y.ravel(), height(x, y).ravel()], axis=1)
    used, rows = np.unique(rows, return_inverse=True)
    rows = rows.reshape(-1, kind)
    return Surface(points[used], np.arange(3 * len(used)).reshape(-1, 3), [rows], "up" if up else "down")
