"""The sector of rotor.npz as a Structure, and the cyclic model of it, made as a user would."""

from pathlib import Path

import numpy as np
import scipy.sparse as sp

from dovetail import Joint, Structure, Surface

FOLDER = Path(__file__).with_name("data")
DATA, ANSWERS = np.load(FOLDER / "rotor.npz"), np.load(FOLDER / "rotor_linear.npz")
N = int(DATA["sector/N"])
CONTACT = {"root": {"normal_stiffness": 1e8, "tangential_stiffness": 5e7}, "shroud": {"normal_stiffness": 2e7, "tangential_stiffness": 1e7}}


def structure():
    """Free in space, with node sets of the names in rotor.npz."""
    K, M = (sp.csr_matrix(tuple(DATA[f"sector/{matrix}_{part}"] for part in ("data", "indices", "indptr"))) for matrix in "KM")
    nodes = DATA["sector/nodes"]
    sets = {name: DATA[f"sector/{name}"] for name in ("clamped", "left", "right", "root_a", "root_b", "shroud_a", "shroud_b")}
    return Structure(K, M, nodes, np.repeat(np.arange(len(nodes)), 3), np.tile([0, 1, 2], len(nodes)),
                     cells={"hexahedron": ANSWERS["hexahedra"]}, node_sets=sets)


def cyclic():
    """Clamped and matched."""
    return structure().clamped("clamped").cyclic(N, "left", "right", (0, 0, 1))


def joints(sector):
    """Root within the sector, shroud to the next one; one joint for every direction of the normal."""
    made = []
    for name, contact in CONTACT.items():
        a, b, axes = (DATA[f"sector/{name}_{part}"] for part in ("a", "b", "axes"))
        for normal in np.unique(axes[:, 2].round(9), axis=0):
            mine = np.abs(axes[:, 2] - normal).max(axis=1) < 1e-6
            sides = (Surface(sector.nodes[rows], sector.dofs_of(rows), name=name, labels=sector.labels[rows], cyclic=sector.cyclic_sector)
                     for rows in (a[mine], b[mine]))
            made.append(Joint.between(*sides, normal=axes[mine][0, 2], t1=axes[mine][0, 0], next_sector=name == "shroud",
                                      name=f"{name} {len(made)}").with_parameters(**contact))
    return made


def model():
    sector = cyclic()
    return sector.join(joints(sector))
