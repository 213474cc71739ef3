"""Cyclic symmetry as a deck states it: which sets are the sides of a sector, how many sectors, about which axis."""

import re
from dataclasses import dataclass, field

import numpy as np

EDGE = re.compile(r"CYCLIC_([MU]\d+)([LH])", re.IGNORECASE)  # components of ANSYS: low and high edge, matched or unmatched
JOINED = "CYJOIN {}"  # node set of a side, as Nastran's cards have none


@dataclass
class DeckSector:
    """pairs: names of the two sides, which of them is left not being known; where: place of the card.

    sectors, axis, origin: None where the deck does not say.
    """

    where: str
    pairs: list = field(default_factory=list)
    sectors: int = None
    axis: np.ndarray = None
    origin: np.ndarray = None

    @property
    def missing(self):
        """Keys of [cyclic] that the deck leaves open."""
        return ["left", "right"] * (not self.pairs) + ["sectors"] * (self.sectors is None) + ["axis"] * (self.axis is None)


def of_blocks(deck, blocks):
    """The DeckSector of *TIE, CYCLIC SYMMETRY and *CYCLIC SYMMETRY MODEL, or None."""
    models = [block for block in blocks if block.keyword == "CYCLIC SYMMETRY MODEL"]
    ties = [block for block in blocks if block.keyword == "TIE" and "CYCLIC SYMMETRY" in block.parameters]
    if len(models) > 1:
        raise models[1].error("several sectors are not read; leave one")
    if not models and not ties:
        return None
    found = DeckSector(f"*{(models or ties)[0].keyword} ({(models or ties)[0].where()})")
    if models:
        model = models[0]
        found.sectors = model.number(None, model.needed("N"), int)
        words = [model.number(row, word) for row, line in model.fields() for word in line if word]
        if len(words) != 6:
            raise model.error(f"wanted two points of the axis, six numbers, found {len(words)}")
        found.origin, end = np.array(words).reshape(2, 3)
        found.axis = end - found.origin
        name = model.parameters.get("TIE")
        ties = [tie for tie in ties if not name or tie.parameters.get("NAME", "").upper() == name.upper()]
        if name and not ties:
            raise model.error(f"there is no *TIE, CYCLIC SYMMETRY, NAME={name}")
    for tie in ties:
        for row, words in tie.fields():
            if len(words) < 2:
                raise tie.error(f"wanted two surfaces, found {tie.lines[row]!r}", row)
            found.pairs.append(tuple(_spelled(deck, tie, row, word.strip('"')) for word in words[:2]))
    return found


def _spelled(deck, block, row, name):
    known = {other.upper(): other for other in (*deck.node_sets, *deck.surfaces)}
    if name.upper() not in known:
        raise block.error(f"there is no surface {name!r}; there are: {', '.join(known.values()) or 'none'}", row)
    return known[name.upper()]


def of_components(node_sets, path):
    """The DeckSector of components such as CYCLIC_M01L and CYCLIC_M01H, or None."""
    edges = {}
    for name in node_sets:
        if match := EDGE.fullmatch(name):
            edges.setdefault(match[1].upper(), {})[match[2].upper()] = name
    pairs = [(sides["L"], sides["H"]) for sides in edges.values() if len(sides) == 2]
    return DeckSector(f"components {', '.join(' and '.join(pair) for pair in pairs)} of {path}", pairs) if pairs else None


def of_cyjoin(model, deck):
    """The DeckSector of CYJOIN, CYSYM and CYAX in a pyNastran model, or None; both sides become node sets of the deck."""
    sides = {side: np.asarray([grid for grid in card.nids if not isinstance(grid, str)]) for side, card in model.cyjoin.items()}
    if not {1, 2} <= set(sides):
        return None
    found = DeckSector(f"CYJOIN of {deck.path}", [tuple(JOINED.format(side) for side in (1, 2))])
    for side in (1, 2):
        deck.node_sets[JOINED.format(side)] = _rows(deck, sides[side], f"CYJOIN {side}")
    for lines in model.reject_lines:
        for line in lines:
            words = line.split(",") if "," in line else [line[i:i + 8] for i in range(0, len(line), 8)]
            if len(words) > 1 and words[0].strip().upper() == "CYSYM" and words[1].strip().isdecimal():
                found.sectors = int(words[1])
    if model.cyax is not None:
        rows = _rows(deck, np.asarray([grid for grid in model.cyax.nids if not isinstance(grid, str)]), "CYAX")
        ends = deck.nodes[rows]
        far = ends[np.argmax(np.linalg.norm(ends - ends[0], axis=1))]
        if np.any(far != ends[0]):
            found.origin, found.axis = ends[0], far - ends[0]
    return found


def _rows(deck, grids, card):
    rows = deck.rows_of(grids)
    if (rows < 0).any():
        raise ValueError(f"{deck.path}: grid point {grids[rows < 0][0]} of {card} is not there")
    return rows


def need_plain(deck, tied, source):
    """The nodes of both sides must be unknowns, or held: else the matrices have the constraint between them in."""
    for name in {name for pair in (deck.sector.pairs if deck.sector else ()) for name in pair}:
        rows = deck.node_sets[name] if name in deck.node_sets else np.unique(np.concatenate([f.ravel() for f in deck.surfaces[name]]))
        gone = rows[tied[rows]]
        if gone.size:
            raise ValueError(f"{source}: node {deck.labels[gone[0]]} of {name!r} is no unknown ({len(gone)} of {len(rows)} such nodes): "
                             f"the constraint of {deck.sector.where} is in the matrices; write those of the plain sector, without it")
