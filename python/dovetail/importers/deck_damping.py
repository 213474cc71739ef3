"""Damping of a deck: *DAMPING, where it is the same for all materials, as keys of the case file."""

import math

RAYLEIGH = ("ALPHA", "BETA")
KEYS = {"ALPHA": "mass", "BETA": "stiffness", "STRUCTURAL": "structural"}  # of [damping]
OTHERS = ("MODAL DAMPING", "GLOBAL DAMPING", "DASHPOT")
CARDS = ("DAMPING", *OTHERS)


class DeckDamping:
    """What the blocks of a deck say of damping, in their order.

    taken: dict of keys of [damping], those of the whole model; named: cards that are left out, with their parameters and places.
    `rayleigh_of_all`: ALPHA and BETA are of the whole deck, each as the last card has it.
    """

    def __init__(self, rayleigh_of_all):
        self.rayleigh_of_all = rayleigh_of_all
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
        if any(block.lines or not set(block.parameters) <= set(KEYS) for block, _ in self.cards):
            taken, named = {}, [in_words(block) for block, _ in self.cards]
        elif self.rayleigh_of_all:
            last, overruled = self._last()
            same, named = self._same([card for card in self.cards if card[0].parameters.get("STRUCTURAL")], ["STRUCTURAL"])
            taken, named = last | same, overruled + named
        else:
            taken, named = self._same(self.cards, KEYS)
        return {key: value for key, value in taken.items() if value != 0}, named + self.named

    @staticmethod
    def _values(block, names):
        return {KEYS[name]: _number(block, name) for name in names if block.parameters.get(name)}

    def _last(self):
        """(taken, named): ALPHA and BETA of the last cards that have them."""
        values = [self._values(block, RAYLEIGH) for block, _ in self.cards]
        taken = {key: value for found in values for key, value in found.items()}
        return taken, [f"{in_words(block)}, as CalculiX takes the last such card for all materials"
                       for (block, _), found in zip(self.cards, values) if found != {key: taken[key] for key in found}]

    def _same(self, cards, names):
        """(taken, named): what all materials have alike, or nothing."""
        values = [{key: value for key, value in self._values(block, names).items() if value != 0} for block, _ in cards]
        every = sorted(material for _, material in cards) == list(range(1, self.materials + 1))
        if cards and every and all(found == values[0] for found in values):
            return values[0], []
        return {}, [in_words(block) for block, _ in cards]


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
        notes.append(f"*DAMPING of all materials: {lines} under [damping]; a case.toml written here has it")
    if named:
        notes.append(f"NOT taken: {'; '.join(named)}. In the case file, for the whole model: damping.mass is ALPHA, "
                     "damping.stiffness BETA, damping.structural the structural factor; for parts of it a matrix /C of the model "
                     "(with_damping_matrix) and damping.matrix")
    return notes
