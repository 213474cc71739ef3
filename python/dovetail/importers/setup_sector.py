"""[cyclic] of the set-up file, and what the deck says about the sector."""

import numpy as np

from ..cyclic import angle_between, unit

KEYS = {"sectors", "left", "right", "axis", "origin", "tolerance"}
HALF_A_TURN = np.pi - 1e-6  # with two sectors either side is left
NEEDED = ("sectors", "left", "right", "axis")


def made(structure, table, find, vector, notes):
    """The structure as a sector, where the set-up file (`table`, or None) or the deck make it one.

    find(structure, name) spells the name of a set; vector(table, key) is three numbers.
    """
    deck = structure.sector_of_deck
    if table is None and deck is not None and deck.missing:
        notes.append(f"NOT taken: the cyclic symmetry of {deck.where}, which leaves open {', '.join(deck.missing)}; [cyclic] in the set-up "
                     "file gives the rest")
        return structure
    if table is None and deck is None:
        return structure
    given = dict(table or {})
    for key in ("left", "right"):
        if key in given:
            given[key] = _sets(structure, given[key], key, find)
    for key in {"axis", "origin"} & set(given):
        given[key] = vector(given, key)
    if deck is not None:
        if "axis" not in given and deck.axis is not None:
            given = {"origin": deck.origin, **given, "axis": deck.axis}
        if "sectors" not in given and deck.sectors is not None:
            given["sectors"] = deck.sectors
        if not {"left", "right"} & set(given) and deck.pairs and "axis" in given:
            given["left"], given["right"] = _ordered(structure, deck.pairs, given)
    missing = [key for key in NEEDED if key not in given]
    if missing:
        also = f" and {deck.where}" if deck is not None else ""
        raise ValueError(f"wanted {', '.join(NEEDED)}, found in the set-up file{also}: {', '.join(sorted(given)) or 'none'}")
    structure = structure.cyclic(**{key: given[key] for key in sorted(given)})
    notes.append(structure.cyclic_sector.report(structure.units) + (f" ({deck.where})" if deck is not None else ""))
    return structure


def _sets(structure, value, key, find):
    names = value if isinstance(value, list) else [value]
    if not names or not all(isinstance(name, str) for name in names):
        raise ValueError(f"{key} must be the name of a set, or a list of names, found {value!r}")
    names = [find(structure, name) for name in names]
    return names if isinstance(value, list) else names[0]


def _ordered(structure, pairs, given):
    """Names of the left and of the right sides: right is left turned in the positive sense."""
    axis, origin, sides = unit(given["axis"]), np.asarray(given.get("origin", (0, 0, 0)), dtype=float), []
    for pair in pairs:
        points = [structure.nodes[np.unique(structure._nodes(find))] for find in pair]
        angle = angle_between(points, axis, origin)
        sides.append(pair if angle >= 0 or angle < -HALF_A_TURN else pair[::-1])
    left, right = (list(names) for names in zip(*sides))
    return (left, right) if len(pairs) > 1 else (left[0], right[0])
