"""The part of a surface that lies over another one: which nodes, and how much of the area around them."""

import numpy as np

from . import faces as face_kinds
from .contact_points import FACING
from .nearest import tree
from .projection import project

SAMPLES = 6  # places across a face that lies over the other surface in part


def over(a, b, normals, tolerance, name):
    """Rows of a's nodes that lie over b and of which a side can move, and the area (m,) [m^2] of each that lies over b.

    Parameters
    ----------
    a, b : Surface
    normals : (n, 3) outward normals of a at its nodes
    tolerance : float, optional
        As in `Joint.between`.

    Where every node over b's faces has a partner there, these nodes are meant, else all over the faces. Faces of a count with
    the share that lies over b.
    """
    distance, partner = tree(b.points).query(a.points)
    near = distance <= (1e-6 * a.size if tolerance is None else tolerance)
    kept, paired = near, True
    if b.faces:
        above = _above(a.points, normals, b, tolerance)
        paired = bool(np.all(near[above]))
        kept = near if paired else above
    moves = (a.dofs >= 0).any(axis=1)
    kept = kept & (moves | (b.dofs[partner] >= 0).any(axis=1) if paired else moves)
    if not kept.any():
        raise ValueError(f"joint {name!r}: no node of {a.name!r} that can move lies over {b.name!r}; do the surfaces "
                         "touch, and do they face each other?")
    if not a.faces:
        return np.flatnonzero(kept), np.zeros(np.count_nonzero(kept))
    area = _areas(a, b, kept, tolerance)
    rows = np.flatnonzero(kept & (area > 0))  # a node that only touches the rim has no area in common
    if not rows.size:
        raise ValueError(f"joint {name!r}: {a.name!r} and {b.name!r} have nodes in common, but no area")
    return rows, area[rows]


def _above(points, normals, b, tolerance):
    feet = project(points, b)
    allowed = feet.allowed if tolerance is None else tolerance
    return (feet.overhang <= allowed) & (np.einsum("mi,mi->m", normals, feet.normal) <= FACING)


def _areas(a, b, kept, tolerance):
    """Area (n,) of the nodes that are kept: of each face the share over b, on those of its nodes that are kept."""
    area = np.zeros(len(a.points))
    for rows in a.faces:
        count = kept[rows].sum(axis=1)
        share = (count == rows.shape[1]).astype(float)
        partly = np.flatnonzero((count > 0) & (share == 0))
        if partly.size and b.faces:
            share[partly] = _shares(a.points[rows[partly]], b, tolerance)
        parts = face_kinds.node_areas(a.points[rows])
        mine = parts * kept[rows]
        total = mine.sum(axis=1, keepdims=True)
        factor = np.divide(parts.sum(axis=1, keepdims=True), total, out=np.zeros_like(total), where=total > 0)
        np.add.at(area, rows, mine * factor * share[:, None])
    return area


def _shares(X, b, tolerance):
    """Share (f,) of the faces X (f, k, 3) that lies over b, from places spread over each."""
    k = X.shape[1]
    xi = _places(k)
    places = np.einsum("sk,fki->fsi", face_kinds.shape(k, xi)[0], X)
    normals = np.stack([face_kinds.normals(X, np.tile(place, (len(X), 1))) for place in xi], axis=1)
    inside = _above(places.reshape(-1, 3), normals.reshape(-1, 3), b, 0.0 if tolerance is None else tolerance)
    return inside.reshape(len(X), -1).mean(axis=1)


def _places(k):
    """Reference coordinates (s, 2) of places that each stand for an equal part of a face with k nodes."""
    if face_kinds.CORNERS[k] == 4:
        line = (np.arange(SAMPLES) + 0.5) / SAMPLES * 2 - 1
        return np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    i, j = np.nonzero(np.add.outer(np.arange(SAMPLES), np.arange(SAMPLES)) < SAMPLES)
    upright = np.stack([i, j], axis=1) + 1 / 3
    inner = i + j < SAMPLES - 1
    return np.concatenate([upright, np.stack([i, j], axis=1)[inner] + 2 / 3]) / SAMPLES
