"""Contact points of one side of a joint: which nodes, their areas, axes and parameters."""

import numpy as np

from .nearest import tree

TIES = 8  # as many chosen points may be equally near to a node and share its area
FACING = -0.5  # largest cosine between the normals of two sides that touch


def choose(surface, at, name, rows=None, area=None):
    """Rows (m,) of the nodes that become contact points, and their areas (m,) [m^2] (zero on a surface without faces).

    `rows` and their `area`: those that may become some, default all nodes.
    """
    if rows is None:
        rows = np.arange(len(surface.points))
        area = surface.areas() if surface.faces else np.zeros(len(rows))
    points, labels = surface.points[rows], surface.labels[rows]
    if at is None:
        return rows, area
    at = np.asarray(at, dtype=np.float64)
    if at.ndim != 2 or at.shape[1] != 3 or not len(at) or not np.all(np.isfinite(at)):
        raise ValueError(f"joint {name!r}: `at` must be places of shape (k, 3), found shape {at.shape}")
    chosen = tree(points).query(at)[1]
    values, counts = np.unique(chosen, return_counts=True)
    if counts.max() > 1:
        raise ValueError(f"joint {name!r}: {counts.max()} places of `at` are nearest to the same node, "
                         f"{labels[values[counts.argmax()]]}; a contact point is one node")
    distance, nearest = tree(points[chosen]).query(points, k=min(len(chosen), TIES))
    distance, nearest = distance.reshape(len(area), -1), nearest.reshape(len(area), -1)
    equal = distance <= distance[:, :1] + 1e-9 * surface.size
    share = equal * (area / equal.sum(axis=1))[:, None]
    return rows[chosen], np.bincount(nearest.ravel(), weights=share.ravel(), minlength=len(chosen))


def normals_at(surface, normal, name):
    """Outward unit normals (m, 3) at all nodes: those of the faces, or one for all."""
    if normal is None:
        return surface.normals()
    normal = _unit_vector(normal, "normal", name)
    if surface.faces and np.any(surface.normals() @ normal < -FACING):
        worst = int(np.argmin(surface.normals() @ normal))
        raise ValueError(f"joint {name!r}: the normal given does not point out of {surface.name!r} at node {surface.labels[worst]}")
    return np.tile(normal, (len(surface.points), 1))


def refuse_facing_away(n, opposite, points, labels, name):
    """ValueError unless the normals of both sides (m, 3) look at each other."""
    cosine = np.einsum("mi,mi->m", n, opposite)
    worst = int(np.argmax(cosine))
    if cosine[worst] > FACING:
        raise ValueError(f"joint {name!r}: the two sides do not face each other at node {labels[worst]}, "
                         f"({', '.join(f'{v:.6g}' for v in points[worst])}): the angle between the outward normals is "
                         f"{np.degrees(np.arccos(min(cosine[worst], 1))):.0f} degrees, about 180 is wanted")


def axes_at(n, t1, points, name):
    """Rows t1, t2, n (m, 3, 3) at every point; t1 is projected into the tangent plane, t2 = n x t1."""
    given = t1 is not None
    t1 = _unit_vector(t1, "t1", name) if given else np.eye(3)[np.abs(n).max(axis=0).round(9).argmin()]
    first = t1 - (n @ t1)[:, None] * n
    length = np.linalg.norm(first, axis=1)
    worst = int(np.argmin(length))
    if length[worst] < 1e-3:
        place = ", ".join(f"{v:.6g}" for v in points[worst])
        raise ValueError(f"joint {name!r}: t1 {'is' if given else 'would be'} parallel to the normal at ({place}); give another t1")
    first /= length[:, None]
    axes = np.stack([first, np.cross(n, first), n], axis=1)
    axes[np.abs(axes) < 1e-14] = 0.0  # round-off that would fill the matrices
    return axes


def per_area(value, area, width, key, name):
    """Stiffness of each point [N/m], (m,) or (m, 2), from one per area [N/m^3]; None stays None."""
    if value is None:
        return None
    value = _numbers(value, width, key, name)
    if value.min() <= 0:
        raise ValueError(f"joint {name!r}: {key} must be positive, found {value.min():g}")
    if np.any(area <= 0):
        raise ValueError(f"joint {name!r}: {key} is per area, and {np.count_nonzero(area <= 0)} of {len(area)} contact points have none; "
                         "give the surface faces, or set the stiffness of each point in the case file")
    return area * value if width == 1 else area[:, None] * value


def per_point(value, m, key, name):
    """(m, 2) from a number or [t1, t2]; None stays None."""
    if value is None:
        return None
    value = _numbers(value, 2, key, name)
    if value.min() < 0:
        raise ValueError(f"joint {name!r}: {key} must not be negative, found {value.min():g}")
    return np.tile(value, (m, 1))


def gaps(gap, distance, name):
    """(m,) [m] from None, a number, one per point, or "geometry"."""
    if isinstance(gap, str):
        if gap != "geometry":
            raise ValueError(f"joint {name!r}: gap must be a number, one per point, or \"geometry\", found {gap!r}")
        return distance
    gap = np.asarray(0.0 if gap is None else gap, dtype=np.float64)
    if gap.shape not in ((), distance.shape) or not np.all(np.isfinite(gap)):
        raise ValueError(f"joint {name!r}: gap must be a finite number or one per contact point ({len(distance)}), found shape {gap.shape}")
    return np.broadcast_to(gap, distance.shape).copy()


def need_free_or_clamped(joint):
    """A contact point needs all three directions; a node may also be held in all three, as the ground is."""
    sides = [(joint.dofs, joint.labels)]
    if joint.kind == "pairs":
        sides.append((joint.other, joint.partner_labels))
    held = [(dofs < 0).sum(axis=1) for dofs, _ in sides]
    for count, (_, labels) in zip(held, sides):
        partly = np.flatnonzero((count > 0) & (count < 3))
        if partly.size:
            raise ValueError(f"joint {joint.name!r}: node {labels[partly[0]]} is clamped in {count[partly[0]]} of 3 directions "
                             f"({partly.size} such nodes); take them out of the joint's set or out of the clamp")
    fixed = np.flatnonzero(np.min(held, axis=0) == 3)
    if fixed.size:
        partner = ", nor can its partner" if joint.kind == "pairs" else ""
        advice = ", or name the other side first" if joint.kind == "faces" else ""
        raise ValueError(f"joint {joint.name!r}: node {joint.labels[fixed[0]]} cannot move{partner} ({fixed.size} such contact points); "
                         f"take them out of the joint's set or out of the clamp{advice}")


def _numbers(value, width, key, name):
    array = np.asarray(value, dtype=np.float64)
    if array.shape not in (((),) if width == 1 else ((), (2,))) or not np.all(np.isfinite(array)):
        wanted = "a number" if width == 1 else "a number or [t1, t2]"
        raise ValueError(f"joint {name!r}: {key} must be {wanted}, found {value!r}")
    return np.broadcast_to(array, (width,)).copy() if width == 2 else array


def _unit_vector(vector, key, name):
    vector = np.asarray(vector, dtype=np.float64)
    if vector.shape != (3,) or not np.all(np.isfinite(vector)) or not np.linalg.norm(vector) > 0:
        raise ValueError(f"joint {name!r}: {key} must be a vector of three numbers, not all zero, found {vector.tolist()}")
    return vector / np.linalg.norm(vector)
