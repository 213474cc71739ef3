"""The parts of a model file that make it one of N equal sectors."""

import numpy as np

from .hdf5_read import attribute, numbers, whole

KEYS = ("sectors", "axis", "origin", "left", "right", "next_sector", "nodes", "faces")
FACES = ("begin", "node", "weight")


def checked_cyclic(cyclic, n, mesh, joint):
    """The `cyclic` of Model for n dofs, as arrays; `faces` always there."""
    if mesh is None or joint is None:
        raise ValueError("a cyclic model needs mesh and joint, which say where its nodes are and how its contact points look")
    if not set(KEYS) - {"faces"} <= set(cyclic) <= set(KEYS):
        raise ValueError(f"cyclic must have {', '.join(KEYS[:-1])} and may have faces; found {', '.join(sorted(cyclic))}")
    sectors = np.asarray(cyclic["sectors"])
    if sectors.shape != () or sectors.dtype.kind not in "iuf" or sectors < 2 or not float(sectors).is_integer():
        raise ValueError(f"cyclic sectors must be a whole number from 2 on, found {cyclic['sectors']!r}")
    if mesh["changed"]["dof"].size:
        raise ValueError("a cyclic model is that of the sector before joints change its unknowns, found mesh changed")
    axis, origin = (np.asarray(cyclic[key], dtype=np.float64) for key in ("axis", "origin"))
    if axis.shape != (3,) or origin.shape != (3,) or not np.isfinite([axis, origin]).all() or abs(np.linalg.norm(axis) - 1) > 1e-12:
        raise ValueError(f"cyclic axis must be a unit vector (3,) and origin a point (3,), found {axis.tolist()} and {origin.tolist()}")
    left, right, next_sector, nodes = (np.asarray(cyclic[key], dtype=np.int64) for key in ("left", "right", "next_sector", "nodes"))
    if left.shape[1:] != (3,) or left.shape != right.shape or np.any((left < 0) != (right < 0)):
        raise ValueError(f"cyclic left and right must be dofs of shape (p, 3), held on both sides alike, found shapes {left.shape} and "
                         f"{right.shape}")
    used = np.concatenate([left[left >= 0], right[right >= 0]])
    if used.size and (used.max() >= n or len(np.unique(used)) < used.size):
        raise ValueError(f"cyclic left and right must be dofs 0 to {n - 1}, each once")
    points, count = len(nodes), len(mesh["nodes"])
    if nodes.shape != (points, 2) or not points or nodes.min() < -1 or nodes.max() >= count or np.any(nodes.max(axis=1) < 0):
        raise ValueError(f"cyclic nodes must be (N_x, 2) node rows up to {count - 1}, -1 for a side that is held, found shape "
                         f"{nodes.shape}")
    row, times = np.unique(nodes[nodes >= 0], return_counts=True)
    if times.max() > 1:
        raise ValueError(f"cyclic nodes must name each contact node once, found node row {row[times.argmax()]} {times.max()} times")
    if next_sector.shape != (points,) or not np.isin(next_sector, (0, 1)).all():
        raise ValueError(f"cyclic next_sector must be 0 or 1 for each of {points} contact points, found shape {next_sector.shape}")
    return {"sectors": int(sectors), "axis": axis, "origin": origin, "left": left, "right": right, "next_sector": next_sector,
            "nodes": nodes, "faces": _checked_faces(cyclic.get("faces"), points, count)}


def _checked_faces(faces, points, count):
    if faces is None:
        faces = {"begin": np.zeros(points + 1), "node": [], "weight": []}
    if set(faces) != set(FACES):
        raise ValueError(f"cyclic faces must have {', '.join(FACES)}, found {', '.join(sorted(faces))}")
    faces = {key: np.asarray(faces[key], dtype=np.float64 if key == "weight" else np.int64) for key in FACES}
    begin, node = faces["begin"], faces["node"]
    fits = begin.shape == (points + 1,) and begin[0] == 0 and begin[-1] == node.size == faces["weight"].size
    if not fits or np.any(np.diff(begin) < 0) or node.size and not 0 <= node.min() <= node.max() < count:
        raise ValueError(f"cyclic faces must give, for each of {points} contact points, node rows 0 to {count - 1} and weights between "
                         "begin[i] and begin[i + 1]")
    return faces


def datasets(cyclic):
    """Name in the file to array."""
    found = {f"cyclic/{key}": cyclic[key] for key in ("left", "right", "next_sector")} | {"contact/nodes": cyclic["nodes"]}
    if cyclic["faces"]["node"].size:
        found |= {f"contact/faces/{key}": values for key, values in cyclic["faces"].items()}
    return found


def attributes(cyclic):
    """Attributes of the group `cyclic`."""
    return {"sectors": np.int64(cyclic["sectors"]), "axis": cyclic["axis"], "origin": cyclic["origin"]}


def read_cyclic(file):
    """The `cyclic` of Model from an open model file, or None."""
    if "cyclic" not in file:
        return None
    group = file["cyclic"]
    cyclic = {"sectors": whole(group, "sectors")}
    for key in ("axis", "origin"):
        values = np.asarray(attribute(group, key, "nothing"))
        if values.shape != (3,) or values.dtype.kind not in "iuf":
            raise ValueError(f"/cyclic: attribute {key} must be three numbers, found {str(values)[:40]}")
        cyclic[key] = values
    for key, shape in (("left", (None, 3)), ("right", (None, 3)), ("next_sector", (None,))):
        cyclic[key] = numbers(file, f"cyclic/{key}", shape, "i")
    cyclic["nodes"] = numbers(file, "contact/nodes", (None, 2), "i")
    if "contact/faces" in file:
        cyclic["faces"] = {key: numbers(file, f"contact/faces/{key}", (None,), "f" if key == "weight" else "i") for key in FACES}
    return cyclic
