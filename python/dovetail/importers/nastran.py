"""Nastran: matrices from DMIG punch or OP4 files, mesh and sets from the bulk data, all read by pyNastran.

DMIG carries grid point and component of every row. OP4 does not: its rows are those of the g-set, or of the a-set that the deck
names (ASET, ASET1), or those of a text file that lists them.
"""

import re
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from .deck_structure import build
from .nastran_mesh import bulk_data, deck_of, held_by
from .whole import only, package, whole

PACKAGE, VERSION = "pyNastran", "1.4.1"
NAMES = {"K": re.compile(r"K(GG|NN|FF|AA|LL|XX|JJ)X?"), "M": re.compile(r"M(GG|NN|FF|AA|LL|XX|JJ)X?")}


def read(files, *, units="SI"):
    """A structure from the files of one Nastran model.

    Parameters
    ----------
    files : list of str
        The bulk data (.bdf, .dat, .nas), and a punch file with DMIG matrices (.pch) or an OP4 file (.op4), in one or more files; for
        OP4, if need be, a text file (.rows) with "grid component" of each row. "K=NAME" and "M=NAME" choose among several matrices.
    units : str
        What the model is written in; a label, nothing is converted.

    Returns
    -------
    Structure
        Dofs with neither stiffness nor mass are not in it. `notes` says what was taken and what was not.

    Raises
    ------
    ValueError
        When a file is missing, damaged, or does not go with the others, or rows of a matrix cannot be identified.
    """
    chosen, kinds = _sort(files)
    path = only(kinds, "deck", "bulk data with GRID cards (.bdf, .dat, .nas) in one file, with INCLUDE if need be")
    model, notes = bulk_data(path, PACKAGE, VERSION), []
    deck = deck_of(model, path, notes)
    matrices = _dmig(model, path)
    for punch in kinds.get("dmig", []):
        _add(matrices, _dmig(bulk_data(punch, PACKAGE, VERSION, punch=True), punch))
    for op4 in kinds.get("op4", []):
        _add(matrices, _op4(op4))
    K, M = (_choose(matrices, name, chosen.get(name)) for name in NAMES)
    others = sorted(set(matrices) - {K["name"], M["name"]})
    if others:
        notes.append(f"NOT taken: matrices {', '.join(others)}")
    source, mass_source = K["where"], M["where"]
    dofs, K, M = _rows(K, M, model, path, kinds.get("rows", []))
    dofs, K, M = _without_empty(dofs, K, M, notes)
    scalar = np.isin(dofs[:, 0], list(model.spoints))
    place = np.where(scalar, -1, deck.rows_of(dofs[:, 0]))
    lost = np.flatnonzero(~scalar & (place < 0))
    if lost.size:
        raise ValueError(f"{path}: grid point {dofs[lost[0], 0]}, which has rows in the matrices, is not there")
    without = np.flatnonzero(~scalar & (dofs[:, 1] == 0))
    if without.size:
        raise ValueError(f"{source}: component 0 belongs to scalar points only, found it for grid point {dofs[without[0], 0]}")
    direction = np.where(scalar, -1, dofs[:, 1] - 1)
    held = held_by(model, deck)
    free = held[place[~scalar], direction[~scalar]]
    if free.any():
        notes.append(f"{free.sum()} degrees of freedom that SPC holds are in the matrices and stay free; clamp the node sets named SPC "
                     "in the set-up file")
    held[place[~scalar], direction[~scalar]] = False
    return build(deck, K, M, place, direction, held, deck.loads, late=deck.late_loads, sources=(source, mass_source),
                 units=units, notes=notes)


def _sort(files):
    chosen, kinds = {}, {}
    for word in map(str, files):
        name, equals, rest = word.partition("=")
        if equals and name in NAMES:
            chosen[name] = rest.upper()
            continue
        suffix = Path(word).suffix.lower()
        with open(word, "rb") as stream:
            head = stream.read(1 << 20)
        if suffix == ".op4":
            kind = "op4"
        elif suffix == ".rows":
            kind = "rows"
        elif re.search(rb"(?im)^\s*(GRID[*\s,]|BEGIN\s+BULK|INCLUDE\s)", head):
            kind = "deck"
        elif re.search(rb"(?im)^\s*DMIG[*\s,]", head):
            kind = "dmig"
        else:
            raise ValueError(f"{word}: neither bulk data with GRID, nor a punch file with DMIG, nor .op4, nor .rows")
        kinds.setdefault(kind, []).append(word)
    return chosen, kinds


