"""CalculiX: the matrices of *FREQUENCY, SOLVER=MATRIXSTORAGE with the deck they come from. See docs/how-to/import-calculix.md."""

import re
from pathlib import Path

import numpy as np

from . import inp, triplets
from .deck_structure import build

PLANE = re.compile(r"CPS|CPE|CAX")
SOLID = ("tetra", "hexahedron", "wedge")
REFUSED = {"CONTACT PAIR": "CalculiX puts contact springs of its own into the stiffness, beside those of the joint; delete the pair "
                           "and run again: surfaces that touch are named with [[joint]] in the set-up file"}
NEEDED = (".inp", ".sti", ".mas", ".dof")


def read(files, *, units="SI"):
    """A Structure from job.inp, job.sti, job.mas and job.dof.

    Parameters
    ----------
    files : list of paths
        The four, in any order, or some: the others are sought beside the first, under its name.
    units : str
        What the deck is written in; a label, nothing is converted. Any consistent system will do, for instance "t, mm, s, N".

    Returns
    -------
    dovetail.Structure
        `notes` says what was taken and what was not.

    Raises
    ------
    ValueError
        When a file is missing, damaged, or does not go with the others.
    """
    paths = _find(files)
    deck = inp.read(paths[".inp"], REFUSED, rayleigh_of_all=True)
    thin = sorted(name for name in deck.cells if not name.startswith(SOLID))
    if thin:
        raise ValueError(f"{deck.path}: wanted solid elements only, found {', '.join(thin)}: CalculiX makes solids of shells and beams, on "
                         "nodes of its own that the deck does not have; mesh with solids")
    plane = sorted(kind for kind in deck.types if PLANE.match(kind))
    if plane:
        raise ValueError(f"{deck.path}: wanted solid elements only, found {', '.join(plane)}, of which CalculiX makes solids; gmsh writes "
                         "the faces of physical surfaces so: leave them out, as in docs/how-to/import-calculix.md, a mesh by gmsh")
    labels, direction = _dofs(paths[".dof"])
    n = len(labels)
    K, stiffness_lines = _matrix(paths[".sti"], n, labels, direction)
    M, mass_lines = _matrix(paths[".mas"], n, labels, direction)
    if stiffness_lines != mass_lines:
        raise ValueError(f"{paths['.mas']}: wanted {stiffness_lines} entries as in {paths['.sti']}, found {mass_lines}; "
                         "are both of one run?")
    held = np.zeros((len(deck.nodes), 6), dtype=bool)
    for entry in deck.holds:
        for d in range(max(entry.first, 1), min(entry.last, 6) + 1):
            held[entry.rows, d - 1] = True
    dof_node = deck.rows_of(labels)
    known = dof_node >= 0
    held[dof_node[known], direction[known] - 1] = False  # a condition that another step lifted
    notes = []
    loads, late = ([load for load in all_loads if load.step == deck.matrix_step] for all_loads in (deck.loads, deck.late_loads))
    return build(deck, K, M, dof_node, direction - 1, held, loads, sources=(str(paths[".sti"]), str(paths[".mas"])), units=units,
                 notes=notes, late=late)


def _find(files):
    given = {}
    for path in map(Path, files):
        kind = path.suffix.lower()
        if kind not in NEEDED or kind in given:
            raise ValueError(f"{path}: wanted one file each that ends in {', '.join(NEEDED)}, found {' '.join(map(str, files))}")
        given[kind] = path
    if not given:
        raise ValueError(f"wanted files that end in {', '.join(NEEDED)}, found none")
    first = next(iter(given.values()))
    paths = {kind: given.get(kind, first.with_suffix(kind)) for kind in NEEDED}
    for kind, path in paths.items():
        if not path.is_file():
            raise ValueError(f"{path}: no such file; CalculiX writes .sti, .mas and .dof when the deck says "
                             "*FREQUENCY, SOLVER=MATRIXSTORAGE")
    return paths


def _dofs(path):
    """Node numbers and directions 1 to 3 (n,) of the rows: lines such as 12.3."""
    text = path.read_text(encoding="utf-8", errors="replace")
    if not re.fullmatch(r"(?:[ \t]*\d+\.\d[ \t]*\n)+", text):
        for number, line in enumerate(text.split("\n"), start=1):
            if not re.fullmatch(r"\s*\d+\.\d\s*", line):
                raise ValueError(f"{path}, line {number}: wanted node.direction such as 12.3, found {line[:30]!r}")
        raise ValueError(f"{path}: wanted lines node.direction such as 12.3, each ended")
    labels, direction = np.array(text.replace(".", " ").split(), dtype=np.int64).reshape(-1, 2).T
    wrong = np.flatnonzero((direction < 1) | (direction > 3))
    if wrong.size:
        raise ValueError(f"{path}, line {wrong[0] + 1}: wanted a direction from 1 to 3, found {direction[wrong[0]]} "
                         "(only displacements are read)")
    key = labels * 4 + direction
    if len(np.unique(key)) < len(key):
        _, first = np.unique(key, return_index=True)
        again = np.setdiff1d(np.arange(len(key)), first)[0]
        raise ValueError(f"{path}, line {again + 1}: {labels[again]}.{direction[again]} is given twice")
    return labels, direction


def _matrix(path, n, labels, direction):
    """The matrix of a file, and how many entries the file has."""
    pairs, values = triplets.numbers(path, 3, None, "row, column, value")
    if pairs.min() < 1 or pairs.max() > n:
        row = int(np.argmax((pairs < 1).any(axis=1) | (pairs > n).any(axis=1)))
        raise ValueError(f"{triplets.line_of(path, row)}: wanted rows and columns from 1 to {n}, as many as the .dof file has lines, "
                         f"found {pairs[row, 0]} and {pairs[row, 1]}")
    diagonal = np.zeros(n, dtype=bool)
    diagonal[pairs[pairs[:, 0] == pairs[:, 1], 0] - 1] = True
    if not diagonal.all():
        row = int(np.argmin(diagonal))
        raise ValueError(f"{path}: row {row + 1} of {n} has no diagonal entry, so the file is cut short or goes with another .dof file")
    matrix = triplets.symmetric(pairs - 1, values, n, path, lambda row: f"row {row + 1} (node {labels[row]}, direction {direction[row]})")
    return matrix, len(values)
