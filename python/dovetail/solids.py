"""Shape functions of solid cells, where they are integrated, and how values there go to the nodes.

Names and node order are those of `cells`. A kind of cell has the polynomials `POWERS`, on the reference cell whose corners are `CORNERS`.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from .cells import EDGES

USUAL, REDUCED, FULL, INCOMPATIBLE = range(4)  # how a cell is integrated, and that it has incompatible modes (C3D8I)
INTEGRATION = ("usual", "reduced", "full", "incompatible")
CORNERS = {
    "tetra": np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float),
    "wedge": np.array([(0, 0, -1), (1, 0, -1), (0, 1, -1), (0, 0, 1), (1, 0, 1), (0, 1, 1)], dtype=float),
    "hexahedron": np.array([(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)], float),
}
SHAPE = {"tetra": "tetra", "tetra10": "tetra", "wedge": "wedge", "wedge15": "wedge", "hexahedron": "hexahedron",
         "hexahedron20": "hexahedron"}  # the solids that have strains here
_UP_TO_2 = [p for p in np.ndindex(3, 3, 3) if sum(p) <= 2]
_FLAT = [(0, 0), (1, 0), (0, 1)]
POWERS = {  # of x, y, z
    "tetra": [p for p in _UP_TO_2 if sum(p) <= 1],
    "tetra10": _UP_TO_2,
    "wedge": [(*p, k) for p in _FLAT for k in (0, 1)],
    "wedge15": [(*p, k) for p in np.ndindex(3, 3) if sum(p) <= 2 for k in (0, 1)] + [(*p, 2) for p in _FLAT],
    "hexahedron": list(np.ndindex(2, 2, 2)),
    "hexahedron20": [p for p in np.ndindex(3, 3, 3) if p.count(2) <= 1],
}
_TWO, _THREE = np.array([-1, 1]) / np.sqrt(3), np.array([-1, 0, 1]) * np.sqrt(0.6)
_A, _B = (5 + 3 * np.sqrt(5)) / 20, (5 - np.sqrt(5)) / 20
_TRIANGLE = [(1 / 6, 1 / 6), (2 / 3, 1 / 6), (1 / 6, 2 / 3)]


def _cube(places):
    return np.array([(x, y, z) for z in places for y in places for x in places])


POINTS = {  # Gauss points of each kind, those of CalculiX and Abaqus
    ("tetra", USUAL): np.full((1, 3), 0.25),
    ("tetra10", USUAL): np.array([(_B, _B, _B), (_A, _B, _B), (_B, _A, _B), (_B, _B, _A)]),
    ("wedge", USUAL): np.array([(1 / 3, 1 / 3, z) for z in _TWO]),
    ("wedge15", USUAL): np.array([(*p, z) for z in _THREE for p in _TRIANGLE]),
    ("hexahedron", USUAL): _cube(_TWO),
    ("hexahedron", REDUCED): _cube([0.0]),
    ("hexahedron", INCOMPATIBLE): _cube(_TWO),
    ("hexahedron20", USUAL): _cube(_TWO),
    ("hexahedron20", FULL): _cube(_THREE),
}
_FIVE_NINTHS = np.array([5, 8, 5]) / 9
WEIGHTS = {  # of these points, on the reference cell
    "tetra": np.full(1, 1 / 6), "tetra10": np.full(4, 1 / 24), "wedge": np.full(2, 1 / 2), "wedge15": np.repeat(_FIVE_NINTHS, 3) / 6,
    1: np.full(1, 8.0), 8: np.ones(8), 27: np.einsum("i,j,k->ijk", *[_FIVE_NINTHS] * 3).ravel(),  # of bricks, by their number
}


@dataclass(frozen=True)
class Rule:
    """points, weights : (p, 3), (p,) on the reference cell; slopes : (p, w, 3) of the shape functions; to_nodes : (w, p) to the nodes."""

    points: np.ndarray
    weights: np.ndarray
    slopes: np.ndarray
    to_nodes: np.ndarray


def places(kind):
    """(w, 3) reference coordinates of the nodes."""
    corners = CORNERS[SHAPE[kind]]
    return corners if kind == SHAPE[kind] else np.vstack([corners, [(corners[a] + corners[b]) / 2 for a, b in EDGES[SHAPE[kind]]]])


def shapes(kind, at):
    """Shape functions at reference coordinates `at` (p, 3): values (p, w) and slopes (p, w, 3)."""
    powers = np.array(POWERS[kind])
    coefficients = np.linalg.inv(_monomials(places(kind), powers))
    slopes = []
    for axis in range(3):
        lower = powers.copy()
        lower[:, axis] = np.maximum(lower[:, axis] - 1, 0)
        slopes.append(powers[:, axis] * _monomials(at, lower) @ coefficients)
    return _monomials(at, powers) @ coefficients, np.stack(slopes, axis=2)


@cache
def rule(kind, integration=USUAL):
    """The Rule of cells of a kind.

    Values at the nodes are those of a least-squares fit: constant, linear or trilinear from the corners, for 27 points with the 20 shape
    functions. CalculiX extrapolates in the same way.
    """
    points = POINTS[kind, integration]
    fitted = kind if integration == FULL else SHAPE[kind]
    to_nodes = shapes(fitted, places(kind))[0] @ np.linalg.pinv(shapes(fitted, points)[0])
    return Rule(points, WEIGHTS[kind if kind in WEIGHTS else len(points)], shapes(kind, points)[1], to_nodes)


def _monomials(at, powers):
    return np.prod(np.asarray(at, dtype=float)[:, None, :] ** powers, axis=2)
