"""Bulk data through pyNastran: grid points, cells, sets and loads."""

import re

import numpy as np

from ..material import UNKNOWN, Material
from ..solids import SHAPE
from .deck_sector import of_cyjoin
from .inp import Deck
from .inp_blocks import LARGEST
from .nastran_loads import keep_second_points, take_loads
from .whole import package

# mid-side nodes of Nastran stand in another order than those of VTK: the upright edges come before the upper ones
CELLS = {
    ("CTETRA", 4): ("tetra", range(4)), ("CTETRA", 10): ("tetra10", range(10)),
    ("CHEXA", 8): ("hexahedron", range(8)), ("CHEXA", 20): ("hexahedron20", (*range(12), *range(16, 20), *range(12, 16))),
    ("CPENTA", 6): ("wedge", range(6)), ("CPENTA", 15): ("wedge15", (*range(9), *range(12, 15), *range(9, 12))),
    ("CPYRAM", 5): ("pyramid", range(5)), ("CPYRAM", 13): ("pyramid13", range(13)),
    ("CTRIA3", 3): ("triangle", range(3)), ("CTRIA6", 6): ("triangle6", range(6)),
    ("CQUAD4", 4): ("quad", range(4)), ("CQUAD8", 8): ("quad8", range(8)),
}
THRU = re.compile(r"(-?\d+)[\s,]*THRU[\s,]*(-?\d+)", re.IGNORECASE)
MOST = 10**7
CORNERS = {"CTETRA": 4, "CHEXA": 8, "CPENTA": 6, "CPYRAM": 5, "CTRIA6": 3, "CQUAD8": 4}


def bulk_data(path, name, version, punch=False):
    """A pyNastran model of a deck (with or without case control) or of a punch file."""
    bdf = package("pyNastran.bdf.bdf", name, version)
    model = bdf.BDF(log=package("cpylog", name, version).SimpleLogger(level="error"))
    keep_second_points(model)
    with open(path, encoding="utf-8", errors="replace") as stream:
        control = False
        for number, line in enumerate(stream, start=1):
            control = control or line.strip().upper() == "CEND"
            for first, last in THRU.findall(line):
                if not 0 <= int(last) - int(first) <= MOST:  # pyNastran would write them all out
                    raise ValueError(f"{path}, line {number}: wanted two numbers that rise by at most {MOST}, found {first} THRU {last}")
        punch = punch or not control
    try:
        model.read_bdf(str(path), xref=False, validate=False, punch=punch)
    except (Exception, SystemExit) as error:  # pyNastran raises many kinds; its last line says which card
        reason = str(error).strip().splitlines() or [type(error).__name__]
        raise ValueError(f"{path}: pyNastran cannot read it: {' '.join(line.strip() for line in reason[-3:])}") from None
    return model


def deck_of(model, path, notes):
    """The mesh of a pyNastran model as a Deck.

    Node sets: "SET n" of the case control section and "SET1 n" of the bulk data (those of grid points), and "SPC n", the grid
    points that it holds. What was not taken is added to `notes`. Loads: those of nastran_loads.take_loads.
    """
    turned = [grid for grid, node in model.nodes.items() if node.cd not in (0, None)]
    if turned:
        raise ValueError(f"{path}: grid point {min(turned)} has its degrees of freedom in another coordinate system (CD); wanted the "
                         "basic one, so that they lie along x, y, z")
    if not model.nodes:
        raise ValueError(f"{path}: wanted grid points, found no GRID")
    if not 0 < min(model.nodes) <= max(model.nodes) < LARGEST:
        raise ValueError(f"{path}: wanted numbers of grid points from 1 to {LARGEST}, found {min(model.nodes)} to {max(model.nodes)}")
    labels = np.array(sorted(model.nodes), dtype=np.int64)
    try:
        nodes = np.array([model.nodes[grid].get_position_no_xref(model) for grid in labels]).reshape(-1, 3)
    except (KeyError, AttributeError) as error:
        raise ValueError(f"{path}: a grid point stands in a coordinate system (CP) that is not there: {error}") from None
    cells, properties, others = _cells(model, path, labels)
    deck = Deck(str(path), labels, nodes, cells, _sets(model, labels, notes), shapeless=others)
    _materials(model, deck, properties)
    take_loads(model, deck)
    deck.sector = of_cyjoin(model, deck)
    if any(any(getattr(card, "enforced", ())) for cards in model.spcs.values() for card in cards):
        notes.append("NOT taken: enforced displacements (SPC)")
    return deck


