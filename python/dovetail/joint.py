"""Two surfaces that touch, or one that touches the ground: contact points, their axes, areas, gaps and parameters.

Relative displacements, u_a those of a contact point on side a and r = (t1, t2, n) its contact dofs, with Q = [t1 t2 n]:

    pair of nodes       u_a = (s + Q r) / 2,  u_b = (s - Q r) / 2       s takes the dofs of b, r those of a
    node on a face      u_a = Q r + sum_j N_j u_bj                      N the shape functions at the foot of the point
    node and ground     u_a = Q r

n is the outward normal of side a, so that positive relative displacement closes the joint.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from .contact_points import (axes_at, choose, gaps, need_free_or_clamped, normals_at, per_area, per_point, refuse_facing_away)
from .matching import partners
from .overlap import over
from .parameters import contact_parameters
from .projection import project
from .units import parse


@dataclass(frozen=True)
class Joint:
    """Contact points and what they do; made by `Joint.between` or `Joint.ground`.

    Attributes
    ----------
    name : str
    kind : "pairs", "faces" or "ground"
    position : (m, 3) [m]; axes : (m, 3, 3) rows t1, t2, n; area : (m,) [m^2]
    dofs : (m, 3) int, x, y, z dofs of the contact points on side a
    labels, partner_labels : (m,) int, node numbers for messages; partners for pairs only
    point : (e,) int, other : (e, 3) int, weight : (e,)
        Side b, entry by entry: contact point, dofs of a node of b, its part. One entry of weight 1 per pair, none for the ground.
    contact : dict
        `normal_stiffness` (m,) [N/m], `tangential_stiffness` (m, 2) [N/m], `friction` (m, 2), `gap` (m,) [m], as far as given.
    mismatch : (m,) [m]
        Distance of partners; for faces, how far the point lies beyond the edge of side b.
    distance : (m,) [m]
        From a to b along n, positive when open; zero for the ground.
    left_out : int
        Nodes of side a that do not lie over side b or cannot move, where `overlap` leaves them out.
    next_sector : bool
        Whether b is a surface of the next sector of a cyclic structure; its dofs are those of this sector.
    """

    name: str
    kind: str
    position: np.ndarray
    axes: np.ndarray
    area: np.ndarray
    dofs: np.ndarray
    labels: np.ndarray
    partner_labels: np.ndarray
    point: np.ndarray
    other: np.ndarray
    weight: np.ndarray
    contact: dict
    mismatch: np.ndarray
    distance: np.ndarray
    left_out: int = 0
    next_sector: bool = False

    def __len__(self):
        return len(self.position)

    @classmethod
    def between(cls, a, b, *, normal_stiffness=None, tangential_stiffness=None, friction=None, gap=None, tolerance=None, t1=None,
                at=None, normal=None, name=None, overlap=False, next_sector=False):
        """The joint of two surfaces.

        Parameters
        ----------
        a, b : Surface
            Contact points are nodes of a. If each has a node of b at the same place they are paired, else they stand on b's faces.
        normal_stiffness : float, optional
            Per area [N/m^3]; times the tributary area of a contact point it is k_n [N/m].
        tangential_stiffness : float or [t1, t2], optional
            Per area [N/m^3].
        friction : float or [t1, t2], optional
        gap : float, (m,) array or "geometry", optional
            Displacement at which a point touches [m], default 0; "geometry": the distance from a to b along n, positive when open.
        tolerance : float, optional
            How far apart partners may lie, and how far a contact point may lie beyond the edge of b [m]. Default: 1e-6 of the
            size of a, and 5 % of the radius of a face.
        t1 : (3,) array, optional
            First tangential direction, projected into the tangent plane; default the axis least aligned with the normals. t2 = n x t1.
        at : (k, 3) array, optional
            Only the nodes of a nearest to these places [m] become contact points. The area of the rest goes to the nearest of
            them, in equal shares where several are equally near.
        normal : (3,) array, optional
            Outward normal of a at every point, instead of that of the faces.
        name : str, optional
            Default the names of the surfaces.
        overlap : bool
            Only nodes of a that lie over b, and can move or face one that can, become contact points, with the area that lies over
            b. Else another node is refused.
        next_sector : bool
            b belongs to the next sector of a cyclic structure: it is turned by one sector before anything else.

        Raises
        ------
        ValueError
            When sides do not face each other, a point of a lies off b, a contact point is clamped in some directions only, or an
            argument is out of range.
        """
        name = name or f"{a.name} - {b.name}"
        b = b.in_next_sector() if next_sector else b
        n = normals_at(a, normal, name)
        rows, area = over(a, b, n, tolerance, name) if overlap else (None, None)
        left_out = len(a.points) - len(rows) if overlap else 0
        chosen, area = choose(a, at, name, rows, area)
        points, n = a.points[chosen], n[chosen]
        partner = partners(points, b, 1e-6 * a.size if tolerance is None else tolerance, name)
        if partner is None:
            if not b.faces:
                raise ValueError(f"joint {name!r}: not every contact point has a partner among the nodes of {b.name!r}, which has no "
                                 "faces to project on; give faces, or a larger tolerance")
            kind, feet = "faces", project(points, b)
            allowed = feet.allowed if tolerance is None else np.full(len(points), tolerance)
            worst = int(np.argmax(feet.overhang - allowed))
            if feet.overhang[worst] > allowed[worst]:
                raise ValueError(f"joint {name!r}: node {a.labels[chosen[worst]]} of {a.name!r} at {_place(points[worst])} lies "
                                 f"{feet.overhang[worst]:.3g} beyond the faces of {b.name!r}; say overlap = true to leave out "
                                 f"such nodes ({np.count_nonzero(feet.overhang > allowed)} of {len(points)}), or raise the tolerance "
                                 f"({allowed[worst]:.3g})")
            place, opposite, mismatch = feet.place, feet.normal, feet.overhang
            point, other, weight = feet.point, b.dofs[feet.node], feet.weight
            partner_labels = None
        else:
            kind, place, opposite = "pairs", b.points[partner], b.normals()[partner] if b.faces else -n
            point, other, weight = np.arange(len(points)), b.dofs[partner], np.ones(len(points))
            mismatch, partner_labels = np.linalg.norm(place - points, axis=1), b.labels[partner]
        refuse_facing_away(n, opposite, points, a.labels[chosen], name)
        distance = np.einsum("mi,mi->m", place - points, n)
        return cls._make(a, chosen, area, n, t1, name, kind=kind, partner_labels=partner_labels, point=point, other=other, weight=weight,
                         mismatch=mismatch, distance=distance, parameters=(normal_stiffness, tangential_stiffness, friction),
                         gap=gaps(gap, distance, name), left_out=left_out, next_sector=bool(next_sector))

    @classmethod
    def ground(cls, a, *, normal_stiffness=None, tangential_stiffness=None, friction=None, gap=None, t1=None, at=None, normal=None,
               name=None):
        """The joint of a surface with a rigid, fixed one; parameters as in `between`."""
        name = name or f"{a.name} - ground"
        if isinstance(gap, str):
            raise ValueError(f"joint {name!r}: the ground has no geometry; gap must be a number or one per point, found {gap!r}")
        chosen, area = choose(a, at, name)
        none = np.zeros(len(chosen))
        return cls._make(a, chosen, area, normals_at(a, normal, name)[chosen], t1, name, kind="ground", partner_labels=None,
                         point=np.empty(0, dtype=np.int64), other=np.empty((0, 3), dtype=np.int64), weight=np.empty(0),
                         mismatch=none, distance=none, parameters=(normal_stiffness, tangential_stiffness, friction),
                         gap=gaps(gap, none, name))

    @classmethod
    def _make(cls, a, chosen, area, n, t1, name, *, parameters, gap, **rest):
        normal_stiffness, tangential_stiffness, friction = parameters
        contact = {"normal_stiffness": per_area(normal_stiffness, area, 1, "normal_stiffness", name),
                   "tangential_stiffness": per_area(tangential_stiffness, area, 2, "tangential_stiffness", name),
                   "friction": per_point(friction, len(area), "friction", name), "gap": gap}
        joint = cls(name=name, position=a.points[chosen], axes=axes_at(n, t1, a.points[chosen], name), area=area, dofs=a.dofs[chosen],
                    labels=a.labels[chosen], contact={key: value for key, value in contact.items() if value is not None}, **rest)
        need_free_or_clamped(joint)
        return joint

    @property
    def contact_dofs(self) -> np.ndarray:
        """(m, 3) numbers of t1, t2, n: the place of u_a, or of u_b where a itself is clamped."""
        if self.kind != "pairs":
            return self.dofs
        return np.where(self.dofs < 0, self.other, self.dofs)

    def with_parameters(self, **contact: ArrayLike) -> "Joint":
        """With other parameters, given as for `Model`: any of `normal_stiffness`, `tangential_stiffness` [N/m], `friction`, `gap` [m],
        a number or one per contact point (for tangential ones [t1, t2] as well)."""
        return replace(self, contact={**self.contact, **contact_parameters(contact, len(self))})

    def report(self, units: str = "SI") -> str:
        """What the joint is, in a few lines: points, area, worst mismatch, spread of the normals, distance and gap.

        `units` are those of the model.
        """
        unit = parse(units)
        m, m2, per_m = (f" {name}" if name else "" for name in (unit.length, unit.length and f"{unit.length}^2", unit.stiffness))
        n = self.axes[:, 2]
        mean = n.mean(axis=0)
        mean = (mean / max(np.linalg.norm(mean), np.finfo(float).tiny)).round(6) + 0.0
        spread = np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(n - mean, axis=1).max() / 2, 0, 1))).round(4)
        least = 1e-9 * np.ptp(self.position, axis=0).max(initial=0.0)  # distances below are round-off
        mismatch, distance = (np.where(np.abs(values) > least, values, 0.0) for values in (self.mismatch, self.distance))
        how = {"pairs": "pairs of matching nodes", "faces": "nodes on faces", "ground": "nodes on the ground"}[self.kind]
        first = f"joint {self.name}: {len(self)} contact points, {how}" + (", to the next sector" if self.next_sector else "")
        if self.left_out:
            first += f"; {self.left_out} more nodes do not lie over the other side, or cannot move, and are left out"
        lines = [first, f"  area       {self.area.sum():.6g}{m2}"]
        if self.kind != "ground":
            worst = int(np.argmax(mismatch))
            what = "between partners" if self.kind == "pairs" else "beyond the edge"
            where = f"at most {mismatch[worst]:.3g}{m} {what}, at node {self.labels[worst]}" if mismatch[worst] else "none"
            lines += [f"  mismatch   {where}", f"  distance   {_range(distance)}{m} along the normal"]
        lines.append(f"  normals    within {spread:.3g} degrees of ({', '.join(f'{v:.3g}' for v in mean)})")
        for key, label, unit in (("gap", "gap", m), ("normal_stiffness", "k_n", f"{per_m} per point"),
                                 ("tangential_stiffness", "k_t", f"{per_m} per point"), ("friction", "friction", "")):
            if key in self.contact:
                lines.append(f"  {label:<9}  {_range(self.contact[key])}{unit}")
        return "\n".join(lines)


def _range(values):
    low, high = np.min(values), np.max(values)
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"


def _place(point):
    return f"({', '.join(f'{v:.6g}' for v in point)})"
