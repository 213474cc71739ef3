"""ANSYS: matrices from a full file or from HBMAT, mesh and components from an archive (CDWRITE).

Files are told apart by what is in them. `K=FILE`, `M=FILE` name Harwell-Boeing matrices; `load=force` or `load=preload` takes the
load vector that stands beside K.
"""

import importlib
import importlib.util
import re
import struct
import sys
from pathlib import Path

import numpy as np

from . import ansys_archive, harwell_boeing
from .apart import apart
from .deck_structure import build
from .whole import missing, only, whole

PACKAGE, VERSION = "ansys-mapdl-reader", "0.56.0"
LABELS = ("UX", "UY", "UZ", "ROTX", "ROTY", "ROTZ")
NAMED = ("K", "M", "load")
MOST_DIGITS = 18  # of a node number


def read(files, *, units="SI"):
    """A Structure from the files of one ANSYS model.

    Parameters
    ----------
    files : list of str
        An archive (.cdb) and either a full file or "K=FILE", "M=FILE" and the mapping file that HBMAT writes. Optionally
        "load=force" or "load=preload".
    units : str
        What the model is written in; a label, nothing is converted.

    Returns
    -------
    dovetail.Structure
        Node components are its node sets. Forces (F) of the archive are the excitation, unless "load=..." is given.
        Dofs that ANSYS constrained are not in it. `notes` says what was taken and what was not.

    Raises
    ------
    ValueError
        When a file is missing, damaged, or does not go with the others.
    """
    named, kinds = _sort(files)
    archive = only(kinds, "archive", "one archive with the mesh (CDWRITE, DB)")
    if named.get("load") not in (None, "force", "preload"):
        raise ValueError(f"load must be force or preload, found {named['load']}")
    if "full" in kinds:
        if "K" in named or "M" in named or "mapping" in kinds:
            raise ValueError("give either a full file or Harwell-Boeing matrices with their mapping file, not both")
        source = only(kinds, "full", "one full file")
        _reader("full")  # said here if the package is missing
        K, M, dofs, load, constrained = apart(lambda: _full(source), source)
    else:
        K, M, dofs, load = _harwell_boeing(named, kinds)
        source, constrained = named["K"], None
    notes = []
    deck = ansys_archive.read(archive, _reader, notes)
    place = deck.rows_of(dofs[:, 0])
    if (place < 0).any():
        raise ValueError(f"{archive}: node {dofs[place < 0][0, 0]}, which has degrees of freedom in {source}, is not there")
    held = np.zeros((len(deck.nodes), 6), dtype=bool)
    if constrained is None:
        notes.append("HBMAT leaves out degrees of freedom that are constrained, and those that CE or CP tie to others, and does not say "
                     "which is which; all are taken as held")
        held[:] = True
        held[place, dofs[:, 1]] = False
    else:
        held[deck.rows_of(constrained[:, 0]), constrained[:, 1]] = True
    sources = (source, source if constrained is not None else named["M"])
    loads, late = deck.loads, deck.late_loads
    if "load" in named and loads + late:
        notes.append(f"NOT taken: F of the archive ({(loads + late)[0].where}), because load={named['load']} takes the vector that has "
                     "them")
        loads, late = [], []
    structure = build(deck, K, M, place, dofs[:, 1], held, loads, sources=sources, units=units, notes=notes, late=late)
    if "load" in named:
        if load is None or not load.any():
            raise ValueError(f"load={named['load']}: {source} has no load vector other than zero")
        setattr(structure, named["load"], load)
        notes.append(f"load vector of {source} taken as {named['load']}")
    elif load is not None and load.any():
        notes.append(f"NOT taken: the load vector of {source}; load=force or load=preload takes it")
    return structure


def _sort(files):
    """Named words {"K": path, ...} and paths by kind {"full": [...], "archive": [...], "mapping": [...]}."""
    named, kinds = {}, {}
    for word in map(str, files):
        name, equals, rest = word.partition("=")
        if equals and name in NAMED:
            if name in named:
                raise ValueError(f"{word}: {name} is given twice")
            named[name] = rest
            continue
        with open(word, "rb") as stream:
            head = stream.read(65536)
        if head[:4] == struct.pack("<i", 100) and len(head) > 12:
            kinds.setdefault("full", []).append(word)
        elif b"\0" not in head and re.search(rb"(?m)^\s*\d+\s+\d+\s+(U[XYZ]|ROT[XYZ])\s*$", head):
            kinds.setdefault("mapping", []).append(word)
        elif b"\0" not in head and re.search(rb"(?im)^(NBLOCK|/COM|/PREP7)", head):
            kinds.setdefault("archive", []).append(word)
        else:
            raise ValueError(f"{word}: neither an ANSYS full file, nor an archive (CDWRITE), nor a mapping file of HBMAT; "
                             "Harwell-Boeing matrices are named as K=FILE and M=FILE")
    return named, kinds


