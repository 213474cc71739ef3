"""One of N equal sectors: the axis, and which nodes of its left and right side belong together.

The right side is the left one turned by +2 pi / N about the axis, by the right-hand rule; so is every following sector.
"""

from dataclasses import dataclass

import numpy as np

from .loads import real_vector
from .nearest import tree
from .units import parse

MOST = 10**6  # sectors of a disk
FARTHEST = 1e6  # from the mesh to a point on its axis, in sizes of the mesh: beyond, coordinates have too few digits
WHOLE = 1e-6  # so near to a whole number of sectors an angle is meant to be one


@dataclass(frozen=True)
class Cyclic:
    """A matched sector; made by `Structure.cyclic`.

    sectors : int; axis : (3,) unit vector; origin : (3,) [m], a point of the axis
    left, right : (p,) int
        Node rows: right[i] is left[i] turned by 2 pi / sectors.
    on_axis : (k,) int, node rows of either side that a turn does not move
    left_name, right_name : str
    mismatch : float [m], largest distance of partners
    """

    sectors: int
    axis: np.ndarray
    origin: np.ndarray
    left: np.ndarray
    right: np.ndarray
    on_axis: np.ndarray
    left_name: str
    right_name: str
    mismatch: float

    @property
    def rotation(self):
        """R (3, 3), the turn from a sector to the next."""
        return turn(self.axis, 2 * np.pi / self.sectors)

    def report(self, units="SI"):
        """What was matched, in a line; `units` are those of the model."""
        length = parse(units).length
        unit = f" {length}" if length else ""
        said = [f"({', '.join(f'{value + 0.0:.6g}' for value in vector)})" for vector in (self.axis, self.origin)]
        return (f"one of {self.sectors} sectors about the axis {said[0]} through {said[1]}: {len(self.left)} pairs of nodes of "
                f"{self.left_name} and {self.right_name}, at most {self.mismatch:.3g}{unit} apart")

    def to_next(self, points):
        """The points (m, 3) [m] of the next sector that correspond to points of this one."""
        return about(points, self.origin, self.rotation)


def turn(axis, angle):
    """(3, 3) rotation about a unit vector by an angle [rad]."""
    x, y, z = axis
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * across @ across


def unit(axis):
    """The vector (3,) at unit length."""
    axis = real_vector(axis, "axis", "-")
    if not np.any(axis):
        raise ValueError("axis must not be zero")
    axis = axis / np.abs(axis).max()  # whose squares neither overflow nor vanish
    return axis / np.linalg.norm(axis)


def about(points, origin, rotation):
    """Points (m, 3) turned about an axis through `origin`."""
    return origin + (points - origin) @ rotation.T


def matched(structure, sectors, left, right, axis, origin, tolerance):
    """The Cyclic of a structure, arguments as in `Structure.cyclic`. ValueError unless the sides fit each other."""
    if isinstance(sectors, bool) or not isinstance(sectors, (int, np.integer)) or not 2 <= sectors <= MOST:
        raise ValueError(f"sectors must be a whole number from 2 on, of at most {MOST}, found {sectors!r}")
    axis, origin = unit(axis), real_vector(origin, "origin", "m")
    size = float(np.linalg.norm(np.ptp(structure.nodes, axis=0)))
    if not np.linalg.norm(structure.nodes - origin, axis=1).max(initial=0) <= FARTHEST * size:
        raise ValueError(f"origin must be a point on the axis near the mesh, at most {FARTHEST:g} times its size away, found "
                         f"{origin.tolist()}")
    tolerance = 1e-6 * size if tolerance is None else tolerance
    if isinstance(tolerance, bool) or not isinstance(tolerance, (int, float)) or not 0 <= tolerance < np.inf:
        raise ValueError(f"tolerance must be a finite number that is not negative [m], found {tolerance!r}")
    names = _name_of(left, "left"), _name_of(right, "right")
    sides = [np.unique(structure._nodes(where)) for where in (left, right)]
    distance = np.linalg.norm(np.cross(structure.nodes - origin, axis), axis=1)
    on_axis = np.unique(np.concatenate([rows[distance[rows] <= tolerance] for rows in sides]))
    sides = [np.setdiff1d(rows, on_axis) for rows in sides]
    _need_two_sides(sides, names, structure.labels)
    left, right, mismatch = _paired(structure, sides, names, sectors, axis, origin, float(tolerance))
    return Cyclic(int(sectors), axis, origin, left, right, on_axis, *names, mismatch)


def _name_of(where, otherwise):
    """What a side is called in messages."""
    if isinstance(where, str):
        return where
    names = list(where)
    return ", ".join(names) if names and all(isinstance(name, str) for name in names) else otherwise


