"""The change to relative coordinates, u = T q: K' = T^T K T and so on, for SciPy and for distributed PETSc matrices.

Only the dofs that joints touch change, and of those every rank knows all; the rest of T is the identity. Nothing is gathered.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from .sparse_rows import is_petsc


@dataclass(frozen=True)
class Change:
    """The rows of T that differ from the identity: u[dof] = rows @ q."""

    dof: np.ndarray  # (c,) ascending
    rows: sp.csr_matrix  # (c, n)

    @property
    def n(self):
        return self.rows.shape[1]

    def matrix(self, begin, end):
        """Rows begin to end (exclusive) of T, (end - begin, n) SciPy."""
        plain = np.ones(end - begin)
        mine = np.flatnonzero((self.dof >= begin) & (self.dof < end))
        place = self.dof[mine] - begin
        plain[place] = 0.0
        identity = sp.csr_matrix((plain, (np.arange(end - begin), np.arange(begin, end))), shape=(end - begin, self.n))
        spread = sp.csr_matrix((np.ones(len(mine)), (place, mine)), shape=(end - begin, len(self.dof)))
        local = (identity + spread @ self.rows).tocsr()
        local.eliminate_zeros()
        local.sort_indices()
        return local

    def apply(self, matrix):
        """T^T matrix T, of the same kind and distribution. Collective for PETSc."""
        if not is_petsc(matrix):
            T = self.matrix(0, self.n)
            changed = (T.T @ sp.csr_matrix(matrix) @ T).tocsr()
            changed.eliminate_zeros()
            return changed
        T = self._petsc(matrix)
        changed = matrix.ptap(T)
        T.destroy()
        return changed

    def apply_load(self, load, like):
        """T^T load; `like` is K, whose distribution a PETSc load has."""
        if not is_petsc(load):
            return self.matrix(0, self.n).T @ load
        T = self._petsc(like)
        changed = T.createVecRight()
        T.multTranspose(load, changed)
        T.destroy()
        return changed

    def _petsc(self, like):
        from petsc4py import PETSc

        local = self.matrix(*like.getOwnershipRange())
        csr = local.indptr.astype(PETSc.IntType), local.indices.astype(PETSc.IntType), local.data
        return PETSc.Mat().createAIJ(like.getSizes(), csr=csr, comm=like.getComm())


def change_of(joints, n):
    """The change of n unknowns that makes the relative displacements of all joints unknowns.

    Raises ValueError when two joints take the same node, or stand on each other's contact points in a circle.
    """
    own = [_changed_dofs(joint) for joint in joints]
    dof = np.sort(np.concatenate(own))
    twice = np.flatnonzero(np.diff(dof) == 0)
    if twice.size:
        names = [joint.name for joint, dofs in zip(joints, own) if dof[twice[0]] in dofs]
        wanted = f"joints {names[0]!r} and {names[1]!r} both take" if len(names) > 1 else f"joint {names[0]!r} takes twice"
        raise ValueError(f"{wanted} a node (dof {dof[twice[0]]}); a node can be a contact point once: leave it out of one of the sets")
    entries = [np.concatenate(parts) for parts in zip(*(_entries(joint) for joint in joints))]
    onto = [np.concatenate(parts) for parts in zip(*(_stands_on(joint) for joint in joints))]

    def rows(row, column, value):
        return sp.csr_matrix((value, (np.searchsorted(dof, row), column)), shape=(dof.size, n))

    direct, standing = rows(*entries), rows(*onto)
    among = standing[:, dof]  # nodes of b that another joint changes: their own rows are put in
    unchanged = np.ones(n)
    unchanged[dof] = 0.0
    term = total = direct + standing @ sp.diags(unchanged)
    for _ in joints:
        term = among @ term
        term.eliminate_zeros()
        if term.nnz == 0:
            break
        total = total + term
    else:
        raise ValueError("the joints stand on each other's contact points in a circle; let one surface of each joint be `a`, once")
    total = total.tocsr()
    total.eliminate_zeros()
    total.sort_indices()
    return Change(dof, total)


def _pair_kinds(joint):
    """For each contact point, whether both sides, only a, or only b can move: three (m,) bool."""
    a = (joint.dofs >= 0).all(axis=1)
    b = (joint.other >= 0).all(axis=1) if joint.kind == "pairs" else np.zeros(len(joint), dtype=bool)
    return a & b, a & ~b, b & ~a


def _changed_dofs(joint):
    both, a, b = _pair_kinds(joint)
    partner = joint.other[both | b] if joint.kind == "pairs" else np.empty((0, 3), dtype=np.int64)
    return np.concatenate([joint.dofs[both | a].ravel(), partner.ravel()])


def _entries(joint):
    """Entries (row, column, value) of T in terms of unknowns that are new or stay."""
    both, a, b = _pair_kinds(joint)
    Q = joint.axes.transpose(0, 2, 1)  # columns t1, t2, n
    parts = [_block(joint.dofs[a], joint.dofs[a], Q[a])]
    if joint.kind == "pairs":
        one, two, half = joint.dofs[both], joint.other[both], Q[both] / 2
        same = np.full(one.size, 0.5)
        parts += [_block(one, one, half), _block(two, one, -half), (one.ravel(), two.ravel(), same), (two.ravel(), two.ravel(), same),
                  _block(joint.other[b], joint.other[b], -Q[b])]
    return tuple(np.concatenate(part) for part in zip(*parts))


def _stands_on(joint):
    """Entries (row, column, value) of u_a = ... + sum_j N_j u_bj; clamped nodes of b do not move."""
    if joint.kind != "faces":
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0)
    row, column = joint.dofs[joint.point].ravel(), joint.other.ravel()
    value = np.repeat(joint.weight, 3)
    moves = (column >= 0) & (value != 0)
    return row[moves], column[moves], value[moves]


def _block(rows, columns, values):
    """Entries of (m, 3, 3) blocks whose rows and columns are dofs (m, 3)."""
    return np.repeat(rows, 3, axis=1).ravel(), np.tile(columns, (1, 3)).ravel(), values.ravel()
