"""Distributed loads and equations of an input deck."""

import re
from dataclasses import dataclass

import numpy as np

from .inp_sets import is_anew, members_of

FACE = re.compile(r"P(\d)")


@dataclass
class Pressure:
    """A pressure onto element faces, against their outward normals; faces: key to node rows, corners first."""

    faces: dict
    value: float
    step: int
    where: str
    anew: bool
    card: str = "*DLOAD"


@dataclass
class Weight:
    """An acceleration (3,) of the elements of a set."""

    elements: np.ndarray
    vector: np.ndarray
    step: int
    where: str
    anew: bool
    card: str = "*DLOAD, GRAV"


@dataclass
class Equation:
    """sum of coefficient times displacement is zero; terms: (node row, direction from 0, coefficient)."""

    terms: list
    where: str


def distributed(deck, block, element_sets, elements, step):
    """A load for each line of *DLOAD or *DSLOAD; what is neither a pressure nor a weight goes into deck.other_loads."""
    for row, words in block.fields():
        if len(words) < 3:
            raise block.error(f"wanted {'surface' if block.keyword == 'DSLOAD' else 'element or set'}, kind and value, found "
                              f"{block.lines[row]!r}", row)
        kind, where = words[1].upper(), block.where(row)
        if block.keyword == "DSLOAD" and kind == "P":
            yield Pressure(_faces_of_surface(deck, block, row, words[0]), block.number(row, words[2]), step, where, is_anew(block))
        elif block.keyword == "DLOAD" and (face := FACE.fullmatch(kind)):
            faces = _faces(deck, block, row, members_of(block, row, words[0], element_sets, elements), f"S{face[1]}", elements)
            yield Pressure(faces, block.number(row, words[2]), step, where, is_anew(block))
        elif block.keyword == "DLOAD" and kind == "GRAV" and len(words) > 5:
            size, *along = (block.number(row, word) for word in words[2:6])
            if not np.any(along):
                raise block.error("wanted a direction other than zero", row)
            yield Weight(members_of(block, row, words[0], element_sets, elements), size * np.array(along) / np.linalg.norm(along), step,
                         where, is_anew(block))
        else:
            deck.other_loads.append(f"*{block.keyword} with {kind} ({where})")


def _faces(deck, block, row, members, name, elements):
    faces = {}
    for member in members.tolist():
        cell, place = elements[member]
        if cell is None or name not in cell.faces:
            raise block.error(f"element {member} has no face {name[1:]}; its faces are {', '.join(cell.faces) if cell else 'none'}", row)
        faces[member, name] = deck.cells[cell.name][place, list(cell.faces[name])]
    return faces


def _faces_of_surface(deck, block, row, name):
    known = {spelled.upper(): spelled for spelled in deck.surfaces}
    if name.upper() not in known:
        raise block.error(f"there is no surface {name!r} of element faces above; there are: {', '.join(deck.surfaces) or 'none'}", row)
    groups = deck.surfaces[known[name.upper()]]
    return {(name.upper(), k, i): nodes for k, group in enumerate(groups) for i, nodes in enumerate(group)}


def equations(deck, block):
    """An Equation for each of *EQUATION: the number of its terms, then node, direction, coefficient of each.

    One with sets in place of nodes is left out: its nodes go on to be tied in a way that is not known.
    """
    lines, row = list(block.fields()), 0
    while row < len(lines):
        place, words = lines[row]
        count, terms = block.number(place, words[0] if words else "", int), []
        row += 1
        while len(terms) < 3 * count and row < len(lines):
            terms += lines[row][1]
            row += 1
        if count < 1 or len(terms) != 3 * count:
            raise block.error(f"wanted {count} terms of node, direction and coefficient, found {len(terms)} words", place)
        if not all(word.isdecimal() for word in terms[::3]):
            continue
        labels = np.array([block.number(place, word, int) for word in terms[::3]])
        rows = deck.rows_of(labels)
        if (rows < 0).any():
            continue
        directions = [block.number(place, word, int) - 1 for word in terms[1::3]]
        if not all(0 <= direction < 6 for direction in directions):
            raise block.error(f"wanted directions from 1 to 6, found {[d + 1 for d in directions]}", place)
        coefficients = [block.number(place, word) for word in terms[2::3]]
        if coefficients[0] == 0:
            raise block.error("the first coefficient must not be zero", place)
        yield Equation(list(zip(rows.tolist(), directions, coefficients)), block.where(place))
