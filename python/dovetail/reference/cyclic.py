"""One sector of a bladed disk at one nodal diameter: u = T_h q, K^h = T_h^H K T_h and its frequencies. Sparse and complex.

With phi = 2 pi h / N and R the turn from a sector to the next: the right side moves as u_R = exp(-i phi) R u_L, and so does b of
a joint to the next sector, as the b' that its contact point sees. Unknowns are what is in the sector, L, s and x:

    pair of nodes       u_a = (s + Q x) / 2,  u_b' = (s - Q x) / 2
    node on a face      u_a = Q x + sum_m N_m u_bm'
    one side held       u_a = Q x, or u_b' = -Q x
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as sla

SMALL = 400  # unknowns up to which matrices are dense


@dataclass(frozen=True)
class SectorBasis:
    """T_h (n, m) sparse, complex; contact (N_x, 3): its columns of t1, t2, n of each contact point, the last ones."""

    matrix: sp.csr_matrix
    contact: np.ndarray

    def of(self, matrix):
        """T^H matrix T."""
        return (self.matrix.conj().T @ sp.csr_matrix(matrix) @ self.matrix).tocsr()


def rotation(cyclic):
    """R (3, 3) of the `cyclic` of a Model."""
    angle, (x, y, z) = 2 * np.pi / cyclic["sectors"], cyclic["axis"]
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.cos(angle) * np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * np.outer(cyclic["axis"], cyclic["axis"])


def sector_basis(model, h):
    """The SectorBasis of a cyclic Model for index h, of any sign."""
    cyclic, n = model.cyclic, model.n
    table = np.full((len(model.mesh["nodes"]), 3), -1)
    placed = np.flatnonzero((model.mesh["dof_node"] >= 0) & (model.mesh["dof_direction"] >= 0) & (model.mesh["dof_direction"] < 3))
    table[model.mesh["dof_node"][placed], model.mesh["dof_direction"][placed]] = placed
    R, turned = rotation(cyclic), np.exp(-2j * np.pi * h / cyclic["sectors"])
    a, b = (np.where(rows[:, None] >= 0, table[rows], -1) for rows in cyclic["nodes"].T)
    plain = np.setdiff1d(np.arange(n), np.concatenate([part.ravel() for part in (cyclic["right"], a, b)]))
    pairs = (a[:, 0] >= 0) & (b[:, 0] >= 0)
    column = np.full(n, -1)
    column[plain] = np.arange(plain.size)
    sums = np.cumsum(pairs) - 1
    first = plain.size + 3 * np.count_nonzero(pairs)
    contact = first + np.arange(3 * len(a)).reshape(-1, 3)
    entries = [(plain, column[plain], np.ones(plain.size))]

    def put(rows, columns, block):
        """Rows and columns are three dofs each, -1 for those that are held."""
        row, col = np.repeat(rows, 3), np.tile(columns, 3)
        there = (row >= 0) & (col >= 0)
        entries.append((row[there], col[there], np.ravel(block)[there]))

    def columns_of(dofs):
        return np.where(dofs >= 0, column[dofs], -1)

    for left, right in zip(cyclic["left"], cyclic["right"]):
        put(right, columns_of(left), turned * R)
    begin, node, weight = (cyclic["faces"][key] for key in ("begin", "node", "weight"))
    for i, axes in enumerate(model.joint["axes"]):
        Q = axes.T
        seen = turned * R if cyclic["next_sector"][i] else np.eye(3)  # u_b' = seen u_b
        s = plain.size + 3 * sums[i] + np.arange(3)
        if pairs[i]:
            put(a[i], s, np.eye(3) / 2), put(a[i], contact[i], Q / 2)
            put(b[i], s, seen.conj().T / 2), put(b[i], contact[i], -seen.conj().T @ Q / 2)
        elif a[i, 0] >= 0:
            put(a[i], contact[i], Q)
            for m in range(begin[i], begin[i + 1]):
                put(a[i], columns_of(table[node[m]]), weight[m] * seen)
        else:
            put(b[i], contact[i], -seen.conj().T @ Q)
    row, col, value = (np.concatenate(parts) for parts in zip(*entries))
    return SectorBasis(sp.csr_matrix((value.astype(complex), (row, col)), shape=(n, first + contact.size)), contact)


def sector_frequencies(model, h, count, contact="stuck"):
    """The lowest `count` frequencies [rad/s] of nodal diameter h. `contact`: "stuck" (springs at all points), "held" or "open"."""
    basis = sector_basis(model, h)
    K, M = basis.of(model.K), basis.of(model.M)
    if contact == "held":
        kept = np.setdiff1d(np.arange(K.shape[0]), basis.contact)
        K, M = K[kept][:, kept], M[kept][:, kept]
    elif contact == "stuck":
        springs = np.zeros(K.shape[0])
        springs[basis.contact] = np.column_stack([model.contact["tangential_stiffness"], model.contact["normal_stiffness"]])
        K = K + sp.diags(springs)
    elif contact != "open":
        raise ValueError(f'contact must be "stuck", "held" or "open", found {contact!r}')
    count = min(count, K.shape[0])
    if K.shape[0] <= max(SMALL, count + 1):
        squares = scipy.linalg.eigh(K.toarray(), M.toarray(), eigvals_only=True)[:count]
    else:
        shift = -1e-6 * K.diagonal().real.mean() / M.diagonal().real.mean()  # K may be singular
        squares = np.sort(sla.eigsh(K.tocsc(), count, M.tocsc(), sigma=shift, return_eigenvectors=False))
    return np.sqrt(np.maximum(squares, 0))
