"""The mesh part of an input deck, as CalculiX and Abaqus share it: nodes, cells, sets, surfaces, and what the steps load and hold."""

from dataclasses import dataclass, field

import numpy as np

from .deck_damping import DeckDamping
from .deck_sector import DeckSector, of_blocks
from .elements import cell_of
from .inp_blocks import read_blocks
from .inp_loads import distributed, equations
from .inp_materials import integration_of, take_materials
from .inp_sets import Sets, element_set, entries, node_set, surface

GENERATED = "nodes or elements that the source program generates are not made here; write the deck out with all of them"
REFUSED = {
    **dict.fromkeys(("NGEN", "NFILL", "NCOPY", "NMAP", "SYSTEM", "ELGEN", "ELCOPY"), GENERATED),
    "TRANSFORM": "the matrices may be in these local directions, which are not read; use global directions",
    "SUBMODEL": "a submodel is not read; use the whole model",
}
OTHER_LOADS = ("TEMPERATURE", "BASE MOTION", "INERTIA RELIEF")


@dataclass
class Deck:
    """What `read` found.

    labels (n,) sorted node numbers; nodes (n, 3); cells, node_sets and surfaces as in dovetail.Structure; holds: list of
    inp_sets.Entry from *BOUNDARY; loads: list of inp_loads.Force, Pressure and Weight; late_loads: imaginary ones, of
    LOAD CASE=2; matrix_step: number of the step that writes the matrices, or of the last one;
    equations: list of inp_loads.Equation;
    other_loads: where loads stand that are none of these; damping: keys of [damping], the same
    of all materials; damping_named: cards that are not in it;
    materials, material, integration: as in `mesh` of dovetail.Model; not_materials: those that are not taken;
    sector: cyclic symmetry, if there is any; types: element types; shapeless: those that have no cell here.
    """

    path: str
    labels: np.ndarray = None
    nodes: np.ndarray = None
    cells: dict = None
    node_sets: dict = field(default_factory=dict)
    surfaces: dict = field(default_factory=dict)
    loads: list = field(default_factory=list)
    late_loads: list = field(default_factory=list)
    holds: list = field(default_factory=list)
    matrix_step: int = 0
    equations: list = field(default_factory=list)
    other_loads: list = field(default_factory=list)
    damping: dict = field(default_factory=dict)
    damping_named: list = field(default_factory=list)
    materials: list = field(default_factory=list)
    material: dict = field(default_factory=dict)
    integration: dict = field(default_factory=dict)
    not_materials: list = field(default_factory=list)
    sector: DeckSector = None
    types: set = field(default_factory=set)
    shapeless: list = field(default_factory=list)

    def rows_of(self, labels):
        """Node rows of node numbers, -1 for those that are not in the deck."""
        labels = np.asarray(labels, dtype=np.int64)
        if not len(self.labels):
            return np.full(labels.shape, -1)
        place = np.searchsorted(self.labels, labels).clip(max=len(self.labels) - 1)
        return np.where(self.labels[place] == labels, place, -1)


def read(path, refused=None, rayleigh_of_all=False):
    """The Deck in an input file; `refused`, keyword to reason, are not read beside those that no program's deck may have;
    `rayleigh_of_all` as for DeckDamping.

    Raises
    ------
    ValueError
        For anything that is not understood and would change mesh, sets or loads; file and line are named.
    """
    blocks = read_blocks(path)
    for block in blocks:
        if reason := REFUSED.get(block.keyword) or (refused or {}).get(block.keyword):
            raise block.error(reason)
    deck = Deck(str(path))
    _nodes(deck, blocks, _shift(blocks))
    elements = _elements(deck, blocks)
    node_sets, element_sets = Sets("node set"), Sets("element set")
    damping, step, written = DeckDamping(rayleigh_of_all), 0, 0
    for block in blocks:
        if block.keyword == "STEP":
            step += 1
        elif block.keyword == "MATRIX GENERATE" or block.parameters.get("SOLVER", "").upper() == "MATRIXSTORAGE":
            written = step
        elif block.keyword == "INSTANCE":
            for sets in (node_sets, element_sets):
                sets.leave_part(block.parameters.get("NAME", "part"))
        elif block.keyword in ("NODE", "NSET"):
            node_set(deck, block, node_sets, element_sets, elements)
        elif block.keyword in ("ELEMENT", "ELSET"):
            element_set(block, element_sets, elements)
        elif block.keyword == "SURFACE":
            surface(deck, block, node_sets, element_sets, elements)
        elif block.keyword == "BOUNDARY":
            deck.holds.extend(entries(deck, block, node_sets, step))
        elif block.keyword in ("CLOAD", "DLOAD", "DSLOAD"):
            loads = deck.late_loads if block.parameters.get("LOAD CASE") == "2" else deck.loads
            loads.extend(entries(deck, block, node_sets, step) if block.keyword == "CLOAD" else
                         distributed(deck, block, element_sets, elements, step))
        elif block.keyword == "EQUATION":
            deck.equations.extend(equations(deck, block))
        elif block.keyword in OTHER_LOADS and block.lines:
            deck.other_loads.append(f"*{block.keyword} ({block.where()})")
        damping.see(block)
    deck.matrix_step = written or step
    deck.damping, deck.damping_named = damping.close()
    deck.node_sets = {name: deck.rows_of(numbers) for name, numbers in node_sets.items()}
    take_materials(deck, blocks, element_sets, elements)
    deck.sector = of_blocks(deck, blocks)
    return deck


