"""Forces of supports, from the stress of the cells around held nodes."""

import numpy as np

from . import fourier, solids
from .material import UNKNOWN
from .nodal_stress import stressed_mesh
from .strains import cell_forces


def reactions(results, point, names, model=None, material=None):
    """Forces that the supports exert on the part in the held directions of node sets.

    Parameters
    ----------
    results : Results
    point : int
    names : list of str
        Node sets with held nodes.
    model, material
        As of `nodal_stress`.

    Returns
    -------
    dict of name to (mean (3,), amplitude (3,)) [N]
        Without the inertia of the mass that belongs to the held nodes, and without damping, as the model does not keep their rows.
    """
    mesh, U = stressed_mesh(results, point, model, material)
    return {name: _total(mesh, U, name) for name in names}


def _total(mesh, U, name):
    if name not in mesh["sets"]:
        raise ValueError(f"there is no node set {name!r}; there are {', '.join(sorted(mesh['sets'])) or 'none'}")
    force = held_forces(mesh, U, mesh["sets"][name])
    if force is None:
        raise ValueError(f"no node of {name!r} is held, so there is no reaction")
    series = force.sum(axis=1)  # (2H+1, 3)
    return series[0] / 2, fourier.amplitude(series.T)


def held_forces(mesh, U, nodes):
    """(c, k, 3) forces of the supports on some nodes under c fields of displacements, zero in free directions; None if none is held.

    mesh : as in `Model`, checked; U : (c, n_nodes, 3); nodes : (k,) rows, each once
    """
    held = np.ones((len(mesh["nodes"]), 3), dtype=bool)
    own = (mesh["dof_node"] >= 0) & (mesh["dof_direction"] >= 0) & (mesh["dof_direction"] < 3)
    held[mesh["dof_node"][own], mesh["dof_direction"][own]] = False
    place = np.full(len(held), -1)
    place[nodes] = np.arange(len(nodes))
    if not held[nodes].any():
        return None
    total = np.zeros((len(U), len(nodes), 3))
    for kind, rows in mesh["cells"].items():
        beside = (place[rows] >= 0).any(axis=1)
        number = mesh["material"][kind]
        if beside.any() and (kind not in solids.SHAPE or (number[beside] == UNKNOWN).any()):
            raise ValueError(f"a {kind} cell beside held nodes has no stress, so that reactions are not known")
        for how in np.unique(mesh["integration"][kind]):
            mine = np.flatnonzero(beside & (mesh["integration"][kind] == how))
            if not mine.size:
                continue
            young, poisson = (np.array([getattr(one, name) for one in mesh["materials"]])[number[mine]] for name in ("young", "poisson"))
            force = cell_forces(kind, int(how), mesh["nodes"][rows[mine]], U[:, rows[mine]], young, poisson)
            at = place[rows[mine]]
            for field, of_cells in zip(total, force):
                np.add.at(field, at[at >= 0], of_cells[at >= 0])
    return total * held[nodes]
