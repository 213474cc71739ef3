"""ANSYS archives (CDWRITE): nodes, elements and node components, read by ansys-mapdl-reader."""

import re

import numpy as np

from ..material import UNKNOWN, Material
from .apart import apart
from .deck_sector import of_components
from .inp import Deck
from .inp_sets import Entry

CELLS = {10: ("tetra", 4), 24: ("tetra10", 10), 12: ("hexahedron", 8), 25: ("hexahedron20", 20), 13: ("wedge", 6),  # by VTK number
         26: ("wedge15", 15), 14: ("pyramid", 5), 27: ("pyramid13", 13), 5: ("triangle", 3), 22: ("triangle6", 6), 9: ("quad", 4),
         23: ("quad8", 8)}
NO_CELLS = (22, *range(151, 160), *range(169, 179), 251, 252)  # surface effect, target and contact elements lie on other elements
FORCES = {"FX": 1, "FY": 2, "FZ": 3, "MX": 4, "MY": 5, "MZ": 6}
NUMBER = re.compile(r"[1-9]")  # CDWRITE writes accelerations of zero
PROPERTIES = {"EX": "young", "NUXY": "poisson", "PRXY": "poisson", "DENS": "density"}
ANISOTROPIC = ("EY", "EZ")
OTHER_LOADS = ("SFE", "BF", "BFE", "ACEL", "OMEGA")
MATERIAL, TYPE = 0, 1  # where the numbers of material and element type stand in an element's fields


def read(path, module, notes):
    """The Deck in an archive: nodes, cells, and node components as node sets.

    Parameters
    ----------
    path : str
    module : callable
        Gives a module of ansys-mapdl-reader by its name.
    notes : list of str
        What was not taken is added here.
    """
    _check_blocks(path)
    module("_reader")  # said here if the package is missing
    deck, element_components = apart(lambda: _deck(path, module), path)
    _loads(path, deck)
    _materials(path, deck)
    if element_components:
        notes.append(f"NOT taken: element components {', '.join(element_components)}")
    return deck


def _deck(path, module):
    """The Deck, and the names of what is left out."""
    raw = module("_reader").read(str(path), read_parameters=False, debug=False, read_eblock=True)
    order = np.argsort(raw["nnum"], kind="stable")
    labels, nodes = np.asarray(raw["nnum"], dtype=np.int64)[order], np.asarray(raw["nodes"])[order]
    turned = np.flatnonzero(np.any(nodes[:, 3:] != 0, axis=1))
    if turned.size:
        raise ValueError(f"{path}: node {labels[turned[0]]} has a rotated coordinate system (NROTAT); its degrees of freedom must "
                         "lie along x, y, z")
    cells, material, shapeless = _cells(path, raw, module, labels)
    sets = {}
    for name, members in raw["node_comps"].items():
        inside = np.isin(members, labels)
        if not inside.all():
            raise ValueError(f"{path}, component {name}: node {members[~inside][0]} is not there")
        sets[name] = np.searchsorted(labels, members)
    deck = Deck(str(path), labels, nodes[:, :3].copy(), cells, sets, material=material, shapeless=shapeless,
                sector=of_components(sets, path))
    return deck, list(raw["elem_comps"])


def _loads(path, deck):
    """Fills loads and late_loads from F,NODE,LABEL,REAL,IMAGINARY, and other_loads with the first of each other kind."""
    seen = set()
    with open(path, encoding="utf-8", errors="replace") as stream:
        for number, line in enumerate(stream, start=1):
            words = [word.strip() for word in line.upper().split(",")]
            where = f"{path}, line {number}"
            if words[0] in OTHER_LOADS and words[0] not in seen and NUMBER.search(line.partition(",")[2]):
                seen.add(words[0])
                deck.other_loads.append(f"{words[0]} ({where})")
            if words[0] != "F" or len(words) < 4:
                continue
            try:
                node, values = int(words[1]), [float(word or "0") for word in words[3:5]]
            except ValueError:
                raise ValueError(f"{where}: wanted F, node, direction and numbers, found {line.strip()[:60]!r}") from None
            if words[2] not in FORCES:
                deck.other_loads.append(f"F with {words[2]} ({where})")
                continue
            row = deck.rows_of([node])
            if row[0] < 0 or not np.isfinite(values).all():
                raise ValueError(f"{where}: wanted finite forces on a node of the mesh, found {line.strip()[:60]!r}")
            for value, loads in zip(values, (deck.loads, deck.late_loads)):
                if value:
                    loads.append(Entry(row, FORCES[words[2]], FORCES[words[2]], value, 0, where, card="F"))


