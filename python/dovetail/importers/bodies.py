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
    free : (n_b, m) rigid motions that nothing resists, orthonormal
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
        found.append(Body(dofs, rows, _free(K[dofs][:, dofs], moved[dofs], allowed)))
    return found


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
