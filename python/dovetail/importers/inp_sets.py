"""Sets, surfaces, concentrated forces and boundary conditions of an input deck."""

from dataclasses import dataclass

import numpy as np

from .elements import cell_of

MOST = 10**8  # numbers that one line may generate
ABAQUS_HOLDS = {"ENCASTRE": (1, 6), "PINNED": (1, 3), "XSYMM": (1, 1), "YSYMM": (2, 2), "ZSYMM": (3, 3)}  # and rotations


@dataclass
class Entry:
    """One line of *CLOAD or *BOUNDARY, or the like of another program's card.

    Node rows, first and last direction from 1, value, number of its step (0: before all). anew: loads of earlier steps end (OP=NEW).
    """

    rows: np.ndarray
    first: int
    last: int
    value: float
    step: int
    where: str
    anew: bool = False
    card: str = "*CLOAD"


class Sets:
    """Named lists of numbers. Upper and lower case mean the same; the spelling of the first mention is kept."""

    def __init__(self, kind):
        self.kind, self.found = kind, {}
        self.part, self.of_part = "", set()

    def add(self, name, numbers):
        _, parts = self.found.setdefault(name.upper(), (name, []))
        parts.append(np.asarray(numbers, dtype=np.int64))

    def get(self, name):
        """The numbers of a set, sorted, or None; INSTANCE.SET finds SET if nothing else is called so."""
        entry = self.found.get(name.upper()) or self.found.get(name.upper().rpartition(".")[2])
        return None if entry is None else np.unique(np.concatenate(entry[1]))

    def items(self):
        return [(spelled, self.get(spelled)) for spelled, _ in self.found.values()]

    def leave_part(self, instance):
        """Sets read so far belong to the part of this instance."""
        self.part, self.of_part = instance, set(self.found)

    def make_room(self, name):
        """A set of the part that is called like a new one of the assembly becomes INSTANCE.SET."""
        if name.upper() in self.of_part:
            self.of_part.remove(name.upper())
            spelled, parts = self.found.pop(name.upper())
            self.found[f"{self.part}.{spelled}".upper()] = (f"{self.part}.{spelled}", parts)


def node_set(deck, block, node_sets, element_sets, elements):
    """Adds the set of *NSET, or of *NODE with NSET=."""
    if block.keyword == "NODE":
        if block.parameters.get("NSET"):
            node_sets.add(block.parameters["NSET"], block.table(4)[:, 0].astype(np.int64))
        return
    name = block.needed("NSET")
    node_sets.make_room(name)
    node_sets.add(name, [])
    if block.parameters.get("ELSET"):
        members = _named(block, None, block.parameters["ELSET"], element_sets)
        cells = [deck.cells[cell.name][row] for cell, row in (elements[member] for member in members.tolist()) if cell]
        node_sets.add(name, deck.labels[np.unique(np.concatenate(cells))] if cells else [])
        return
    for row, words in block.fields():
        numbers = _numbers(block, row, words, node_sets)
        _in_mesh(deck, block, row, numbers)
        node_sets.add(name, numbers)


def element_set(block, element_sets, elements):
    """Adds the set of *ELSET, or of *ELEMENT with ELSET=."""
    if block.keyword == "ELEMENT":
        if block.parameters.get("ELSET") and block.lines:
            cell = cell_of(block.needed("TYPE"))
            numbers = block.records(cell.size + 1)[0][:, 0] if cell else block.first_numbers()
            element_sets.add(block.parameters["ELSET"], numbers)
        return
    name = block.needed("ELSET")
    element_sets.make_room(name)
    element_sets.add(name, [])
    for row, words in block.fields():
        numbers = _numbers(block, row, words, element_sets)
        _are_elements(block, row, numbers, elements)
        element_sets.add(name, numbers)