def _materials(path, deck):
    """Fills materials from EX, NUXY or PRXY and DENS of MP and MPDATA, and turns their numbers in `material` into rows."""
    found, other = {}, set()
    with open(path, encoding="utf-8", errors="replace") as stream:
        for number, line in enumerate(stream, start=1):
            words = [word.strip() for word in line.upper().split(",")]
            if words[0] == "MP" and len(words) > 3:
                label, of, values = words[1], words[2], words[3:]
            elif words[0] == "MPDATA" and len(words) > 6:  # MPDATA,R5.0,1,LABEL,material,first temperature,values
                label, of, values = words[3], words[4], words[6:]
            else:
                continue
            if label in ANISOTROPIC and of.isdigit():
                other.add(int(of))
            if label not in PROPERTIES:
                continue
            try:
                values = [float(word) for word in values if word]
                found.setdefault(int(of), {})[PROPERTIES[label]] = values[0]
            except (ValueError, IndexError):
                raise ValueError(f"{path}, line {number}: wanted a property of a material and its value, found "
                                 f"{line.strip()[:60]!r}") from None
            if len(values) > 1:  # at several temperatures
                other.add(int(of))
    rows = {}
    for of in sorted(set().union(*(numbers.tolist() for numbers in deck.material.values()))):
        if of in other or not {"young", "poisson"} <= set(found.get(of, ())):
            deck.not_materials.append(f"material {of}")
            continue
        rows[of] = len(deck.materials)
        deck.materials.append(Material(**found[of], name=f"material {of}"))
    deck.material = {kind: np.array([rows.get(of, UNKNOWN) for of in numbers.tolist()]) for kind, numbers in deck.material.items()}


def _check_blocks(path):
    """The reader does not notice blocks that are missing or cut short; it would hand on whatever is in memory."""
    node_lines, wanted, open_block, seen = 0, 0, None, set()
    with open(path, encoding="utf-8", errors="replace") as stream:
        for number, line in enumerate(stream, start=1):
            if open_block == "NBLOCK" and (line[:1].isalpha() or line.strip() == "-1"):
                if wanted and node_lines != wanted:
                    raise ValueError(f"{path}, line {number}: wanted {wanted} nodes as NBLOCK says, found {node_lines}")
                open_block = None
            elif open_block == "EBLOCK" and line.strip() == "-1":
                open_block = None
            elif open_block and line[:1].isalpha():
                raise ValueError(f"{path}, line {number}: wanted -1 at the end of EBLOCK, found {line.strip()[:40]!r}")
            words = [word.strip() for word in line.upper().split(",")]
            if words[0] == "NBLOCK" or (words[0] == "EBLOCK" and "SOLID" in words):
                open_block = words[0]
                seen.add(open_block)
                if open_block == "NBLOCK":
                    wanted, node_lines = (int(words[4]) if words[4:] and words[4].isdigit() else 0), 0
            elif open_block == "NBLOCK" and not line.startswith("("):
                node_lines += 1
    if open_block:
        raise ValueError(f"{path}: cut off within {open_block}")
    for name in ("NBLOCK", "EBLOCK"):
        if name not in seen:
            raise ValueError(f"{path}: has no {name}{',..,SOLID' * (name == 'EBLOCK')}; write it with CDWRITE,DB,NAME,cdb")


def _cells(path, raw, module, labels):
    if len(raw["elem_off"]) < 2:
        raise ValueError(f"{path}: EBLOCK holds no elements")
    kinds = module("elements").ETYPE_MAP.copy()
    kinds[list(NO_CELLS)] = 0
    shape_of = np.zeros(raw["ekey"][:, 0].max() + 1, dtype=np.int32)
    shape_of[raw["ekey"][:, 0]] = kinds[raw["ekey"][:, 1]]
    starts, shapes, connectivity = module("_reader").ans_vtk_convert(raw["elem"], raw["elem_off"], shape_of, raw["nnum"], True)
    rows = np.searchsorted(labels, raw["nnum"])  # row of the sorted table for each node of the archive
    cells, material, named = {}, {}, raw["elem"][raw["elem_off"][:-1] + MATERIAL]
    for number, (name, size) in CELLS.items():
        first = starts[shapes == number]
        if first.size:
            members = connectivity[first[:, None] + 1 + np.arange(size)]  # each cell is headed by its number of nodes
            if members.min() < 0:
                raise ValueError(f"{path}: a {name} element lacks a node; fill in mid-side nodes (EMID) or use linear elements")
            cells[name], material[name] = rows[members], named[shapes == number].astype(np.int64)
    element_type = raw["elem"][raw["elem_off"][:-1] + TYPE]
    named = dict(raw["ekey"].tolist())
    without = sorted({named.get(number, number) for number in element_type[~np.isin(shapes, list(CELLS))].tolist()})
    return cells, material, [f"of type {number}" for number in without]
