"""Unknowns inside of elements with incompatible modes (C3D8I), condensed element by element."""

import re

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

INCOMPATIBLE = re.compile(r"C3D8I[A-Z]*")
MOST_INSIDE, MOST_AROUND = 13, 24  # unknowns inside of one such element, and of its eight nodes


def condensed(K, M, inside):
    """K and M (SciPy) without unknowns that belong to one element each: T^T K T and T^T M T with the static motion T of these.

    Parameters
    ----------
    K, M : (n, n)
    inside : (n,) bool
        Unknowns without a place in the mesh. Those of them that are coupled with more than an element holds are kept.

    Returns
    -------
    K, M, kept : matrices of the unknowns that are left, and (n,) bool, which these are
    """
    own = np.flatnonzero(inside)
    count, group = connected_components(abs(K[own][:, own]) + abs(M[own][:, own]), directed=False)
    around = sp.csr_matrix((np.ones(own.size), (group, np.arange(own.size))), shape=(count, own.size)) @ (K[own][:, ~inside] != 0)
    small = (np.bincount(group) <= MOST_INSIDE) & (np.diff(sp.csr_matrix(around).indptr) <= MOST_AROUND)
    own = own[small[group]]
    kept = np.ones(len(inside), dtype=bool)
    kept[own] = False
    if not own.size:
        return K, M, kept
    static = -_inverse(K[own][:, own]) @ K[own][:, kept]
    rows = np.flatnonzero(kept)
    T = sp.csr_matrix((np.ones(len(rows)), (rows, np.arange(len(rows)))), shape=(len(inside), len(rows)))
    T = T + sp.csr_matrix((np.ones(own.size), (own, np.arange(own.size))), shape=(len(inside), own.size)) @ static
    return tuple(sp.csr_matrix(T.T @ matrix @ T) for matrix in (K, M)) + (kept,)


def _inverse(matrix):
    """The inverse of a matrix of small blocks, block by block."""
    count, group = connected_components(matrix, directed=False)
    order = np.argsort(group, kind="stable")
    matrix = sp.csr_matrix(matrix)[order][:, order]
    ends = np.cumsum(np.bincount(group, minlength=count))
    blocks = [np.linalg.inv(matrix[begin:end, begin:end].toarray()) for begin, end in zip(np.r_[0, ends[:-1]], ends)]
    back = np.argsort(order)
    return sp.block_diag(blocks, format="csr")[back][:, back]