def held_by(model, deck):
    """(n_nodes, 6) bool: what SPC cards and grid points of the deck hold, whether its case control selects them or not."""
    held = np.zeros((len(deck.nodes), 6), dtype=bool)
    for cards in model.spcs.values():
        for card in cards:
            components = card.components if isinstance(card.components, list) else [card.components] * len(card.nodes)
            for grid, wanted in zip(card.nodes, components):
                row = int(deck.rows_of([grid])[0])
                if row >= 0:
                    held[row, [int(c) - 1 for c in str(wanted) if c in "123456"]] = True
    for row, grid in enumerate(deck.labels.tolist()):
        held[row, [int(c) - 1 for c in str(model.nodes[grid].ps or "") if c in "123456"]] = True
    return held


def _materials(model, deck, properties):
    """Fills materials and material of the deck, from MAT1 of the PSOLID of the cells; properties: numbers of these for each kind."""
    rows, strange = {}, set()
    for number in sorted(set().union(*(numbers for kind, numbers in properties.items() if kind in SHAPE))):
        mid = getattr(model.properties.get(number), "mid", None)
        card = model.materials.get(mid)
        if getattr(card, "type", "") != "MAT1" or card.e is None or card.nu is None:
            strange.add(f"MAT of property {number}")
            continue
        rows[number] = len(deck.materials)
        deck.materials.append(Material(card.e, card.nu, card.rho or 0.0, f"MAT1 {mid}"))
    deck.material = {kind: np.array([rows.get(number, UNKNOWN) for number in numbers]) for kind, numbers in properties.items()}
    deck.not_materials += sorted(strange)


def _cells(model, path, labels):
    rows, properties, others = {}, {}, set()
    for number, element in model.elements.items():
        kind, members = element.type, list(element.nodes)
        while members and members[-1] is None:
            members.pop()
        if kind in CORNERS and 0 < len(members) != CORNERS[kind] and (None in members or (kind, len(members)) not in CELLS):
            raise ValueError(f"{path}, {kind} {number}: some mid-side grid points are missing; give all or none")
        found = CELLS.get((kind, len(members)))
        if found is None and kind in ("CTRIA6", "CQUAD8"):
            found = {3: ("triangle", range(3)), 4: ("quad", range(4))}.get(len(members))
        if found is None:
            others.add(kind)
            continue
        rows.setdefault(found[0], []).append([members[i] for i in found[1]])
        properties.setdefault(found[0], []).append(element.pid)
    cells = {}
    for name, members in rows.items():
        members = np.array(members)
        cells[name] = _places(members.reshape(-1), labels, f"{path}, {name} cells").reshape(members.shape)
    return cells, properties, sorted(others)


def _sets(model, labels, notes):
    sets, known = {}, set(labels.tolist())
    for subcase in model.subcases.values():
        for key, (values, *_) in subcase.params.items():
            if not key.startswith("SET ") or values == ["ALL"]:
                continue
            if all(isinstance(value, (int, np.integer)) and value in known for value in values):
                sets[key] = np.searchsorted(labels, sorted(values))
            else:
                notes.append(f"NOT taken: {key} of the case control section, not all of it are grid points")
    for number, card in model.sets.items():
        if card.type == "SET1":
            members = [member for member in card.ids if not isinstance(member, str)]
            if known.issuperset(members):
                sets[f"SET1 {number}"] = np.searchsorted(labels, sorted(members))
            else:
                notes.append(f"NOT taken: SET1 {number}, not all of it are grid points")
    for number, cards in model.spcs.items():
        members = sorted({grid for card in cards for grid in card.nodes} & known)
        if members:
            sets[f"SPC {number}"] = np.searchsorted(labels, members)
    return sets


def _places(grids, labels, where):
    place = np.searchsorted(labels, grids).clip(max=len(labels) - 1)
    lost = np.flatnonzero(labels[place] != grids)
    if lost.size:
        raise ValueError(f"{where}: grid point {grids[lost[0]]} is not there")
    return place