def _shift(blocks):
    """How the only instance of a deck with parts is moved (3,); ValueError if there are several."""
    instances = [block for block in blocks if block.keyword == "INSTANCE"]
    parts = [block for block in blocks if block.keyword == "PART"]
    if len(instances) > 1 or len(parts) > 1:
        second = (instances[1:] or parts[1:])[0]
        raise second.error("decks with several parts or instances are not read, because the source program numbers their nodes anew; "
                           "write a flat deck (without parts and assemblies) and run that")
    if not instances or not instances[0].lines:
        return np.zeros(3)
    if len(instances[0].lines) > 1:
        raise instances[0].error("a rotated instance is not read; write a flat deck (without parts and assemblies)", 1)
    return np.array([instances[0].number(0, word) for _, words in instances[0].fields() for word in words])


def _nodes(deck, blocks, shift):
    """Fills deck.labels and deck.nodes."""
    tables, origins = [], []
    for block in blocks:
        if block.keyword == "NODE" and block.lines:
            if block.parameters.get("SYSTEM", "R").upper() != "R":
                raise block.error("cylindrical or spherical coordinates are not read; give x, y, z")
            tables.append(block.table(4))
            origins += [(block, row) for row in range(len(block.lines))]
    if not tables:
        raise ValueError(f"{deck.path}: wanted nodes, found no *NODE with data")
    table = np.concatenate(tables)
    labels = table[:, 0].astype(np.int64)
    wrong = np.flatnonzero((labels != table[:, 0]) | (labels < 1))
    if wrong.size:
        block, row = origins[wrong[0]]
        raise block.error(f"wanted a node number from 1 on, found {table[wrong[0], 0]:g}", row)
    order = np.argsort(labels, kind="stable")
    again = np.flatnonzero(np.diff(labels[order]) == 0)
    if again.size:
        (first, first_row), (block, row) = origins[order[again[0]]], origins[order[again[0] + 1]]
        raise block.error(f"node {labels[order[again[0]]]} is there already, in {first.where(first_row)}", row)
    deck.labels, deck.nodes = labels[order], table[order, 1:] + shift


def _elements(deck, blocks):
    """Fills cells, integration and shapeless of the deck. Returns dict of element number to (Cell, row of its cells), or (None, -1)."""
    found, cells = {}, {}
    for block in blocks:
        if block.keyword != "ELEMENT" or not block.lines:
            continue
        kind = block.needed("TYPE").upper()
        deck.types.add(kind)
        cell = cell_of(kind)
        if cell is None:
            deck.shapeless += [kind] * (kind not in deck.shapeless)
            found.update({number: (None, -1) for number in block.first_numbers()})
            continue
        table, starts = block.records(cell.size + 1)
        nodes = deck.rows_of(table[:, 1:])
        missing = np.argwhere(nodes < 0)
        if missing.size:
            line, column = missing[0]
            raise block.error(f"element {table[line, 0]} has node {table[line, column + 1]}, which is not in the mesh",
                              int(starts[line]))
        start = sum(map(len, cells.get(cell.name, ())))
        cells.setdefault(cell.name, []).append(nodes)
        deck.integration.setdefault(cell.name, []).append(np.full(len(nodes), integration_of(kind)))
        for line, number in enumerate(table[:, 0].tolist()):
            if number in found:
                raise block.error(f"element {number} is there already", int(starts[line]))
            found[number] = (cell, start + line)
    if not cells:
        raise ValueError(f"{deck.path}: wanted solid, shell or beam elements, found {', '.join(deck.shapeless) or 'none'}")
    deck.cells, deck.integration = ({name: np.concatenate(parts) for name, parts in of.items()} for of in (cells, deck.integration))
    return found
