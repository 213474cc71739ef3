"""Abaqus: the matrices of *MATRIX OUTPUT, FORMAT=MATRIX INPUT with the deck they come from. See docs/how-to/import-abaqus.md."""

import re
from pathlib import Path

import numpy as np

from . import inp, triplets
from .deck_structure import build
from .inp_blocks import read_blocks
from .inp_sets import Entry

BASE = 16  # more than any direction: node and direction in one number
HELD = 0.999e36  # Abaqus puts 1e36 on the diagonal of a direction that a boundary condition holds
LINE = "row node, row direction, column node, column direction, value (FORMAT=MATRIX INPUT of global matrices)"
STEP = "; write them with *MATRIX GENERATE, STIFFNESS, MASS, LOAD and *MATRIX OUTPUT, STIFFNESS, MASS, LOAD, FORMAT=MATRIX INPUT"


def read(files, *, units="SI"):
    """A Structure from job.inp, job_STIF1.mtx, job_MASS1.mtx and, if there are loads, job_LOAD1.mtx.

    Parameters
    ----------
    files : list of paths
        The deck alone, when the others lie beside it, or all by name.
    units : str
        What the deck is written in; a label, nothing is converted. Any consistent system will do, for instance "t, mm, s, N".

    Returns
    -------
    dovetail.Structure
        `notes` says what was taken and what was not. Directions that carry 1e36 on the diagonal of the stiffness are left out;
        internal nodes of Abaqus (negative numbers) are unknowns without a place in the mesh.

    Raises
    ------
    ValueError
        When a file is missing, damaged, or does not go with the others.
    """
    paths = _find(files)
    deck = inp.read(paths["inp"])
    pairs, stiffness = _entries(paths["STIF"])
    mass_pairs, mass = _entries(paths["MASS"])
    key = np.unique(pairs)  # node * BASE + direction
    dof_node, direction = _dofs(deck, key, paths["STIF"])
    lost = np.setdiff1d(mass_pairs, key)
    if lost.size:
        raise ValueError(f"{paths['MASS']}: {_words(lost[0])} has mass, but no entry in {paths['STIF']}; is that file cut short?")
    K = _matrix(key, pairs, stiffness, paths["STIF"])
    M = _matrix(key, mass_pairs, mass, paths["MASS"])
    free = K.diagonal() < HELD
    held = np.zeros((len(deck.nodes), 6), dtype=bool)
    stuck = ~free & (dof_node >= 0)
    held[dof_node[stuck], direction[stuck]] = True
    K, M = K[free][:, free], M[free][:, free]
    notes = []
    loads, late = _loads(deck, paths.get("LOAD"), notes)
    return build(deck, K, M, dof_node[free], direction[free], held, loads, sources=(str(paths["STIF"]), str(paths["MASS"])), units=units,
                 notes=notes, late=late)


def _find(files):
    """Paths by "inp", "STIF", "MASS", and "LOAD" if there is one."""
    paths = {}
    for path in map(Path, files):
        kind = re.search(r"_(STIF|MASS|LOAD)\d+$", path.stem.upper())
        kind = kind[1] if kind and path.suffix.lower() == ".mtx" else "inp" if path.suffix.lower() == ".inp" else None
        if kind is None or kind in paths:
            raise ValueError(f"{path}: wanted a deck job.inp and one file each such as job_STIF1.mtx, job_MASS1.mtx, job_LOAD1.mtx, "
                             f"found {' '.join(map(str, files))}")
        paths[kind] = path
    if "inp" not in paths:
        raise ValueError(f"wanted the deck job.inp too, because it holds the mesh; found {' '.join(map(str, files)) or 'no file'}")
    if not paths["inp"].is_file():
        raise ValueError(f"{paths['inp']}: no such file")
    named = "STIF" in paths or "MASS" in paths
    for kind in ("STIF", "MASS", "LOAD"):
        if kind in paths or kind == "LOAD" and named:  # whoever names matrices names the load that goes with them
            continue
        beside = sorted(paths["inp"].parent.glob(f"{paths['inp'].stem}_{kind}[0-9]*.mtx"))
        if len(beside) > 1:
            raise ValueError(f"{paths['inp']}: {' and '.join(path.name for path in beside)} lie beside it; name the files of one step")
        if beside:
            paths[kind] = beside[0]
        elif kind != "LOAD":
            raise ValueError(f"{paths['inp']}: there is no {paths['inp'].stem}_{kind}1.mtx beside it" + STEP)
    return paths


def _entries(path):
    """Keys node * BASE + direction of row and column (m, 2), and values (m,)."""
    if path.is_file():
        with open(path, encoding="utf-8", errors="replace") as stream:
            data = next((line for line in stream if line.strip() and not line.startswith("*")), "")
        if data and "," not in data:
            raise ValueError(f"{path}: found {data.strip()[:40]!r}, as FORMAT=COORDINATE writes it, which does not say to which node a row "
                             "belongs; write it again with FORMAT=MATRIX INPUT")
    whole, values = triplets.numbers(path, 5, ",", LINE)
    node, direction = whole[:, [0, 2]], whole[:, [1, 3]]
    wrong = (direction < 1) | (direction >= BASE) | (direction > 6) & (node > 0)
    if wrong.any():
        row = int(np.argmax(wrong.any(axis=1)))
        raise ValueError(f"{triplets.line_of(path, row)}: wanted displacements and rotations, directions 1 to 6, found directions "
                         f"{direction[row, 0]} and {direction[row, 1]}; pressure, temperature and the like are not read")
    return node * BASE + direction, values


def _words(key):
    return f"node {key // BASE}, direction {key % BASE}"


def _dofs(deck, key, path):
    """Node rows, -1 for internal nodes, and directions from 0 of the unknowns."""
    labels = key // BASE
    rows = deck.rows_of(labels)
    strange = (rows < 0) & (labels >= 0)
    if strange.any():
        raise ValueError(f"{path}: node {labels[strange][0]} is not in the mesh of {deck.path}; the deck must be the one that was run, "
                         "without parts and assemblies")
    return rows, np.where(labels < 0, -1, key % BASE - 1)


def _matrix(key, pairs, values, path):
    return triplets.symmetric(np.searchsorted(key, pairs), values, len(key), path, lambda row: _words(key[row]))


def _loads(deck, path, notes):
    """Entry of every line of the load file, and of its imaginary ones."""
    in_step = [load.where for load in [*deck.loads, *deck.late_loads] if load.step in (0, deck.matrix_step)]
    if in_step and path is None:
        notes.append(f"NOT taken: *CLOAD and other loads of the matrix step ({in_step[0]}), because there is no _LOAD1.mtx" + STEP)
    if path is None:
        return [], []
    if deck.other_loads:
        notes.append(f"loads come from {path} alone, which holds {', '.join(deck.other_loads)} too if they act in the matrix step")
        deck.other_loads = []
    entries, late, cases = [], [], 0
    for block in read_blocks(path):
        if block.keyword != "CLOAD":
            raise block.error("wanted *CLOAD with lines node, direction, force")
        table = block.table(3)
        imaginary = "IMAGINARY" in block.parameters
        cases += not imaginary
        if cases > 1:
            raise block.error("several load cases are not read; leave one in the matrix step")
        rows = deck.rows_of(table[:, 0].astype(np.int64))
        for k, (row, (node, direction, value)) in enumerate(zip(rows, table)):
            if row < 0 and value:
                raise block.error(f"node {node:g} is not in the mesh", k)
            if value:
                entry = Entry(np.array([row]), int(direction), int(direction), value, deck.matrix_step, block.where(k))
                (late if imaginary else entries).append(entry)
    return entries, late
