"""Rows of a sparse matrix as one rank holds them, from SciPy or PETSc, and the checks made on them.

A symmetric matrix stored by rows is the same matrix stored by columns, so the rows a rank owns are exactly the
columns it has to write in MATLAB's v7.3 layout: nothing moves between ranks.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

SYMMETRY_TOLERANCE = 1e-10  # largest |A - A^T| in a row, relative to the largest entry of that row


@dataclass(frozen=True)
class Rows:
    """Rows `start` to `stop` (exclusive) of an (n, n) matrix in compressed form, columns sorted and global, no exact zeros."""

    n: int
    start: int
    stop: int
    indptr: np.ndarray  # (stop - start + 1,)
    indices: np.ndarray
    data: np.ndarray


def is_petsc(thing):
    """True for petsc4py objects, without importing petsc4py."""
    return type(thing).__module__.startswith("petsc4py")


def even_range(n, comm):
    """The contiguous share [start, stop) of n items that falls to this rank."""
    return n * comm.rank // comm.size, n * (comm.rank + 1) // comm.size


def rows_of(matrix, name, comm):
    """This rank's rows of `matrix` (SciPy: whole on every rank; PETSc: distributed), and of A - A^T.

    Returns
    -------
    rows, asymmetry : Rows, Rows
        Collective over `comm` when the matrix is a PETSc one.
    """
    shape = matrix.getSize() if is_petsc(matrix) else np.shape(matrix)
    if len(shape) != 2 or shape[0] != shape[1]:
        raise ValueError(f"{name} must be square, found shape {tuple(shape)}")
    if is_petsc(matrix):
        return _petsc_rows(matrix)
    whole = sp.csr_matrix(matrix)
    if np.iscomplexobj(whole):
        raise ValueError(f"{name} must be real, found {whole.dtype}")
    start, stop = even_range(shape[0], comm)
    return _scipy_rows(whole, start, stop), _scipy_rows((whole - whole.T).tocsr(), start, stop)


def _scipy_rows(whole, start, stop):
    part = whole[start:stop].astype(np.float64)
    part.sum_duplicates()
    part.eliminate_zeros()
    return Rows(whole.shape[0], start, stop, part.indptr, part.indices, part.data)


def _petsc_rows(matrix):
    from petsc4py import PETSc

    if matrix.getType() not in (PETSc.Mat.Type.SEQAIJ, PETSc.Mat.Type.MPIAIJ):
        matrix = matrix.convert(PETSc.Mat.Type.AIJ, PETSc.Mat())  # e.g. SBAIJ holds one triangle only
    difference = matrix.transpose(PETSc.Mat())
    difference.axpy(-1.0, matrix)

    def local(mat):
        indptr, indices, data = mat.getValuesCSR()
        kept = data != 0  # finite elements and the change to relative coordinates leave many zeros
        indptr = np.append(0, np.cumsum(kept))[indptr].astype(indptr.dtype)
        return Rows(mat.getSize()[0], *mat.getOwnershipRange(), indptr, indices[kept], np.real(data[kept]))

    return local(matrix), local(difference)


def fault(rows, asymmetry, name):
    """What is wrong with the values of these rows (a sentence), or None. Local: no communication."""
    if not np.all(np.isfinite(rows.data)):
        row = rows.start + _row_of_entry(rows, np.flatnonzero(~np.isfinite(rows.data))[0])
        return f"{name} has an entry that is not finite in row {row}"
    difference, size = _row_max(asymmetry), _row_max(rows)
    bad = np.flatnonzero(difference > SYMMETRY_TOLERANCE * size)
    if bad.size:
        return (f"{name} must be symmetric to {SYMMETRY_TOLERANCE:g} of the largest entry of each row, "
                f"found |{name} - {name}^T| = {difference[bad[0]]:.3g} in row {rows.start + bad[0]}, "
                f"whose largest entry is {size[bad[0]]:.3g}")
    return None


def _row_of_entry(rows, entry):
    return int(np.searchsorted(rows.indptr, entry, side="right") - 1)


def _row_max(rows):
    """Largest |entry| of each row, 0 for an empty one; (stop - start,)."""
    largest = np.zeros(rows.stop - rows.start)
    filled = np.diff(rows.indptr) > 0
    largest[filled] = np.maximum.reduceat(np.abs(rows.data), rows.indptr[:-1][filled]) if filled.any() else 0.0
    return largest
