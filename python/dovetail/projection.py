"""The place on the faces of a surface that is nearest to a point."""

from dataclasses import dataclass

import numpy as np

from . import faces as face_kinds
from .nearest import tree

OVERHANG = 0.05  # how far beyond the edge of a face a point may lie, in parts of the face's radius: curved edges never fit exactly


@dataclass(frozen=True)
class Feet:
    """Where m points stand on a surface, and the shape functions there.

    place (m, 3) [m], normal (m, 3) outward, overhang (m,) beyond the edge of the surface [m], allowed (m,) [m];
    and in list form, entry by entry: point (e,), node (e,) row of the surface, weight (e,), adding up to one for each point.
    """

    place: np.ndarray
    normal: np.ndarray
    overhang: np.ndarray
    allowed: np.ndarray
    point: np.ndarray
    node: np.ndarray
    weight: np.ndarray


def project(points, surface):
    """Feet of points (m, 3) on the faces of a surface.

    The nearest face is found among all that can be nearer than the nearest node is. Then the foot on the face, continued over
    its edges where the point overhangs a little, so that rigid motion is carried over exactly.
    """
    m = len(points)
    place, normal = np.empty((m, 3)), np.empty((m, 3))
    overhang, allowed = np.empty(m), np.empty(m)
    entries = []
    parts = [_nearest_faces(points[i:i + 4096], surface) for i in range(0, m, 4096)]  # their candidates take memory
    group, face = (np.concatenate(part) for part in zip(*parts))
    for g, rows in enumerate(surface.faces):
        mine = np.flatnonzero(group == g)
        nodes = rows[face[mine]]
        X, k = surface.points[nodes], rows.shape[1]
        within = face_kinds.foot(points[mine], X, inside=True)
        xi = face_kinds.foot(points[mine], X, inside=False, start=within)
        place[mine] = _at(X, xi)
        normal[mine] = face_kinds.normals(X, xi)
        clipped = face_kinds.into(k, xi)
        beyond = np.linalg.norm(place[mine] - _at(X, face_kinds.foot(place[mine], X, inside=True, start=clipped)), axis=1)
        overhang[mine] = np.where((clipped == xi).all(axis=1), 0.0, beyond)
        allowed[mine] = OVERHANG * _radii(X)
        entries.append((np.repeat(mine, k), nodes.ravel(), face_kinds.shape(k, xi)[0].ravel()))
    return Feet(place, normal, overhang, allowed, *(np.concatenate(parts) for parts in zip(*entries)))


def _nearest_faces(points, surface):
    """(group, face) of the nearest face of each point: number in the list `surface.faces`, row there."""
    to_node = tree(surface.points[np.unique(np.concatenate([rows.ravel() for rows in surface.faces]))]).query(points)[0]
    best = np.full(len(points), np.inf)
    group, face = np.zeros((2, len(points)), dtype=np.int64)
    for g, rows in enumerate(surface.faces):
        if not len(rows):
            continue
        X = surface.points[rows]
        centres, radii = X.mean(axis=1), _radii(X)
        near = tree(centres).query_ball_point(points, 1.01 * (to_node + radii.max()))  # a curved face may bulge a little
        point = np.repeat(np.arange(len(points)), [len(candidates) for candidates in near])
        candidate = np.concatenate([np.asarray(candidates, dtype=np.int64) for candidates in near])
        possible = np.linalg.norm(points[point] - centres[candidate], axis=1) <= 1.01 * (to_node[point] + radii[candidate])
        point, candidate = point[possible], candidate[possible]
        xi = face_kinds.foot(points[point], X[candidate], inside=True)
        distance = np.linalg.norm(points[point] - _at(X[candidate], xi), axis=1)
        order = np.lexsort((distance, point))  # nearest first within each point
        first = order[np.unique(point[order], return_index=True)[1]]
        better = distance[first] < best[point[first]]
        first = first[better]
        best[point[first]], group[point[first]], face[point[first]] = distance[first], g, candidate[first]
    return group, face


def _at(X, xi):
    return np.einsum("mk,mki->mi", face_kinds.shape(X.shape[1], xi)[0], X)


def _radii(X):
    return np.linalg.norm(X - X.mean(axis=1, keepdims=True), axis=2).max(axis=1)