def _need_two_sides(sides, names, labels):
    for rows, name in zip(sides, names):
        if not rows.size:
            raise ValueError(f"no node of {name!r} is off the axis; left and right are the faces where a sector meets its neighbours")
    both = np.intersect1d(*sides)
    if both.size:
        raise ValueError(f"node {labels[both[0]]} is in {names[0]!r} and in {names[1]!r} ({len(both)} such nodes); off the axis a node "
                         "is on one side only, take it out of the other set")


def _paired(structure, sides, names, sectors, axis, origin, tolerance):
    """Node rows (p,) left, and of its partners right, and the largest distance of partners."""
    points, labels = [structure.nodes[rows] for rows in sides], structure.labels
    wanted = 2 * np.pi / sectors
    distance, partner = _nearest(points[0], points[1], axis, origin, wanted)
    if len(points[0]) == len(points[1]) and np.all(distance <= tolerance):
        taken, counts = np.unique(partner, return_counts=True)
        if counts.max() > 1:
            raise ValueError(f"node {labels[sides[1][taken[counts.argmax()]]]} of {names[1]!r} is the partner of {counts.max()} nodes of "
                             f"{names[0]!r}; make the tolerance ({tolerance:.3g}) smaller than the distance between nodes")
        return sides[0], sides[1][partner], float(distance.max())
    _say_angle(points, names, sectors, axis, origin, tolerance)
    if len(points[0]) != len(points[1]):
        back = _nearest(points[1], points[0], axis, origin, -wanted)[0]
        side, far = (0, distance) if len(points[0]) > len(points[1]) else (1, back)
        raise ValueError(f"{names[0]!r} has {len(points[0])} nodes off the axis and {names[1]!r} has {len(points[1])}: every node needs a "
                         f"partner, and node {labels[sides[side][np.argmax(far)]]} of {names[side]!r} has none within {far.max():.3g}")
    worst, many = int(np.argmax(distance)), int(np.count_nonzero(distance > tolerance))
    raise ValueError(f"node {labels[sides[0][worst]]} of {names[0]!r}, turned by {_degrees(wanted)} degrees, lies {distance[worst]:.3g} "
                     f"from the nearest node of {names[1]!r}, {labels[sides[1][partner[worst]]]}, the largest distance of {many} above the "
                     f"tolerance ({tolerance:.3g}); both sides need the same mesh, or raise the tolerance")


def _nearest(points, others, axis, origin, angle):
    """Distance and row of the nearest of the `others` for each of the points, turned by an angle."""
    return tree(others).query(about(points, origin, turn(axis, angle)))


def _say_angle(points, names, sectors, axis, origin, tolerance):
    """ValueError where the sides do fit, but at another angle."""
    found, wanted = angle_between(points, axis, origin), 2 * np.pi / sectors
    if abs(found - wanted) <= WHOLE * wanted or np.any(_nearest(*points, axis, origin, found)[0] > tolerance):
        return
    if abs(found + wanted) <= WHOLE * wanted:
        raise ValueError(f"{names[1]!r} is {names[0]!r} turned by minus {_degrees(wanted)} degrees about the axis; exchange left and "
                         "right, or let the axis point the other way")
    turns = 2 * np.pi / abs(found) if found else 0.0
    meant = f"; sectors = {round(turns)}?" if turns >= 1.5 and abs(turns - round(turns)) <= WHOLE * turns else ""
    raise ValueError(f"{names[0]!r} and {names[1]!r} are {_degrees(found)} degrees apart, {sectors} sectors need {_degrees(wanted)}{meant}")


def angle_between(points, axis, origin):
    """Mean angle [rad] by which the second side is turned from the first; partners are those nearest in radius and height."""
    first = np.eye(3)[np.argmin(np.abs(axis))]
    first = first - (first @ axis) * axis
    first = first / np.linalg.norm(first)
    across = np.stack([first, np.cross(axis, first)])
    flat = [(side - origin) @ across.T for side in points]
    meridian = [np.column_stack([np.linalg.norm(xy, axis=1), (side - origin) @ axis]) for xy, side in zip(flat, points)]
    if not np.isfinite(np.concatenate(meridian)).all():
        raise ValueError(f"origin must be a point on the axis near the mesh, found {np.asarray(origin).tolist()}")
    partner = tree(meridian[1]).query(meridian[0])[1]
    angles = [np.arctan2(xy[:, 1], xy[:, 0]) for xy in flat]
    return float(np.angle(np.exp(1j * (angles[1][partner] - angles[0])).sum()))


def _degrees(angle):
    return f"{np.degrees(angle):.6g}"
