"""The parts of a model file the solver passes over: the mesh, and where the contact points are. For pictures and full motion."""

import h5py
import numpy as np

from . import material
from .hdf5_read import attribute, numbers, text

MESH = ("nodes", "cells", "dof_node", "dof_direction")
OPTIONAL = ("sets", "changed", "materials", "material", "integration")
CHANGED = ("dof", "begin", "column", "value")
MOST_NAMES = 64000  # bytes of all joint names, padded to the longest: an attribute of HDF5 has at most 64 KiB
JOINT = {"position": (3,), "axes": (3, 3), "area": (), "joint": ()}  # shape per contact point


def checked_mesh(mesh, n):
    """The `mesh` of Model for n dofs, as arrays; what is optional is always there, empty if not given."""
    if not set(MESH) <= set(mesh) <= {*MESH, *OPTIONAL}:
        raise ValueError(f"mesh must have {', '.join(MESH)} and may have {', '.join(OPTIONAL)}; found {', '.join(sorted(mesh))}")
    nodes = np.asarray(mesh["nodes"], dtype=np.float64)
    if nodes.shape[1:] != (3,):
        raise ValueError(f"mesh nodes must have shape (n_nodes, 3), found {nodes.shape}")
    if not isinstance(mesh["cells"], dict):
        raise ValueError("mesh cells must be a dict of cell type to node rows, such as {'tetra': rows}, found "
                         f"{type(mesh['cells']).__name__}")
    cells = {str(kind): np.asarray(rows, dtype=np.int64) for kind, rows in mesh["cells"].items()}
    for kind, rows in cells.items():
        if rows.ndim != 2 or (rows.size and not 0 <= rows.min() <= rows.max() < len(nodes)):
            raise ValueError(f"mesh cells {kind!r} must be (n_cells, nodes per cell) numbers of nodes, 0 to {len(nodes) - 1}")
    sets = {str(name): np.asarray(rows, dtype=np.int64).reshape(-1) for name, rows in mesh.get("sets", {}).items()}
    for name, rows in sets.items():
        if rows.size and not 0 <= rows.min() <= rows.max() < len(nodes):
            raise ValueError(f"mesh set {name!r} must hold numbers of nodes, 0 to {len(nodes) - 1}")
    dof_node, dof_direction = (np.asarray(mesh[key], dtype=np.int64) for key in ("dof_node", "dof_direction"))
    for name, values, top in (("dof_node", dof_node, len(nodes)), ("dof_direction", dof_direction, 6)):
        if values.shape != (n,) or values.min() < -1 or values.max() >= top:
            raise ValueError(f"mesh {name} must have shape ({n},) and values from -1 to {top - 1}, found shape {values.shape}")
    return {"nodes": nodes, "cells": cells, "dof_node": dof_node, "dof_direction": dof_direction, "sets": sets,
            "changed": _checked_changed(mesh.get("changed"), n), **material.checked(mesh, cells)}


def _checked_changed(changed, n):
    if changed is None:
        changed = {"dof": [], "begin": [0], "column": [], "value": []}
    if set(changed) != set(CHANGED):
        raise ValueError(f"mesh changed must have {', '.join(CHANGED)}, found {', '.join(sorted(changed))}")
    changed = {key: np.asarray(changed[key], dtype=np.float64 if key == "value" else np.int64) for key in CHANGED}
    dof, begin, column = (changed[key] for key in ("dof", "begin", "column"))
    fits = begin.shape == (dof.size + 1,) and begin[0] == 0 and begin[-1] == column.size == changed["value"].size
    if not fits or np.any(np.diff(begin) < 0) or not all(np.all((v >= 0) & (v < n)) for v in (dof, column)):
        raise ValueError(f"mesh changed must give, for each of its dofs, columns 0 to {n - 1} and values between begin[i] and begin[i + 1]")
    return changed


