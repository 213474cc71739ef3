"""Text files of row, column, value: read in one go, and made into symmetric matrices."""

from itertools import islice
from pathlib import Path

import numpy as np
import scipy.sparse as sp

SYMMETRY = 1e-10  # allowed difference of the two triangles, relative to the entry or the usual diagonal


def numbers(path, columns, separator, what):
    """The lines of a file as an array; lines that begin with * and empty ones do not count.

    Parameters
    ----------
    path : str or Path
    columns : int
        Numbers per line; all but the last are whole.
    separator : str or None
        "," or, with None, blanks.
    what : str
        What a line should be, for messages: "row, column, value".

    Returns
    -------
    (m, columns - 1) int array, (m,) float array

    Raises
    ------
    ValueError
        Naming the line, when one is not like that, or the file is empty or ends within a line.
    """
    path = Path(path)
    if not path.is_file():
        raise ValueError(f"{path}: no such file")
    if path.stat().st_size == 0:
        raise ValueError(f"{path}: the file is empty; wanted lines of {what}")
    with open(path, "rb") as stream:
        stream.seek(-1, 2)
        if stream.read(1) != b"\n":
            raise ValueError(f"{path}: the last line does not end, so the file is cut short; copy it again")
    if next(_data(path), None) is None:
        raise ValueError(f"{path}: no data; wanted lines of {what}")
    try:
        table = np.loadtxt(path, comments="*", delimiter=separator, ndmin=2)
    except ValueError:
        raise _first_fault(path, columns, separator, what) from None
    if table.shape[1] != columns:
        raise _first_fault(path, columns, separator, what)
    whole = table[:, :-1].astype(np.int64)
    good = np.isfinite(table[:, -1]) & (whole == table[:, :-1]).all(axis=1)
    if not good.all():
        raise _first_fault(path, columns, separator, what)
    return whole, table[:, -1]


def line_of(path, row):
    """"FILE, line N" of data line `row`, counted from 0."""
    return f"{path}, line {next(islice(_data(path), row, None))[0]}"


def _data(path):
    with open(path, encoding="utf-8", errors="replace") as stream:
        for number, line in enumerate(stream, start=1):
            if line.split("*")[0].strip():
                yield number, line.split("*")[0].strip()


def _first_fault(path, columns, separator, what):
    for number, line in _data(path):
        words = line.split(separator)
        try:
            [int(word) for word in words[:-1]]
            good = len(words) == columns and np.isfinite(float(words[-1]))
        except ValueError:
            good = False
        if not good:
            return ValueError(f"{path}, line {number}: wanted {what}, all finite, found {line[:60]!r}")
    return ValueError(f"{path}: wanted lines of {what}")


def symmetric(pairs, values, n, path, name):
    """The symmetric matrix of which the entries of one triangle or of both are given.

    Parameters
    ----------
    pairs : (m, 2) int array
        Row and column, 0 to n - 1. Each pair of different numbers once (in either order), or all of them in both orders.
    values : (m,) float array
    n : int
    path : str or Path
        The file they come from, for messages; data line k holds entry k.
    name : callable
        Puts a row number in words.

    Returns
    -------
    scipy CSR matrix, (n, n), both triangles, without stored zeros

    Raises
    ------
    ValueError
        For entries given twice, or two triangles that differ.
    """
    low, high = np.minimum(pairs[:, 0], pairs[:, 1]), np.maximum(pairs[:, 0], pairs[:, 1])
    key = high * n + low
    if (np.diff(key) <= 0).any():  # not in the order of an upper triangle, column by column
        key, chosen = np.unique(key, return_index=True)
        if len(chosen) < len(values):  # some pairs stand there more than once
            _check_both_triangles(pairs, values, n, path, name)
        low, high, values = low[chosen], high[chosen], values[chosen]
    there = values != 0
    low, high, values = low[there], high[there], values[there]
    apart = low != high
    rows, columns = np.concatenate([low, high[apart]]), np.concatenate([high, low[apart]])
    return sp.csr_matrix((np.concatenate([values, values[apart]]), (rows, columns)), shape=(n, n))


def _check_both_triangles(pairs, values, n, path, name):
    _, first = np.unique(pairs[:, 0] * n + pairs[:, 1], return_index=True)
    if len(first) < len(pairs):
        again = np.setdiff1d(np.arange(len(pairs)), first)[0]
        i, j = pairs[again]
        raise ValueError(f"{line_of(path, again)}: the entry of {name(i)} and {name(j)} is given twice")
    matrix = sp.csr_matrix((values, (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    difference = abs(matrix - matrix.T).tocoo()
    if difference.nnz == 0:
        return
    usual = np.median(abs(matrix.diagonal()))  # not the largest: that may stand for a support
    allowed = SYMMETRY * np.maximum(abs(matrix).tocsr()[difference.row, difference.col].A1, usual)
    if (difference.data > allowed).any():
        at = int(np.argmax(difference.data / allowed))
        i, j = difference.row[at], difference.col[at]
        raise ValueError(f"{path}: the matrix must be symmetric, found {matrix[i, j]:g} for {name(i)} and {name(j)} but {matrix[j, i]:g} "
                         "the other way round")
