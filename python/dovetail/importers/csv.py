"""Text blocks, one matrix each, as the MATLAB code this method comes from writes them.

    Name: Kee
    10, -10
    -10, 20

    Name: Fe
    1
    1

Columns are separated by commas or blanks, blocks by blank lines; several blocks per file, several files. Names may be written in
either case, with or without underscores. Either the blocks of a full model or those of a reduced one, not both.
"""

import difflib
import re
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from .. import hdf5_parts
from ..hdf5_parts import Part
from ..model import Model

HEADING = re.compile(r"\s*name\s*:\s*(.*?)\s*", re.IGNORECASE)
FULL = ("Mee", "Mec", "Mcc", "Kee", "Kec", "Kcc", "Fe", "Fc", "Pe", "Pc", "Mce", "Kce")
LOADS = ("Fe", "Fc", "Pe", "Pc")
REDUCED = ("omega_a2", "Max", "Mxx", "Kxx", "fa", "fx", "Rx", "Phi", "Psi", "xe0")
REDUCED_NEEDED = REDUCED[:7]


@dataclass(frozen=True)
class Block:
    name: str
    where: str  # "FILE, line 12, block Kee", for messages
    values: np.ndarray  # (rows, columns)


def convert(files, output):
    """Read the blocks in `files` and write a model file or a reduced file. Returns what was written, in words."""
    blocks = read_blocks(files)
    full, reduced = [n for n in FULL if n in blocks], [n for n in REDUCED if n in blocks]
    if full and reduced:
        raise ValueError(f"blocks of a full model ({blocks[full[0]].where}) and of a reduced one ({blocks[reduced[0]].where}) "
                         "cannot go into one file; import them separately")
    return _write_full(blocks, output) if full else _write_reduced(blocks, output)


def read_blocks(files):
    """All blocks of all files, by name in the spelling of FULL and REDUCED."""
    blocks = {}
    for path in files:
        with open(path, encoding="utf-8-sig", errors="replace") as stream:
            for block in _blocks_of(str(path), stream):
                if block.name in blocks:
                    raise ValueError(f"{block.where}: given twice, first in {blocks[block.name].where}")
                blocks[block.name] = block
    if not blocks:
        raise ValueError(f"{', '.join(map(str, files))}: no block found; each must be headed by a line such as 'Name: Kee'")
    return blocks


def _blocks_of(path, stream):
    name, where, rows = None, None, []
    for number, line in enumerate(stream, start=1):
        heading = HEADING.fullmatch(line)
        if heading:
            if name:
                yield _finish(name, where, rows)
            name = _known_name(heading[1], f"{path}, line {number}")
            where, rows = f"{path}, line {number}, block {name}", []
        elif line.strip():
            here = f"{path}, line {number}"
            if not name:
                raise ValueError(f"{here}: wanted a heading such as 'Name: Kee' before the first numbers, found {_short(line)}")
            row = _numbers(line, f"{here}, block {name}")
            if rows and row.size != rows[0].size:
                raise ValueError(f"{here}, block {name}: wanted {rows[0].size} numbers as in the rows above, found {row.size}")
            rows.append(row)
    if name:
        yield _finish(name, where, rows)


def _finish(name, where, rows):
    if not rows:
        raise ValueError(f"{where}: wanted numbers below the heading, found none")
    return Block(name, where, np.array(rows))


def _known_name(found, here):
    known = {_plain(name): name for name in FULL + REDUCED}
    if _plain(found) in known:
        return known[_plain(found)]
    close = difflib.get_close_matches(_plain(found), known, n=1)
    hint = f"did you mean {known[close[0]]}?" if close else f"known are {', '.join(FULL + REDUCED)}"
    raise ValueError(f"{here}: unknown block name {found!r}; {hint}")


def _plain(name):
    return name.replace("_", "").lower()


def _numbers(line, where):
    row = []
    for word in line.replace(",", " ").split():
        try:
            row.append(float(word))
        except ValueError:
            raise ValueError(f"{where}: wanted a number, found {_short(word)}") from None
        if not np.isfinite(row[-1]):
            raise ValueError(f"{where}: wanted a finite number, found {word}")
    return np.array(row)


def _short(text):
    text = text.strip()
    return repr(text if len(text) <= 30 else text[:30] + "...")


def _need(blocks, names, kind):
    missing = [name for name in names if name not in blocks]
    if missing:
        raise ValueError(f"a {kind} model needs the blocks {', '.join(names)}; missing {', '.join(missing)}, "
                         f"found {', '.join(sorted(blocks))}")


def _matrix(blocks, name, shape, reason):
    block = blocks[name]
    if block.values.shape != shape:
        raise ValueError(f"{block.where}: wanted {shape[0]} x {shape[1]} ({reason}), "
                         f"found {block.values.shape[0]} x {block.values.shape[1]}")
    return block.values