def checked_joint(joint, n_points):
    """The `joint` of Model for n_points contact points, as arrays."""
    if set(joint) != {*JOINT, "names"}:
        raise ValueError(f"joint must have {', '.join(JOINT)}, names, found {', '.join(sorted(joint))}")
    checked = {key: np.asarray(joint[key], dtype=np.int64 if key == "joint" else np.float64) for key in JOINT}
    for key, shape in JOINT.items():
        if checked[key].shape != (n_points, *shape):
            raise ValueError(f"joint {key} must have shape {(n_points, *shape)}, found {checked[key].shape}")
    names = [str(name) for name in joint["names"]]
    longest = max(names, key=lambda name: len(name.encode()), default="")
    size = len(longest.encode())
    if len(names) * size > MOST_NAMES:
        raise ValueError(f"{len(names)} joint names, the longest of {size} bytes, are more than a model file holds: number times longest "
                         f"is at most {MOST_NAMES}; shorten {longest[:40]!r}")
    if checked["joint"].min() < 0 or checked["joint"].max() >= len(names):
        raise ValueError(f"joint numbers must lie in 0 to {len(names) - 1}, as there are {len(names)} names")
    return {**checked, "names": names}


def datasets(mesh, joint):
    """Name in the file to array, of all that Model was given."""
    found = {}
    if mesh:
        found = {f"mesh/{key}": mesh[key] for key in ("nodes", "dof_node", "dof_direction")}
        found |= {f"mesh/cells/{kind}": rows for kind, rows in mesh["cells"].items()}
        found |= {f"mesh/sets/{name}": rows for name, rows in mesh["sets"].items()}
        if mesh["materials"]:
            found["mesh/materials"] = np.array([(one.young, one.poisson, one.density) for one in mesh["materials"]])
            found |= {f"mesh/material/{kind}": numbers for kind, numbers in mesh["material"].items()}
            found |= {f"mesh/integration/{kind}": numbers for kind, numbers in mesh["integration"].items() if numbers.any()}
        if mesh["changed"]["dof"].size:
            found |= {f"mesh/changed/{key}": values for key, values in mesh["changed"].items()}
    if joint:
        found |= {f"contact/{key}": joint[key] for key in JOINT}
    return found


def attributes(mesh, joint):
    """Name of a group to its attributes."""
    found = {}
    if joint:
        found["contact"] = {"joints": np.array([name.encode() for name in joint["names"]])}
    if mesh and mesh["materials"]:
        found["mesh"] = {"materials": np.array([one.name.encode() for one in mesh["materials"]])}
    return found


def read_mesh(file):
    """The `mesh` of Model from an open model file, checked, or None."""
    if "mesh" not in file:
        return None
    mesh = {"nodes": numbers(file, "mesh/nodes", (None, 3))}
    mesh |= {key: numbers(file, f"mesh/{key}", (None,), "i") for key in ("dof_node", "dof_direction")}
    for key, axes in (("cells", 2), ("sets", 1), ("material", 1), ("integration", 1)):
        names = []
        if isinstance(file.get(f"mesh/{key}"), h5py.Group):  # names may hold a slash, which makes groups within groups
            file[f"mesh/{key}"].visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        mesh[key] = {text(name): numbers(file, f"mesh/{key}/{name}", (None,) * axes, "i") for name in names}
    if "materials" in file["mesh"]:
        values = numbers(file, "mesh/materials", (None, 3))
        names = [text(name) for name in np.ravel(attribute(file["mesh"], "materials", []))]
        if len(names) != len(values):
            raise ValueError(f"/mesh/materials: wanted {len(values)} names in the attribute materials of /mesh, found {len(names)}")
        mesh["materials"] = [material.Material(*row, name) for row, name in zip(values.tolist(), names)]
    if "changed" in file["mesh"]:
        mesh["changed"] = {key: numbers(file, f"mesh/changed/{key}", (None,), "f" if key == "value" else "i") for key in CHANGED}
    return checked_mesh(mesh, len(mesh["dof_node"]))


def read_joint(file):
    """The `joint` of Model from an open model file, checked, or None."""
    if "contact/position" not in file:
        return None
    joint = {key: numbers(file, f"contact/{key}", (None, *shape), "i" if key == "joint" else "f") for key, shape in JOINT.items()}
    names = [text(name) for name in np.ravel(attribute(file["contact"], "joints", []))]
    return checked_joint({**joint, "names": names}, len(joint["position"]))
