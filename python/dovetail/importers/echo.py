"""What a structure is loaded with, in words: totals of every load pattern and of the preload."""

import numpy as np

from ..loaded import is_zero

ROUNDING = 1e-12  # of the sum of sizes: a total below it is none


def resultant(structure, load):
    """Force (3,) and moment (3,) about the origin of a load (n,) of SciPy matrices, on nodes that have a place."""
    force, moment, sizes = np.zeros(3), np.zeros(3), np.zeros(2)
    node, direction = structure.dof_node, structure.dof_direction
    for axis in range(3):
        dofs = np.flatnonzero((node >= 0) & (direction == axis) & (load != 0))
        force[axis] += load[dofs].sum()
        arms = np.cross(structure.nodes[node[dofs]], np.eye(3)[axis])
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