def _vector(blocks, name, size, reason):
    """A row or a column of `size` numbers, (size,)."""
    block = blocks[name]
    if block.values.size != size or 1 not in block.values.shape:
        raise ValueError(f"{block.where}: wanted {size} numbers in one row or column ({reason}), "
                         f"found {block.values.shape[0]} x {block.values.shape[1]}")
    return block.values.reshape(-1)


def _square(blocks, name):
    block = blocks[name]
    if block.values.shape[0] != block.values.shape[1]:
        raise ValueError(f"{block.where}: wanted a square matrix, found {block.values.shape[0]} x {block.values.shape[1]}")
    return block.values.shape[0]


def _contact_size(blocks, name):
    n_c = _square(blocks, name)
    if n_c % 3:
        raise ValueError(f"{blocks[name].where}: wanted 3 rows (t1, t2, n) per contact point, found {n_c}")
    return n_c


def _write_full(blocks, output):
    for upper, lower in (("Mec", "Mce"), ("Kec", "Kce")):
        if lower in blocks:
            transposed = blocks[lower].values.T
            if upper in blocks and not np.array_equal(blocks[upper].values, transposed):
                raise ValueError(f"{blocks[lower].where}: wanted the transpose of {blocks[upper].where}, found other numbers")
            blocks.setdefault(upper, Block(upper, blocks[lower].where, transposed))
    _need(blocks, FULL[:6], "full")
    n_e, n_c = _square(blocks, "Kee"), _contact_size(blocks, "Kcc")
    shapes = {"ee": (n_e, n_e), "ec": (n_e, n_c), "cc": (n_c, n_c)}
    matrices = {name: sp.csr_matrix(_matrix(blocks, name, shapes[name[1:]], f"Kee has {n_e} rows, Kcc {n_c}"))
                for name in FULL[:6]}
    sizes = {"e": n_e, "c": n_c}
    loads = {name: _vector(blocks, name, sizes[name[1]], f"one per row of K{name[1] * 2}") for name in LOADS if name in blocks}
    Model.from_blocks(**matrices, **loads).write(output)
    absent = [name for name in LOADS if name not in loads]
    return (f"full model: {n_e} elastic degrees of freedom, {n_c // 3} contact points"
            + (f"; not given, taken as zero: {', '.join(absent)}" if absent else ""))


def _write_reduced(blocks, output):
    _need(blocks, REDUCED_NEEDED, "reduced")
    squares = blocks["omega_a2"]
    if squares.values.shape[0] == squares.values.shape[1] and np.array_equal(squares.values, np.diag(np.diag(squares.values))):
        squares = Block(squares.name, squares.where, np.diag(squares.values)[None])
        blocks = {**blocks, "omega_a2": squares}
    n_a, n_c = squares.values.size, _contact_size(blocks, "Kxx")
    modes, contact = f"omega_a2 has {n_a} entries", f"Kxx has {n_c} rows"
    data = {"Kaa": _vector(blocks, "omega_a2", n_a, "one per mode"),
            "Max": _matrix(blocks, "Max", (n_a, n_c), f"{modes}, {contact}"),
            "Mxx": _matrix(blocks, "Mxx", (n_c, n_c), contact), "Kxx": blocks["Kxx"].values,
            "Fa": _vector(blocks, "fa", n_a, modes), "Fx": _vector(blocks, "fx", n_c, contact),
            "R": _vector(blocks, "Rx", n_c, contact)}
    if np.any(data["Kaa"] <= 0):
        raise ValueError(f"{squares.where}: wanted positive squared frequencies, found {data['Kaa'].min():g}")
    recovery = [name for name in ("Phi", "Psi", "xe0") if name in blocks]
    if recovery:
        n_e = blocks[recovery[0]].values.size if recovery[0] == "xe0" else blocks[recovery[0]].values.shape[0]
        elastic = f"{recovery[0]} has {n_e} rows"
        for name in recovery:
            data[f"recovery/{name}"] = (_vector(blocks, name, n_e, elastic) if name == "xe0" else
                                        _matrix(blocks, name, (n_e, n_a if name == "Phi" else n_c), f"{elastic}, {modes}, {contact}"))
    parts = [Part(name, values.shape, 0, np.ascontiguousarray(values)) for name, values in data.items()]
    hdf5_parts.write(output, parts, {"": {"format": "dovetail-reduced", "version": 1}}, hdf5_parts.Alone())
    return f"reduced model: {n_a} modes, {n_c // 3} contact points" + (f"; recovery from {', '.join(recovery)}" if recovery else "")
