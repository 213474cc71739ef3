"""The joints under their preload, before anything shakes: which contact points are closed, and what they carry."""

from dataclasses import dataclass

import numpy as np

from .joint_plane import in_plane
from .nearest import tree
from .units import with_unit

NEIGHBOURS = 12  # of a contact point, that are looked at to tell whether it lies at an edge
REACH = 2.2  # neighbours lie within so many distances to the nearest
EDGE = np.radians(150.0)  # no wider angle is without neighbour around a point inside of a joint; at a straight edge it is 180 degrees


@dataclass(frozen=True)
class JointState:
    """A joint in the preload state.

    name : str
    points : (m,) numbers of its contact points, from 0
    closed : (m,) bool, those that carry a normal force
    edge : (m,) bool, those at the edge of the joint
    normal : (m,) normal forces, positive where pressed [N]; shear : (m, 2) along t1, t2 [N]
    area : (m,) [m^2], 0 where it is not known
    places : (m, 2) in the plane of the joint [m]
    """

    name: str
    points: np.ndarray
    closed: np.ndarray
    edge: np.ndarray
    normal: np.ndarray
    shear: np.ndarray
    area: np.ndarray
    places: np.ndarray

    @property
    def pressure(self):
        """(m,) [Pa], None where an area is not known."""
        return self.normal / self.area if np.all(self.area > 0) else None

    def in_words(self, unit):
        """Points closed, resultants in the axes of the points, pressure, points at the edge that carry nothing; in `Results.unit`."""
        shear = f"({', '.join(f'{_whole(total, self.normal):.4g}' for total in self.shear.sum(axis=0))})"
        words = [f"{np.count_nonzero(self.closed)} of {len(self.closed)} points closed",
                 f"normal force {with_unit(f'{self.normal.sum():.6g}', unit.force)}", f"shear {with_unit(shear, unit.force)}"]
        if self.pressure is not None and self.closed.any():
            mean = self.normal[self.closed].sum() / self.area[self.closed].sum()
            words.append(f"pressure {with_unit(f'{mean:.4g}', unit.stress)} in the mean, at most "
                         f"{with_unit(f'{self.pressure.max():.4g}', unit.stress)}")
        unloaded = np.count_nonzero(self.edge & ~self.closed)
        return ", ".join(words + [f"{unloaded} at the edge unloaded"] * bool(unloaded))


def joint_states(results, joint):
    """A JointState for each joint of `joint`, the places of the contact points of the model as in `Model`."""
    force = results.g.reshape(-1, 3)
    closed = force[:, 2] != 0
    found = []
    for number in np.unique(joint["joint"]):
        points = np.flatnonzero(joint["joint"] == number)
        places = in_plane(joint["position"][points], joint["axes"][points])
        found.append(JointState(joint["names"][number], points, closed[points], at_edge(places), force[points, 2], force[points, :2],
                                joint["area"][points], places))
    return found


def in_words(results):
    """Closed points and forces of all joints together, where the places of the points are not known."""
    force = results.g.reshape(-1, 3)
    return (f"{np.count_nonzero(force[:, 2])} of {len(force)} points closed, normal force "
            f"{with_unit(f'{force[:, 2].sum():.6g}', results.unit.force)}")


def at_edge(places):
    """(m,) bool: which of the places (m, 2) have a wide angle without neighbours."""
    count = min(NEIGHBOURS + 1, len(places))
    if count < 4:
        return np.ones(len(places), dtype=bool)
    distance, near = tree(places).query(places, k=count)
    edge = np.zeros(len(places), dtype=bool)
    for i, (lengths, others) in enumerate(zip(distance[:, 1:], near[:, 1:])):
        others = others[lengths <= REACH * lengths[0]]
        x, y = (places[others] - places[i]).T
        angle = np.sort(np.arctan2(y, x))
        edge[i] = np.diff(np.append(angle, angle[0] + 2 * np.pi)).max() > EDGE
    return edge


def _whole(total, normal):
    """Without what rounding leaves of forces that cancel."""
    return total if abs(total) > 1e-9 * np.abs(normal).sum() else 0.0
