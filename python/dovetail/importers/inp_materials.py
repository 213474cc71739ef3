"""Materials of an input deck, and how its elements are integrated: what stresses are computed from."""

import re

import numpy as np

from .. import solids
from ..material import UNKNOWN, Material

SPECIAL = ((re.compile(r"C3D8I[A-Z]*"), solids.INCOMPATIBLE), (re.compile(r"C3D8R[A-Z]*"), solids.REDUCED),
           (re.compile(r"C3D20(?!R)[A-Z]*"), solids.FULL))  # others, C3D20R among them, are integrated as usual


def integration_of(element_type):
    """A number of solids.INTEGRATION for an element type such as "C3D8I"."""
    return next((how for pattern, how in SPECIAL if pattern.fullmatch(element_type)), solids.USUAL)


def take_materials(deck, blocks, element_sets, elements):
    """Fills materials, material and not_materials of a Deck.

    element_sets : inp_sets.Sets; elements : dict of element number to (Cell, row), as `inp` has them
    """
    found = _materials(deck, blocks)
    deck.materials = list(found.values())
    number = {name: i for i, name in enumerate(found)}
    deck.material = {kind: np.full(len(rows), UNKNOWN) for kind, rows in deck.cells.items()}
    for block in blocks:
        if block.keyword != "SOLID SECTION":
            continue
        mine = number.get(block.parameters.get("MATERIAL", "").upper(), UNKNOWN)
        members = element_sets.get(block.parameters.get("ELSET", ""))
        for member in [] if members is None else members.tolist():
            cell, row = elements.get(member, (None, UNKNOWN))
            if cell is not None:
                deck.material[cell.name][row] = mine


def _materials(deck, blocks):
    """Dict of the name in upper case to Material, of those that are linear, isotropic and alike at all temperatures."""
    cards, name = {}, None
    for block in blocks:
        if block.keyword == "MATERIAL":
            name = block.parameters.get("NAME", "")
            cards.setdefault(name.upper(), (name, {}))
        elif block.keyword in ("ELASTIC", "DENSITY") and name is not None:
            cards[name.upper()][1][block.keyword] = block
    found = {}
    for key, (name, of_it) in cards.items():
        elastic, density = of_it.get("ELASTIC"), of_it.get("DENSITY")
        plain = elastic is not None and elastic.parameters.get("TYPE", "ISO").upper() in ("ISO", "ISOTROPIC") and len(elastic.lines) == 1
        if not plain:
            deck.not_materials.append(f"{name} ({(elastic or _card(blocks, key)).where()})")
            continue
        words = next(elastic.fields())[1]
        young, poisson = (elastic.number(0, word) for word in (*words, "0", "0")[:2])
        mass = 0.0 if density is None or not density.lines else density.number(0, next(density.fields())[1][0])
        try:
            found[key] = Material(young, poisson, mass, name)
        except ValueError as error:
            raise elastic.error(str(error), 0) from None
    return found


def _card(blocks, key):
    return next(block for block in blocks if block.keyword == "MATERIAL" and block.parameters.get("NAME", "").upper() == key)
