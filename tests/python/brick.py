"""Blocks of 8-node bricks for the tests: nodes, cells, stiffness and mass, written independently of the package."""

import itertools

import numpy as np
import scipy.sparse as sp

from dovetail import Structure

CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])


def grid(corner, edges, counts, mapping=lambda points: points):
    """Nodes (n, 3) and cells (m, 8) of a block of `counts` bricks; `mapping` bends or turns it."""
    places = [np.linspace(c, c + e, k + 1) for c, e, k in zip(corner, edges, counts)]
    nodes = np.array(list(itertools.product(*places)))
    strides = np.array([(counts[1] + 1) * (counts[2] + 1), counts[2] + 1, 1])
    cells = np.array([(np.array(cell) + CORNERS) @ strides for cell in itertools.product(*map(range, counts))])
    return mapping(nodes), cells


def matrices(nodes, cells, young=1.0, poisson=0.0, density=1.0):
    """K and M (3n, 3n) of isotropic bricks, two Gauss points per direction; dofs x, y, z of each node in turn."""
    lame, shear = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))
    signs = 2 * CORNERS - 1
    K, M = np.zeros((2, len(cells), 8, 3, 8, 3))
    for point in itertools.product((-1 / np.sqrt(3), 1 / np.sqrt(3)), repeat=3):
        factors = 1 + signs * point
        values = factors.prod(axis=1) / 8
        local = np.stack([signs[:, i] * np.delete(factors, i, axis=1).prod(axis=1) / 8 for i in range(3)])  # (3, 8)
        jacobian = np.einsum("ai,cik->cak", local, nodes[cells])
        slope = np.linalg.solve(jacobian, np.broadcast_to(local, (len(cells), 3, 8)))  # d N_i / d x_k as (m, k, i)
        volume = np.linalg.det(jacobian)
        assert volume.min() > 0
        parts = np.einsum("c,cki,clj->ckilj", volume, slope, slope)
        K += lame * np.einsum("ckilj->cikjl", parts) + shear * np.einsum("ckilj->ciljk", parts)
        K += shear * np.einsum("ckikj,lm->ciljm", parts, np.eye(3))
        M += density * np.einsum("c,i,j,kl->cikjl", volume, values, values, np.eye(3))
    dofs = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), 24)
    rows, columns = np.repeat(dofs, 24, axis=1).ravel(), np.tile(dofs, 24).ravel()
    return [sp.csr_matrix((block.ravel(), (rows, columns)), shape=(3 * len(nodes),) * 2) for block in (K, M)]


def pair(over=(2, 2, 2), under=(2, 2, 2), gap=0.0, mapping=lambda points: points, **material):
    """Two blocks 2 x 1 x 1, one on the other, as one Structure; contact in the plane z = 0 before the mapping.

    Node sets: touching faces "upper", "lower"; the outer ends "top", "bottom"; all nodes "over", "under".
    """
    plain = [grid((0, 0, z), (2, 1, 1), counts) for z, counts in ((gap, over), (-1, under))]
    (nodes_1, cells_1), (nodes_2, cells_2) = plain
    nodes, n = np.vstack([nodes_1, nodes_2]), len(nodes_1)
    above = np.arange(len(nodes)) < n
    z = nodes[:, 2]
    sets = {"upper": above & (abs(z - gap) < 1e-9), "lower": ~above & (abs(z) < 1e-9), "top": above & (z > gap + 1 - 1e-9),
            "bottom": z < -1 + 1e-9, "over": above, "under": ~above}
    nodes = mapping(nodes)
    cells = np.vstack([cells_1, cells_2 + n])
    K, M = matrices(nodes, cells, **material)
    return Structure(K, M, nodes, np.repeat(np.arange(len(nodes)), 3), np.tile([0, 1, 2], len(nodes)), cells={"hexahedron": cells},
                     node_sets={name: np.flatnonzero(inside) for name, inside in sets.items()})


def turned(axis, angle, shift=(0, 0, 0)):
    """A mapping: rotation about an axis through the origin, then a shift."""
    a = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    cross = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    R = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return lambda points: points @ R.T + shift


def rigid_motions(nodes):
    """Six small rigid motions (6, n_nodes, 3)."""
    moves = [np.tile(direction, (len(nodes), 1)) for direction in np.eye(3)]
    return np.array(moves + [np.cross(direction, nodes) for direction in np.eye(3)])