def _add(matrices, found):
    for name, matrix in found.items():
        if name in matrices:
            raise ValueError(f"{matrix['where']}: given twice, first in {matrices[name]['where']}")
        matrices[name] = matrix


def _choose(matrices, letter, wanted):
    """The matrix meant as K or M."""
    there = ", ".join(matrices) or "none"
    if wanted:
        if wanted not in matrices:
            raise ValueError(f"{letter}={wanted}: there is no such matrix, found {there}")
        return matrices[wanted]
    found = [name for name in matrices if NAMES[letter].fullmatch(name)]
    if len(found) != 1:
        raise ValueError(f"wanted one matrix named like {letter}AAX or {letter}GG, found {', '.join(found) or 'none'} among {there}; "
                         f"say which with {letter}=NAME")
    return matrices[found[0]]


def _dmig(model, path):
    """DMIG matrices: name to {name, where, dofs (n, 2), matrix, symmetric}; without the latter three when neither real nor square."""
    found = {}
    for name, card in model.dmig.items():
        where = f"{path}, DMIG {name}"
        entry = {"name": name, "where": where, "symmetric": False}
        rows, columns = np.asarray(card.GCi), np.asarray(card.GCj)
        if card.matrix_form in (1, 6) and rows.ndim == 2 and columns.ndim == 2 and not card.is_complex:
            dofs, (row, column) = _numbered(rows, columns)
            values = np.asarray(card.Real, dtype=np.float64)
            if card.matrix_form == 6:  # either triangle, entry by entry
                apart = row != column
                row, column = np.r_[row, column[apart]], np.r_[column, row[apart]]
                values = np.r_[values, values[apart]]
            if len(np.unique(row * len(dofs) + column)) < len(row):
                raise ValueError(f"{where}: an entry is given twice")
            entry["dofs"] = dofs
            entry["matrix"] = sp.coo_matrix((values, (row, column)), shape=(len(dofs),) * 2)
        found[name] = entry
    return found


def _numbered(*lists):
    """All (grid, component) of the lists (k, 2) once each, in rising order, and for each list its rows there."""
    keys = np.concatenate([8 * np.asarray(rows, dtype=np.int64)[:, 0] + np.asarray(rows)[:, 1] for rows in lists])
    unique, place = np.unique(keys, return_inverse=True)
    return np.column_stack(np.divmod(unique, 8)), np.split(place, np.cumsum([len(rows) for rows in lists])[:-1])


def _op4(path):
    op4 = package("pyNastran.op4.op4", PACKAGE, VERSION)
    log = package("cpylog", PACKAGE, VERSION).SimpleLogger(level="error")
    try:
        matrices = op4.OP4(log=log).read_op4(path)
    except OSError:
        raise
    except Exception as error:  # pyNastran raises many kinds for a file that is cut off or none at all
        raise ValueError(f"{path}: pyNastran cannot read it as OP4: {error or type(error).__name__}") from None
    found = {}
    for name, matrix in matrices.items():
        if isinstance(matrix.data, list):
            raise ValueError(f"{path}, {name}: given twice")
        shape = np.shape(matrix.data)
        if len(shape) != 2 or shape[0] != shape[1]:
            found[name.upper()] = {"name": name.upper(), "where": f"{path}, {name}"}
            continue
        found[name.upper()] = {"name": name.upper(), "where": f"{path}, {name}", "symmetric": matrix.form == 6, "matrix": matrix.data}
    return found


