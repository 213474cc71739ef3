"""Faces with 3, 4, 6 or 8 nodes: shape functions, areas, and the foot of a point.

Corner nodes come first, counter-clockwise seen from outside, then mid-side nodes, the first between corners 0 and 1. Triangles
live on (0, 0), (1, 0), (0, 1), quadrilaterals on the square from -1 to 1.
"""

import numpy as np

_TRIANGLE = np.array([(0, 0), (1, 0), (0, 1), (0.5, 0), (0.5, 0.5), (0, 0.5)])
_SQUARE = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (0, -1), (1, 0), (0, 1), (-1, 0)], dtype=float)
NODES = {3: _TRIANGLE[:3], 4: _SQUARE[:4], 6: _TRIANGLE, 8: _SQUARE}  # reference coordinates (k, 2) by number of nodes
CORNERS = {3: 3, 4: 4, 6: 3, 8: 4}

# A quadrilateral is cut along either diagonal and both cuts count half, so that no corner is favoured: (nodes, weight).
_CUTS = [((0, 1, 2), 0.5), ((0, 2, 3), 0.5), ((0, 1, 3), 0.5), ((1, 2, 3), 0.5)]
TRIANGLES = {
    3: [((0, 1, 2), 1.0)],
    4: _CUTS,
    6: [((0, 3, 5), 1.0), ((3, 1, 4), 1.0), ((5, 4, 2), 1.0), ((3, 4, 5), 1.0)],
    8: [((0, 4, 7), 1.0), ((1, 5, 4), 1.0), ((2, 6, 5), 1.0), ((3, 7, 6), 1.0), *((tuple(i + 4 for i in cut), w) for cut, w in _CUTS)],
}  # of a face, by number of nodes


def shape(k, xi):
    """Shape functions of a face with k nodes at xi (m, 2): values (m, k) and slopes (m, k, 2)."""
    x, y = xi[:, 0], xi[:, 1]
    if k in (3, 6):
        zero, one = np.zeros_like(x), np.ones_like(x)
        corner = np.stack([1 - x - y, x, y], axis=1)  # (m, 3) area coordinates
        slope = np.stack([np.stack([-one, -one], 1), np.stack([one, zero], 1), np.stack([zero, one], 1)], axis=1)
        if k == 3:
            return corner, slope
        following = np.roll(corner, -1, axis=1)
        values = np.concatenate([corner * (2 * corner - 1), 4 * corner * following], axis=1)
        sides = 4 * (slope * following[:, :, None] + corner[:, :, None] * np.roll(slope, -1, axis=1))
        return values, np.concatenate([slope * (4 * corner[:, :, None] - 1), sides], axis=1)
    a, b = _SQUARE[:4].T
    u, v = 1 + x[:, None] * a, 1 + y[:, None] * b  # (m, 4)
    if k == 4:
        return u * v / 4, np.stack([a * v, u * b], axis=2) / 4
    w = u + v - 3  # a x + b y - 1
    corner = u * v * w / 4
    corner_slope = np.stack([a * v * (w + u), b * u * (w + v)], axis=2) / 4
    values, slopes = [corner], [corner_slope]
    for i in range(4, 8):
        a, b = _SQUARE[i]
        if a == 0:
            value, along, across = (1 - x**2) * (1 + b * y) / 2, -x * (1 + b * y), b * (1 - x**2) / 2
        else:
            value, along, across = (1 - y**2) * (1 + a * x) / 2, a * (1 - y**2) / 2, -y * (1 + a * x)
        values.append(value[:, None])
        slopes.append(np.stack([along, across], axis=1)[:, None])
    return np.concatenate(values, axis=1), np.concatenate(slopes, axis=1)


def node_areas(X):
    """Area (m, k) [m^2] that belongs to each node of faces X (m, k, 3): a third of every triangle it is a corner of."""
    areas = np.zeros(X.shape[:2])
    for triangle, weight in TRIANGLES[X.shape[1]]:
        p, q, r = (X[:, i] for i in triangle)
        third = weight / 6 * np.linalg.norm(np.cross(q - p, r - p), axis=1)
        for i in triangle:
            areas[:, i] += third
    return areas


def normals(X, xi):
    """Outward unit normals (m, 3) of faces X (m, k, 3) at xi (m, 2)."""
    slope = np.einsum("mka,mki->mia", shape(X.shape[1], xi)[1], X)
    normal = np.cross(slope[:, :, 0], slope[:, :, 1])
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)


def into(k, xi):
    """xi (m, 2) moved to the nearest place of the reference face."""
    if CORNERS[k] == 4:
        return np.clip(xi, -1, 1)
    beyond = np.maximum(xi.sum(axis=1, keepdims=True) - 1, 0) / 2
    return np.clip(xi - beyond, 0, 1)


def foot(points, X, inside, start=None, steps=50):
    """Reference coordinates (m, 2) of the place on face X[i] (m, k, 3) nearest to points[i] (m, 3), by Gauss-Newton.

    inside: keep to the face itself; otherwise the face may be continued a little beyond its edges.
    """
    k = X.shape[1]
    xi = np.tile(NODES[k][:CORNERS[k]].mean(axis=0), (len(X), 1)) if start is None else start
    for _ in range(steps):
        values, slopes = shape(k, xi)
        slope = np.einsum("mka,mki->mia", slopes, X)
        left = points - np.einsum("mk,mki->mi", values, X)
        normal_matrix = np.einsum("mia,mib->mab", slope, slope)
        small = 1e-15 * np.trace(normal_matrix, axis1=1, axis2=2)[:, None] + np.finfo(float).tiny
        normal_matrix[:, [0, 1], [0, 1]] += small  # a degenerate face must not stop the others
        step = np.linalg.solve(normal_matrix, np.einsum("mia,mi->ma", slope, left)[..., None])[..., 0]
        following = into(k, xi + step) if inside else np.clip(xi + step, -3, 3)
        change = np.abs(following - xi).max(initial=0)
        xi = following
        if change < 1e-14:
            break
    return _or_on_an_edge(points, X, xi) if inside else xi


def _or_on_an_edge(points, X, xi, steps=20):
    """xi, or the place on an edge of the face that is nearer: on skewed faces, what is nearest in reference coordinates is not."""
    k = X.shape[1]
    corners = NODES[k][:CORNERS[k]]
    start, nearest = xi, np.linalg.norm(points - np.einsum("mk,mki->mi", shape(k, xi)[0], X), axis=1)
    for begin, end in zip(corners, np.roll(corners, -1, axis=0)):
        t = np.clip((start - begin) @ (end - begin) / ((end - begin) @ (end - begin)), 0, 1)
        for _ in range(steps):
            values, slopes = shape(k, begin + t[:, None] * (end - begin))
            along = np.einsum("mka,mki,a->mi", slopes, X, end - begin)
            left = points - np.einsum("mk,mki->mi", values, X)
            length = np.maximum(np.einsum("mi,mi->m", along, along), np.finfo(float).tiny)
            t = np.clip(t + np.einsum("mi,mi->m", along, left) / length, 0, 1)
        tried = begin + t[:, None] * (end - begin)
        distance = np.linalg.norm(points - np.einsum("mk,mki->mi", shape(k, tried)[0], X), axis=1)
        closer = distance < nearest * (1 - 1e-14)
        xi, nearest = np.where(closer[:, None], tried, xi), np.minimum(distance, nearest)
    return xi
