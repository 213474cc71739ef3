"""Damping of a deck: *DAMPING of materials, where it is the same for all of them, as keys of the case file."""

import math

KEYS = {"ALPHA": "mass", "BETA": "stiffness", "STRUCTURAL": "structural"}  # of [damping]
OTHERS = ("MODAL DAMPING", "GLOBAL DAMPING", "DASHPOT")
CARDS = ("DAMPING", *OTHERS)


class DeckDamping:
    """What the blocks of a deck say of damping, in their order.

    taken: dict of keys of [damping], those of the whole model; named: cards that are left out, with their parameters and places.
    """

    def __init__(self):
        self.materials = 0
        self.cards = []  # (block, material's number or 0)
        self.named = []

    def see(self, block):
        if block.keyword == "MATERIAL":
            self.materials += 1
        elif block.keyword in OTHERS:
            self.named.append(in_words(block))
        elif block.keyword == "DAMPING":
            self.cards.append((block, self.materials))

    def close(self):
        """(taken, named) of all that was seen."""
        values = [{KEYS[name]: _number(block, name) for name in KEYS if block.parameters.get(name)} for block, _ in self.cards]
        values = [{key: value for key, value in found.items() if value != 0} for found in values]
        every = sorted(material for _, material in self.cards) == list(range(1, self.materials + 1))
        plain = all(set(block.parameters) <= set(KEYS) and not block.lines for block, _ in self.cards)
        if self.cards and every and plain and all(found == values[0] for found in values):
            return values[0], self.named
        return {}, [in_words(block) for block, _ in self.cards] + self.named


def _number(block, name):
    try:
        value = float(block.parameters[name].upper().replace("D", "E"))
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0):
        raise block.error(f"wanted {name} not below zero, found {block.parameters[name]}")
    return value


def in_words(block):
    words = [name + (f"={value}" if value else "") for name, value in block.parameters.items()]
    return f"{', '.join(['*' + block.keyword, *words])} ({block.where()})"


def notes_of(taken, named):
    """What is said of it when importing."""
    notes = []
    if taken:
        lines = "; ".join(f"{key} = {value:g}" for key, value in taken.items())
        notes.append(f"*DAMPING, the same of all materials: {lines} under [damping]; a case.toml written here has it")
    if named:
        notes.append(f"NOT taken: {'; '.join(named)}. In the case file, for the whole model: damping.mass is ALPHA, "
                     "damping.stiffness BETA, damping.structural the structural factor; for parts of it a matrix /C of the model "
                     "(with_damping_matrix) and damping.matrix")
    return notes