def _rows(K, M, model, deck, lists):
    """dofs (n, 2) of grid point and component 1..6, K, M with rows in that order."""
    for matrix in (K, M):
        if "matrix" not in matrix:
            raise ValueError(f"{matrix['where']}: wanted a real square or symmetric matrix of grid points and components")
        matrix["whole"] = whole(matrix["matrix"], matrix["where"], symmetric=matrix["symmetric"])
    if ("dofs" in K) != ("dofs" in M):
        raise ValueError(f"{K['where']} and {M['where']}: take both from DMIG or both from OP4")
    if "dofs" in K:
        if lists:
            raise ValueError(f"{lists[0]}: DMIG names its own rows; leave the list out")
        return _together(K, M)
    n = K["whole"].shape[0]
    if M["whole"].shape[0] != n:
        raise ValueError(f"{M['where']}: wanted {n} rows as in {K['where']}, found {M['whole'].shape[0]}")
    return _op4_rows(n, K["where"], model, deck, lists), K["whole"], M["whole"]


def _together(K, M):
    """DMIG leaves out rows of zeros, so K and M may name different ones; both get all."""
    both, parts = _numbered(K["dofs"], M["dofs"])
    spread = []
    for matrix, rows in zip((K, M), parts):
        entries = matrix["whole"].tocoo()
        spread.append(sp.csr_matrix((entries.data, (rows[entries.row], rows[entries.col])), shape=(len(both),) * 2))
    return both, *spread


def _op4_rows(n, where, model, deck, lists):
    if len(lists) > 1:
        raise ValueError(f"wanted one list of rows, found {', '.join(lists)}")
    if lists:
        dofs = _list(lists[0])
        if len(dofs) != n:
            raise ValueError(f"{lists[0]}: wanted {n} rows as in {where}, found {len(dofs)}")
        return dofs
    points = sorted([(grid, 6) for grid in model.nodes] + [(point, 1) for point in model.spoints])
    g_set = [(point, component) for point, count in points for component in range(1, count + 1)]
    if n == len(g_set):
        couplings = [*model.rigid_elements, *model.mpcs, *model.mpcadds]
        if couplings:
            raise ValueError(f"{where}: g-set, in which rigid elements and MPCs of {deck} (number {couplings[0]} and others) are not "
                             "contained; write K and M of the a-set or as DMIG")
        return np.array(g_set, dtype=np.int64)
    a_set = sorted({(point, int(component)) for card in model.asets for point, components in _members(card)
                    for component in components})
    if n == len(a_set):
        return np.array(a_set, dtype=np.int64)
    raise ValueError(f"{where}: {n} rows are neither the g-set of {deck} ({len(g_set)}) nor the a-set of its ASET cards ({len(a_set)}); "
                     "write DMIG, or add a file NAME.rows with 'grid component' of each row")


def _members(card):
    if card.type == "ASET1":
        return [(point, str(card.components)) for point in card.ids]
    return [(point, str(components)) for point, components in zip(card.ids, card.components)]


def _list(path):
    """(n, 2) from lines "grid component"; further columns and lines that begin with $ or # are passed over."""
    rows = []
    for number, line in enumerate(Path(path).read_text(errors="replace").splitlines(), start=1):
        words = line.split()
        if not words or words[0][0] in "$#":
            continue
        if len(words) < 2 or not (words[0].isdigit() and words[1].isdigit() and int(words[1]) <= 6):
            raise ValueError(f"{path}, line {number}: wanted grid point and component (1 to 6, or 0 for a scalar point), "
                             f"found {line.strip()[:40]!r}")
        rows.append((int(words[0]), int(words[1])))
    dofs = np.array(rows, dtype=np.int64).reshape(-1, 2)
    if len(np.unique(dofs, axis=0)) < len(dofs):
        raise ValueError(f"{path}: a grid point and component is listed twice")
    return dofs


def _without_empty(dofs, K, M, notes):
    """Without dofs that no element acts on, such as rotations of solids in the g-set."""
    used = (abs(K).sum(axis=1) + abs(M).sum(axis=1)).A1 > 0
    if not used.all():
        count = int((~used).sum())
        turns = int((dofs[~used, 1] > 3).sum())
        notes.append(f"removed: {count} degrees of freedom with neither stiffness nor mass ({turns} of them rotations)")
    return dofs[used], K[used][:, used], M[used][:, used]
