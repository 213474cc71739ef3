"""Units of a model from its label, such as "SI" or "t, mm, s, N". Nothing is converted: they are names of numbers.

The same in C++: src/support/units.cpp; both are tested by tests/units.txt.
"""

import math
import re
from dataclasses import dataclass

SIZES = {  # in kg, m, s, N, Pa
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "µm": 1e-6, "in": 0.0254, "ft": 0.3048},
    "mass": {"kg": 1.0, "g": 1e-3, "t": 1e3, "tonne": 1e3, "Mg": 1e3, "slug": 14.593902937206364},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6},
    "force": {"N": 1.0, "kN": 1e3, "MN": 1e6, "mN": 1e-3, "uN": 1e-6, "µN": 1e-6, "lbf": 4.4482216152605},
    "stress": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "psi": 6894.757293168361},
}
PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
MASSES = {1e-6: "mg", 1e-3: "g", 1.0: "kg", 1e3: "t"}
SAME = 1e-9  # relative


@dataclass(frozen=True)
class Units:
    """Names of units, empty where the label is not understood; angles are in rad, frequencies in Hz all the same.

    Attributes
    ----------
    length, mass, time, force, energy, stress, stiffness, area, modal : str
        Such as "mm", "t", "s", "N", "mJ", "MPa", "N/mm", "mm²", "mm √t".
    omega : str
        Of the excitation frequency: "rad/s" or "rad/ms"; "rad/s" where nothing is known.
    seconds : float
        Length of the unit of time [s].
    """

    length: str = ""
    mass: str = ""
    time: str = ""
    force: str = ""
    energy: str = ""
    stress: str = ""
    stiffness: str = ""
    area: str = ""
    modal: str = ""
    omega: str = "rad/s"
    seconds: float = 1.0

    @property
    def known(self):
        return bool(self.length)

    def hertz(self, omega):
        """Frequencies [Hz] of excitation frequencies in units of the model."""
        return omega / (2 * math.pi * self.seconds)

    def from_hertz(self, frequency):
        """Excitation frequencies in units of the model of frequencies [Hz]."""
        return frequency * (2 * math.pi * self.seconds)

    @property
    def work_per_area(self):
        return f"{self.energy}/{self.area}" if self.known else ""


def parse(label):
    """The Units of a label: names of units in any order, or "SI"; Units() where it is not understood, or does not fit together.

    Three of length, mass, time and force are enough, as force = mass length / time^2.
    """
    if label.strip().upper() == "SI":
        label = "kg, m, s, N"
    names, sizes = {}, {}
    for word in filter(None, re.split(r"[\s,;/-]+", label)):
        kind = next((kind for kind, known in SIZES.items() if word in known), None)
        if kind is None or kind in names:
            return Units()
        names[kind], sizes[kind] = word.replace("u", "µ") if word in ("um", "us", "uN") else word, SIZES[kind][word]
    derive = {"force": lambda L, M, T: M * L / T**2, "mass": lambda L, F, T: F * T**2 / L, "length": lambda F, M, T: F * T**2 / M,
              "time": lambda F, L, M: math.sqrt(M * L / F)}
    missing = [kind for kind in derive if kind not in names]
    if len(missing) > 1:
        return Units()
    for kind in missing:
        others = sorted((other for other in derive if other != kind), key="force length mass time".split().index)
        sizes[kind] = derive[kind](**{other[0].upper(): sizes[other] for other in others})
        names[kind] = _derived(kind, sizes[kind], names)
    fits = _same(sizes["force"], sizes["mass"] * sizes["length"] / sizes["time"] ** 2)
    stress = sizes["force"] / sizes["length"] ** 2
    if not fits or not names["length"] or not names["time"] or not _same(sizes.get("stress", stress), stress):
        return Units()
    length, mass, time, force = (names[kind] for kind in ("length", "mass", "time", "force"))
    return Units(length, mass, time, force, energy=_prefixed(sizes["force"] * sizes["length"], "J") or f"{force} {length}",
                 stress=_prefixed(stress, "Pa") or f"{force}/{length}²", stiffness=f"{force}/{length}", area=f"{length}²",
                 modal=f"{length} √{mass}" if " " not in mass else f"{length} √({mass})", omega=f"rad/{time}", seconds=sizes["time"])


def with_unit(number, unit):
    """A number as text, and its unit where there is one."""
    return f"{number} {unit}".rstrip()


def bracket(unit):
    """Behind the label of an axis: " [mm]", or nothing."""
    return f" [{unit}]" if unit else ""


def _same(a, b):
    return abs(a - b) <= SAME * max(abs(a), abs(b))


def _prefixed(size, base):
    power = round(math.log10(size))
    return PREFIXES[power] + base if power in PREFIXES and _same(size, 10.0**power) else ""


def _derived(kind, size, names):
    """A name for the one that the others give; empty for a length or a time without one."""
    if kind == "force":
        return _prefixed(size, "N") or f"{names['mass']} {names['length']}/{names['time']}²"
    if kind == "mass":
        found = next((name for known, name in MASSES.items() if _same(size, known)), None)
        return found or f"{names['force']} {names['time']}²/{names['length']}"
    return next((name for name, known in SIZES[kind].items() if _same(size, known)), "")
