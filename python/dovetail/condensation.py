"""Statics of a structure by its contact dofs alone: K_cc - K_ce K_ee^-1 K_ec, after Guyan (1965), from one factorisation of K_ee."""

import importlib.util

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as sla

from .petsc_begin import petsc
from .sparse_rows import is_petsc

LARGE = 3000  # dofs, from which on MUMPS factors K_ee where petsc4py is there; below, either takes less than a second
AT_ONCE = 64  # right-hand sides: dense, so that all at once would need much memory


class Condensed:
    """A stiffness seen from the dofs `kept`, with all loads of the structure.

    Parameters
    ----------
    K : SciPy sparse, or petsc4py Mat of one process, (n, n)
        Symmetric, both triangles; definite where the dofs `kept` are held.
    kept : (m,) int

    Attributes
    ----------
    stiffness : (m, m) [N/m]
    """

    def __init__(self, K, kept):
        with_mumps = is_petsc(K) or K.shape[0] > LARGE and importlib.util.find_spec("petsc4py")
        K = _whole(K) if is_petsc(K) else sp.csr_matrix(K)
        self.kept, self.rest = np.asarray(kept), np.setdiff1d(np.arange(K.shape[0]), kept)
        rows = K[self.rest]
        self._inner, self._coupling = rows[:, self.rest], sp.csc_matrix(rows[:, self.kept])
        self._solve = (_mumps if with_mumps else _superlu)(self._inner) if len(self.rest) else np.copy
        self.stiffness = K[self.kept][:, self.kept].toarray()
        for begin in range(0, len(self.kept), AT_ONCE):
            part = slice(begin, begin + AT_ONCE)
            self.stiffness[:, part] -= self._coupling.T @ self._solve(self._coupling[:, part].toarray())
        self.stiffness = (self.stiffness + self.stiffness.T) / 2

    def load(self, load):
        """(m,) what a load (n,) [N] does to the dofs kept. Raises ValueError where it moves a part with these dofs held."""
        inner = load[self.rest]
        held = self._solve(inner[:, None])[:, 0]
        if not np.all(np.isfinite(held)) or np.abs(self._inner @ held - inner).max(initial=0) > 1e-6 * np.abs(load).max():
            raise ValueError("a part moves freely even with all contact points held")
        return load[self.kept] - self._coupling.T @ held

    def displacements(self, x, load):
        """(n,) [m] of all dofs, from those kept (m,) and the load (n,)."""
        u = np.empty(len(load))
        u[self.kept] = x
        u[self.rest] = self._solve((load[self.rest] - self._coupling @ x)[:, None])[:, 0]
        return u


def _superlu(inner):
    try:
        return sla.splu(sp.csc_matrix(inner)).solve
    except RuntimeError:  # singular to the last bit
        return lambda right: np.full(right.shape, np.nan)


def _whole(K):
    if K.getComm().size > 1:
        raise ValueError("K is distributed: the static state is computed by one process alone")
    indptr, indices, data = K.convert("seqaij", type(K)()).getValuesCSR()
    return sp.csr_matrix((data, indices, indptr), shape=K.getSize())


def _mumps(inner):
    PETSc = petsc()
    alone, count = PETSc.COMM_SELF, PETSc.IntType
    matrix = PETSc.Mat().createAIJ(inner.shape, comm=alone,
                                   csr=(inner.indptr.astype(count), inner.indices.astype(count), inner.data))
    matrix.setOption(PETSc.Mat.Option.SPD, True)
    solver = PETSc.PC().create(alone)
    solver.setOperators(matrix)
    solver.setType("cholesky")
    solver.setFactorSolverType("mumps")
    solver.setUp()

    def solve(right):
        columns = PETSc.Mat().createDense(right.shape, array=np.asfortranarray(right), comm=alone)
        found = columns.duplicate()
        solver.getFactorMatrix().matSolve(columns, found)
        return found.getDenseArray().copy()

    return solve
