"""A sector of a thick ring of bricks for the tests: joined to its neighbours below, in contact with them above."""

import brick
import numpy as np
import scipy.sparse as sp

from dovetail import Structure

N = 5
COUNTS = 4, 2, 2  # along radius, circumference and axis
JOINED = 2.0  # up to this radius
MATERIAL = {"young": 100.0, "poisson": 0.3, "density": 1.0}


def cylinder(points):
    r, angle, z = points.T
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), z])


def sector(angle=2 * np.pi / N, shift=0.0, mapping=lambda points: points, counts=COUNTS):
    """Radius 1 to 3, height 1, from x towards y.

    shift: how far the contact nodes of the right side lie from partners, along the axis. Node sets "left", "right" (r <= JOINED), "bore",
    "over_left", "over_right" (r > JOINED), "right_face" (all of it). Nodes are numbered from 101.
    """
    plain, cells = brick.grid((1, 0, 0), (2, 1, 1), counts)
    r, along, z = plain.T
    places = np.column_stack([r, angle * along, z + shift * (r > JOINED) * along * z * (1 - z)])
    nodes = mapping(cylinder(places))
    low, first, last = r <= JOINED + 1e-9, along < 1e-9, along > 1 - 1e-9
    sets = {"left": low & first, "right": low & last, "bore": r < 1 + 1e-9, "over_left": ~low & first, "over_right": ~low & last,
            "right_face": last}
    K, M = brick.matrices(nodes, cells, **MATERIAL)
    n = len(nodes)
    return Structure(K, M, nodes, np.repeat(np.arange(n), 3), np.tile([0, 1, 2], n), labels=101 + np.arange(n), cells={"hexahedron": cells},
                     node_sets={name: np.flatnonzero(inside) for name, inside in sets.items()})


def whole(**more):
    """The ring of N such sectors, assembled: node sets "over_left_0", "over_right_0" and so on, "bore" of all of it."""
    one = sector(**more)
    left, right = one.node_sets["left"], one.node_sets["right"]
    count, turn = len(one.nodes), brick.turned((0, 0, 1), 2 * np.pi / N)
    parts = [one.nodes]
    for _ in range(N - 1):
        parts.append(turn(parts[-1]))
    nodes, row = np.concatenate(parts), np.arange(N * count).reshape(N, count)
    partner = [left[np.argmin(np.linalg.norm(turn(one.nodes[left]) - one.nodes[node], axis=1))] for node in right]
    row[:, right] = np.roll(row, -1, axis=0)[:, partner]
    kept, number = np.unique(row, return_inverse=True)
    number = number.reshape(N, count)
    cells = np.concatenate([places[one.cells["hexahedron"]] for places in number])
    nodes, n = nodes[kept], len(kept)
    sets = {f"{name}_{j}": number[j, one.node_sets[name]] for j in range(N) for name in ("over_left", "over_right")}
    sets["bore"] = np.unique(number[:, one.node_sets["bore"]])
    K, M = brick.matrices(nodes, cells, **MATERIAL)
    return Structure(K, M, nodes, np.repeat(np.arange(n), 3), np.tile([0, 1, 2], n), cells={"hexahedron": cells}, node_sets=sets)


def with_rotations(structure, rows):
    """The structure with three rotations of some nodes more, on springs of their own."""
    K, M = (sp.block_diag([matrix, sp.identity(3 * len(rows))], format="csr") for matrix in (structure.K, structure.M))
    dof_node = np.append(structure.dof_node, np.repeat(rows, 3))
    dof_direction = np.append(structure.dof_direction, np.tile([3, 4, 5], len(rows)))
    return Structure(K, M, structure.nodes, dof_node, dof_direction, labels=structure.labels, cells=structure.cells,
                     node_sets=structure.node_sets)


def deck(structure, cards=""):
    """The mesh and the node sets as CalculiX and Abaqus write them, each set a surface, too."""
    text = "*NODE\n" + "".join(f"{label}, {x!r}, {y!r}, {z!r}\n" for label, (x, y, z) in zip(structure.labels, structure.nodes.tolist()))
    text += "*ELEMENT, TYPE=C3D8, ELSET=BODY\n"
    text += "".join(f"{k}, {', '.join(map(str, row))}\n" for k, row in enumerate(structure.labels[structure.cells["hexahedron"]], start=1))
    for name, rows in structure.node_sets.items():
        text += f"*NSET, NSET={name}\n" + "".join(f"{label},\n" for label in structure.labels[rows])
    text += "".join(f"*SURFACE, NAME=S_{name}, TYPE=NODE\n{name}\n" for name in structure.node_sets)
    return text + cards + "*STEP\n*MATRIX GENERATE, STIFFNESS, MASS\n*END STEP\n"


def names(structure):
    """(n, 2) node number and direction from 1 of every dof."""
    return np.stack([structure.labels[structure.dof_node], structure.dof_direction + 1], axis=1)
