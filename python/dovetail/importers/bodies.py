"""Bodies that joints will hold together: what hangs together in K, and which rigid motions nothing in K resists."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from .rigid import LEAST, digits_of, motions


@dataclass(frozen=True)
class Body:
    """Unknowns that stiffness connects.

    dofs : (n_b,) their numbers
    rows : (k,) rows of its nodes
    free : (n_b, m) rigid motions that nothing resists, orthonormal; of a sector, those that all sectors can make alike
    """

    dofs: np.ndarray
    rows: np.ndarray
    free: np.ndarray


def bodies(structure):
    """A Body for each part of a structure with SciPy matrices, the largest first."""
    K = sp.csr_matrix(structure.K)
    placed = structure.dof_node >= 0
    first = np.full(len(structure.nodes), -1)
    first[structure.dof_node[placed]] = np.flatnonzero(placed)
    one = sp.csr_matrix((np.ones(placed.sum()), (np.flatnonzero(placed), first[structure.dof_node[placed]])), shape=K.shape)
    count, group = connected_components(K + one, directed=False)  # a node is one thing, whatever its directions are tied to
    moved = motions(structure.nodes, structure.dof_node, structure.dof_direction)
    allowed = 20 * max(digits_of(K), LEAST)
    order = np.argsort(group, kind="stable")
    parts = np.split(order, np.cumsum(np.bincount(group, minlength=count))[:-1])
    found = []
    for dofs in sorted(parts, key=len, reverse=True):
        rows = np.unique(structure.dof_node[dofs][structure.dof_node[dofs] >= 0])
        free = _free(K[dofs][:, dofs], moved[dofs], allowed)
        found.append(Body(dofs, rows, free if structure.cyclic_sector is None else _alike(structure, dofs, free)))
    return found


def _alike(structure, dofs, free):
    """Of the motions `free` those with which a body still fits its copies in the neighbouring sectors."""
    sector, place = structure.cyclic_sector, np.full(structure.n + 1, -1)
    place[dofs] = np.arange(len(dofs))
    left, right = (place[structure.dofs_of(rows)] for rows in (sector.left, sector.right))
    both = (left >= 0).all(axis=1) & (right >= 0).all(axis=1)
    if not both.any() or not free.shape[1]:
        return free
    apart = free[right[both]] - np.einsum("ij,pjk->pik", sector.rotation, free[left[both]])
    _, sizes, motions_of = np.linalg.svd(apart.reshape(-1, free.shape[1]))
    kept = np.ones(free.shape[1], dtype=bool)
    kept[:len(sizes)] = sizes < 1e-6 * np.linalg.norm(free[right[both]])
    return free @ motions_of[kept].T


def _free(K, moved, allowed):
    """Orthonormal motions of the span of `moved` (n, 6) that K does not resist."""
    lengths = np.linalg.norm(moved, axis=0)
    moved = moved[:, lengths > 0] / lengths[lengths > 0]
    if not moved.shape[1]:
        return moved
    U, sizes, _ = np.linalg.svd(moved, full_matrices=False)
    U = U[:, sizes > 1e-8 * sizes[0]]  # a single node does not turn
    scale = np.einsum("ik,ik->k", abs(U), abs(K) @ abs(U)).max()
    values, vectors = np.linalg.eigh(U.T @ (K @ U))
    return U @ vectors[:, values <= allowed * scale]