def _reader(module):
    """A module of ansys-mapdl-reader.

    The package's first file starts a plotting library of half a gigabyte that the readers themselves do without, so they are
    loaded past it.
    """
    try:
        if "ansys.mapdl.reader" not in sys.modules:
            found = importlib.util.find_spec("ansys.mapdl.reader")
            if found is None:
                raise ModuleNotFoundError("no module named ansys.mapdl.reader")
            sys.modules["ansys.mapdl.reader"] = importlib.util.module_from_spec(found)
        return importlib.import_module(f"ansys.mapdl.reader.{module}")
    except ImportError as error:
        sys.modules.pop("ansys.mapdl.reader", None)
        raise missing(PACKAGE, VERSION, error) from None


def _full(path):
    """K, M, dofs (n, 2) of node number and direction, load (n,), and the constrained ones (c, 2) that are not among them."""
    words = Path(path).stat().st_size // 4
    kind = int(np.fromfile(path, "<i4", 3)[2])
    if kind != 4:
        raise ValueError(f"{path}: wanted a full file (kind 4), found an ANSYS binary file of kind {kind}")
    try:
        full = _reader("full").FullFile(path)
    except NotImplementedError as error:
        raise ValueError(f"{path}: {error}; solve with LUMPM,OFF and a symmetric eigenvalue solver") from None
    header = full._header  # the reader has no other way to its counts and pointers
    if header["fun04"] >= 0:
        raise ValueError(f"{path}: written by the frontal solver; write it with the sparse solver (EQSLV,SPARSE)")
    if words < max(header[name] for name in ("ptrSTF", "ptrMAS", "ptrDOF", "ptrRHS", "ptrEND")):
        raise ValueError(f"{path}: cut off: its header points beyond its end at {4 * words} bytes")
    if header["ncefull"] > 0:
        raise ValueError(f"{path}: {header['ncefull']} constraint equations (CE, CP, rigid regions) are not in K; remove them from "
                         "the model")
    if not header["ntermMl"] and not header["ntermMh"]:
        raise ValueError(f"{path}: has no mass matrix; write it in a modal analysis (ANTYPE,MODAL)")
    # `numdof` numbers follow the header; the reader counts a node's dofs 0, 1, 2, ... in their order
    present = _numbers_of_dofs(path, header["numdof"])
    if list(present) != list(range(1, len(present) + 1)) or len(present) > 6:
        raise ValueError(f"{path}: wanted the degrees of freedom UX, UY, UZ and perhaps ROTX, ROTY, ROTZ, found numbers "
                         f"{', '.join(map(str, present))}")
    dofs, K, M = full.load_km(sort=False)
    dofs, constrained = dofs.astype(np.int64), full.const.astype(np.int64).reshape(-1, 2)
    free = ~np.isin(8 * dofs[:, 0] + dofs[:, 1], 8 * constrained[:, 0] + constrained[:, 1])
    load = np.asarray(full.load_vector, dtype=np.float64)
    K, M = (whole(matrix, f"{path}, {name}", symmetric=True)[free][:, free] for matrix, name in ((K, "K"), (M, "M")))
    return K, M, dofs[free], load[free], constrained


def _numbers_of_dofs(path, count):
    common = _reader("common")
    with open(path, "rb") as stream:
        common.read_table(stream, skip=True)
        common.read_table(stream, skip=True)
        return np.asarray(common.read_table(stream, cython=True))[:count]


def _harwell_boeing(named, kinds):
    absent = [name for name in ("K", "M") if name not in named]
    if absent:
        raise ValueError(f"wanted a full file, or Harwell-Boeing matrices; missing {' and '.join(f'{name}=FILE' for name in absent)}")
    maps = [_mapping(path) for path in kinds.get("mapping", [])]
    if not maps:
        raise ValueError("wanted the mapping file that HBMAT writes with its last argument YES; without it no row can be identified")
    if any(not np.array_equal(maps[0], other) for other in maps[1:]):
        raise ValueError(f"{kinds['mapping'][1]}: wanted the same rows as in {kinds['mapping'][0]}")
    dofs, matrices, load = maps[0], [], None
    for name in ("K", "M"):
        matrix, symmetric, right = harwell_boeing.read(named[name])
        if matrix.shape[0] != len(dofs):
            raise ValueError(f"{named[name]}: wanted {len(dofs)} rows as in {kinds['mapping'][0]}, found {matrix.shape[0]}")
        matrices.append(whole(matrix, named[name], symmetric=symmetric))
        load = right if name == "K" else load
    return *matrices, dofs, load


def _mapping(path):
    """(n, 2): node number and direction 0..5 of each row."""
    rows = []
    for number, line in enumerate(Path(path).read_text(errors="replace").splitlines(), start=1):
        words = line.split()
        if len(words) != 3 or not (words[0].isdigit() and words[1].isdigit() and len(words[1]) <= MOST_DIGITS):
            if not rows or not words:
                continue  # headings
            raise ValueError(f"{path}, line {number}: wanted row number, node and direction, found {line.strip()[:40]!r}")
        if words[2].upper() not in LABELS:
            raise ValueError(f"{path}, line {number}: wanted a direction {', '.join(LABELS)}, found {words[2]}")
        if int(words[0]) != len(rows) + 1:
            raise ValueError(f"{path}, line {number}: wanted row {len(rows) + 1}, found {words[0]}")
        rows.append((int(words[1]), LABELS.index(words[2].upper())))
    return np.array(rows, dtype=np.int64)
