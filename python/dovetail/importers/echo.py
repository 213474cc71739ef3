"""What loads and holds a structure, in words: totals of every load pattern and of the preload, bodies and their rigid motions."""

import numpy as np

from ..loaded import is_zero
from .bodies import bodies

MOST_BODIES = 8  # that are named
ROUNDING = 1e-12  # of the sum of sizes: a total below it is none


def resultant(structure, load, about=(0.0, 0.0, 0.0)):
    """Force (3,) and moment (3,) about a place of a load (n,) of SciPy matrices, on nodes that have a place."""
    force, moment, sizes = np.zeros(3), np.zeros(3), np.zeros(2)
    node, direction = structure.dof_node, structure.dof_direction
    for axis in range(3):
        dofs = np.flatnonzero((node >= 0) & (direction == axis) & (load != 0))
        force[axis] += load[dofs].sum()
        arms = np.cross(structure.nodes[node[dofs]] - about, np.eye(3)[axis])
        moment += arms.T @ load[dofs]
        sizes += np.abs(load[dofs]).sum(), np.abs(arms).max(initial=0) * np.abs(load[dofs]).sum()
        dofs = np.flatnonzero((node >= 0) & (direction == 3 + axis))
        moment[axis] += load[dofs].sum()
        sizes[1] += np.abs(load[dofs]).sum()
    return tuple(np.where(np.abs(total) > ROUNDING * size, total, 0.0) for total, size in zip((force, moment), sizes))


def loads(structure):
    """Lines about the loads of a structure with SciPy matrices, before it is joined."""
    patterns = {} if structure.forces and is_zero(structure.force) else {"force": structure.force}
    lines = [_line(structure, f"load pattern {name}", load) for name, load in {**patterns, **structure.forces}.items()]
    return [*lines, _line(structure, "preload", structure.preload)]


def _line(structure, what, load):
    if is_zero(load):
        return f"{what}: none"
    force, moment = resultant(structure, load)
    nodes = structure.dof_node[np.flatnonzero(load)]
    count = len(np.unique(nodes[nodes >= 0]))
    return f"{what}: total {_vector(force)} on {count} node{'s' * (count != 1)}, moment about the origin {_vector(moment)}"


def _vector(values):
    return f"({', '.join(f'{value:.6g}' for value in values + 0.0)})"


def supports(structure):
    """Lines about the bodies of a structure with SciPy matrices: how many rigid motions only joints hold, and how the preload pulls."""
    parts = bodies(structure)
    free = [body for body in parts if body.free.shape[1]]
    count = sum(body.free.shape[1] for body in free)
    first = f"{len(parts)} bod{'ies' if len(parts) > 1 else 'y'}"
    if not free:
        return [f"{first}, all held: no rigid motion is left to the joints"]
    lines = [f"{first}; rigid motions that only joints can hold: {count}"]
    for body in free[:MOST_BODIES]:
        name = f"the body of node {structure.labels[body.rows[0]]} ({len(body.rows)} nodes)"
        load = np.zeros(structure.n)
        load[body.dofs] = structure.preload[body.dofs]
        force, moment = resultant(structure, load, structure.nodes[body.rows].mean(axis=0))
        along = np.linalg.norm(body.free.T @ load[body.dofs]) > ROUNDING * np.abs(load).sum()
        pulled = f"preload on it {_vector(force)}, moment about its middle {_vector(moment)}" if along else "the preload does not move it"
        lines.append(f"  {body.free.shape[1]} of {name}; {pulled}")
    return lines + [f"  and {len(free) - MOST_BODIES} more bodies"] * (len(free) > MOST_BODIES)
