"""Harwell-Boeing files as ANSYS writes them: symmetric, with D exponents and perhaps a right-hand side.

SciPy's own reader takes none of the three.
"""

import re
from itertools import islice

import numpy as np
import scipy.sparse as sp

FORMAT = re.compile(r"\(\s*(?:\d+P\s*,?\s*)?(\d*)\s*([IEDFG])(\d+)(?:\.\d+)?(?:E\d+)?\s*\)", re.IGNORECASE)


def read(path):
    """The matrix in a Harwell-Boeing file.

    Returns
    -------
    matrix : (n, n) SciPy CSC; one triangle if `symmetric`
    symmetric : bool
    right_hand_side : (n,) array, or None
    """
    with open(path, encoding="utf-8", errors="replace") as stream:
        head = [stream.readline() for _ in range(4)]
        kind = head[2][:3].upper()
        if not re.fullmatch(r"[RCP][SUHZR][AE]", kind):
            raise ValueError(f"{path}, line 3: wanted a Harwell-Boeing matrix type such as RSA, found {head[2][:14].strip()!r}")
        if kind not in ("RSA", "RUA"):
            raise ValueError(f"{path}, line 3: wanted a real, assembled matrix, RSA or RUA, found {kind}")
        counts = _whole_numbers(head[1], 14, f"{path}, line 2")
        rows, columns, entries = (_whole_numbers(head[2][14:], 14, f"{path}, line 3") + [0, 0, 0])[:3]
        right = counts[4] if len(counts) > 4 else 0
        formats = [found.groups() for found in map(FORMAT.fullmatch, re.findall(r"\([^)]*\)", head[3])) if found]
        if len(formats) != head[3].count("(") or len(formats) < (4 if right else 3):
            raise ValueError(f"{path}, line 4: wanted Fortran formats such as (10I8) for column pointers, row numbers and values, "
                             f"found {head[3].strip()!r}")
        if right and stream.readline()[:1].upper() != "F":
            raise ValueError(f"{path}, line 5: wanted a full right-hand side (F), found another kind; write the file without one")
        sizes = [columns + 1, entries, entries] + ([rows] if right else [])
        lines = 4 + bool(right)
        blocks = []
        for size, (repeat, _, width) in zip(sizes, formats):
            blocks.append(_block(stream, size, int(repeat or 1), int(width), path, lines))
            lines += -(-size // int(repeat or 1))
    pointers, numbers = (block.astype(np.int64) - 1 for block in blocks[:2])
    if pointers[0] != 0 or pointers[-1] != entries or (np.diff(pointers) < 0).any():
        raise ValueError(f"{path}: column pointers must rise from 1 to {entries + 1}")
    if entries and not 0 <= numbers.min() <= numbers.max() < rows:
        raise ValueError(f"{path}: row numbers must lie in 1 to {rows}")
    return sp.csc_matrix((blocks[2], numbers, pointers), shape=(rows, columns)), kind == "RSA", blocks[3] if right else None


def _whole_numbers(line, width, where):
    words = [line[i:i + width] for i in range(0, len(line.rstrip()), width)]
    try:
        return [int(word) for word in words if word.strip() and not re.match(r"[A-Za-z]", word)]
    except ValueError:
        raise ValueError(f"{where}: wanted whole numbers in columns of {width}, found {line.strip()!r}") from None


def _block(stream, size, repeat, width, path, before):
    """`size` numbers, `repeat` to a line, `width` characters each, as float64."""
    values = []
    for number, line in enumerate(islice(stream, -(-size // repeat)), start=before + 1):
        line = line.rstrip("\n").upper().replace("D", "E")
        words = [line[i:i + width] for i in range(0, repeat * width, width)][:size - len(values)]
        try:
            values += [float(word) for word in words]
        except ValueError:
            raise ValueError(f"{path}, line {number}: wanted {len(words)} numbers, {width} characters each, "
                             f"found {line.strip()[:60]!r}") from None
    if len(values) < size:
        raise ValueError(f"{path}: cut off: wanted {size} numbers from line {before + 1} on, found {len(values)}")
    return np.array(values)
