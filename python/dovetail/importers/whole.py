"""Square matrices of other programs, checked and with both triangles, and the packages some readers need."""

import importlib

import numpy as np
import scipy.sparse as sp

from ..sparse_rows import SYMMETRY_TOLERANCE


def whole(matrix, where, *, symmetric=False):
    """The matrix with both triangles, (n, n) SciPy CSR of float64.

    Parameters
    ----------
    matrix : (n, n) SciPy sparse or array
    where : str
        The place it was read from, for messages, such as "stiff.mtx, K".
    symmetric : bool
        The file says that the matrix is symmetric, so that one triangle alone stands for both.

    Raises
    ------
    ValueError
        When it is not square, complex, not finite, not symmetric, or one triangle of a matrix that is not said to be symmetric.
    """
    matrix = sp.coo_matrix(matrix)
    if matrix.shape[0] != matrix.shape[1] or matrix.shape[0] == 0:
        raise ValueError(f"{where}: wanted a square matrix, found {matrix.shape[0]} x {matrix.shape[1]}")
    if matrix.shape[0] > 1000 * (matrix.nnz + 1000):
        raise ValueError(f"{where}: wanted a matrix of a structure, found {matrix.nnz} entries in {matrix.shape[0]} rows")
    if np.iscomplexobj(matrix.data):
        raise ValueError(f"{where}: wanted a real matrix, found a complex one; damping belongs in the case file")
    bad = np.flatnonzero(~np.isfinite(matrix.data))
    if bad.size:
        raise ValueError(f"{where}: the entry in row {matrix.row[bad[0]] + 1}, column {matrix.col[bad[0]] + 1} (counted from 1) "
                         "is not finite")
    matrix = matrix.tocsr().astype(np.float64)
    matrix.eliminate_zeros()
    lower, upper = sp.tril(matrix, -1), sp.triu(matrix, 1)
    if bool(lower.nnz) != bool(upper.nnz):
        if not symmetric:
            side = "lower" if lower.nnz else "upper"
            raise ValueError(f"{where}: only the {side} triangle is there, and the file does not say that the matrix is symmetric; "
                             "write both triangles, or declare the matrix symmetric where the format can")
        return (matrix + lower.T + upper.T).tocsr()
    difference = sp.triu(abs(matrix - matrix.T)).tocoo()
    largest = abs(matrix).max(axis=1).toarray()[:, 0]
    excess = difference.data - SYMMETRY_TOLERANCE * np.minimum(largest[difference.row], largest[difference.col])
    if excess.size and excess.max() > 0:
        worst = excess.argmax()
        raise ValueError(f"{where}: wanted a symmetric matrix, found entries that differ by {difference.data[worst]:.3g} across the "
                         f"diagonal, row {difference.row[worst] + 1}, column {difference.col[worst] + 1} (counted from 1)")
    return matrix


def package(module, name, version):
    """Import a module of a package that is not part of Dovetail; ValueError in words when it is missing."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise missing(name, version, error) from None


def missing(name, version, reason):
    """The ValueError for a package that cannot be imported."""
    return ValueError(f"reading these files needs the Python package {name}, which cannot be imported ({reason}); scripts/setup puts it "
                      "into build/extras, where 'source scripts/environment' finds it, or install it yourself with "
                      f"'python3 -m pip install --no-deps {name}=={version}'")


def only(kinds, kind, what):
    """The one file of a kind, of those sorted by kind; `what` is wanted, in words."""
    found = kinds.get(kind, [])
    if len(found) != 1:
        raise ValueError(f"wanted {what}, found {', '.join(found) or 'none'}")
    return found[0]