def surface(deck, block, node_sets, element_sets, elements):
    """Adds the faces of *SURFACE, TYPE=ELEMENT to the deck; one of TYPE=NODE becomes a node set."""
    name, kind = block.needed("NAME"), block.parameters.get("TYPE", "ELEMENT").upper()
    if kind not in ("ELEMENT", "NODE") or "COMBINE" in block.parameters:
        raise block.error("wanted TYPE=ELEMENT or TYPE=NODE, without COMBINE")
    if kind == "NODE":
        numbers = [_numbers(block, row, words[:1], node_sets) for row, words in block.fields()]
        for row, members in enumerate(numbers):
            _in_mesh(deck, block, row, members)
        numbers = np.unique(np.concatenate(numbers or [np.zeros(0, dtype=np.int64)]))
        there = node_sets.get(name)
        if there is not None and not np.array_equal(there, numbers):
            raise block.error(f"there is a node set {name!r} of other nodes too; give the surface another name")
        if there is None:
            node_sets.add(name, numbers)
        return
    if name.upper() in map(str.upper, deck.surfaces):
        raise block.error(f"surface {name!r} is there already")
    faces = {}
    for row, words in block.fields():
        if len(words) != 2:
            raise block.error(f"wanted an element or element set and one face such as S1, found {block.lines[row]!r}", row)
        members = _numbers(block, row, words[:1], element_sets)
        _are_elements(block, row, members, elements)
        for member in members.tolist():
            cell, place = elements[member]
            known = cell.faces if cell else {}
            if words[1].upper() not in known:
                raise block.error(f"element {member} has no face {words[1]}; its faces are {', '.join(known) or 'none'}", row)
            columns = list(known[words[1].upper()])
            faces.setdefault(len(columns), []).append(deck.cells[cell.name][place, columns])
    if not faces:
        raise block.error(f"surface {name!r} has no faces")
    deck.surfaces[name] = [np.array(faces[k]) for k in sorted(faces)]


def entries(deck, block, node_sets, step):
    """An Entry for each line of *CLOAD (node or set, direction, force) or *BOUNDARY (node or set, first, last direction)."""
    load = block.keyword == "CLOAD"
    for row, words in block.fields():
        if len(words) < (3 if load else 2):
            raise block.error(f"wanted node or set, direction{' and force' if load else ''}, found {block.lines[row]!r}", row)
        rows = _in_mesh(deck, block, row, _numbers(block, row, words[:1], node_sets))
        if not load and words[1].upper() in ABAQUS_HOLDS:
            first, last = ABAQUS_HOLDS[words[1].upper()]
        else:
            first = block.number(row, words[1], int)
            last = block.number(row, words[2], int) if not load and len(words) > 2 and words[2] else first
        if not load and len(words) > 3 and words[3] and block.number(row, words[3]):
            deck.other_loads.append(f"*BOUNDARY with a displacement other than zero ({block.where(row)})")
        yield Entry(rows, first, last, block.number(row, words[2]) if load else 0.0, step, block.where(row), is_anew(block))


def is_anew(block):
    """Whether a card of loads ends those of earlier steps."""
    return block.parameters.get("OP", "MOD").upper() == "NEW"


def members_of(block, row, word, element_sets, elements):
    """Element numbers that a word names, known to be in the mesh."""
    members = _numbers(block, row, [word], element_sets)
    _are_elements(block, row, members, elements)
    return members


def _numbers(block, row, words, sets):
    """The numbers that a data line names: numbers, names of sets, or with GENERATE first, last, step."""
    if "GENERATE" in block.parameters:
        first, last, step = [block.number(row, word, int) for word in (*words, "1")[:3]] if len(words) in (2, 3) else (1, 0, 1)
        if last < first or step < 1:
            raise block.error(f"wanted first, last and step of the numbers to generate, found {block.lines[row]!r}", row)
        if (last - first) // step > MOST:
            raise block.error(f"wanted at most {MOST} numbers, found {block.lines[row]!r}", row)
        return np.arange(first, last + 1, step)
    parts = [[block.number(row, word, int)] if word.isdecimal() else _named(block, row, word.strip('"'), sets) for word in words if word]
    return np.concatenate(parts).astype(np.int64) if parts else np.zeros(0, dtype=np.int64)


def _named(block, row, name, sets):
    members = sets.get(name)
    if members is None:
        known = ", ".join(spelled for spelled, _ in sets.items()) or "none"
        raise block.error(f"there is no {sets.kind} {name!r} above; there are: {known[:200]}", row)
    return members


def _in_mesh(deck, block, row, numbers):
    rows = deck.rows_of(numbers)
    if (rows < 0).any():
        raise block.error(f"node {numbers[rows < 0][0]} is not in the mesh", row)
    return rows


def _are_elements(block, row, numbers, elements):
    for number in numbers.tolist():
        if number not in elements:
            raise block.error(f"element {number} is not in the mesh", row)
