"""Changed parameters of a case: what `range` varies and what `fit` looks for, as keys of the case file."""

import copy
import math
from dataclasses import dataclass

import numpy as np

FRICTION = ("friction", "tangential_stiffness")  # of points with friction alone; a pair for t1 and t2
CONTACT = (*FRICTION, *(f"{name}_{direction}" for name in FRICTION for direction in (1, 2)), "normal_stiffness", "gap")
FACTORS = ("force", "damping", "preload")  # of everything in [excitation] and [damping], and of P
NAMES = (*CONTACT, *FACTORS)
DAMPING = ("stiffness", "mass", "structural", "ratios")


def split(name):
    """Key of [contact] and the directions, an index into its pairs: ("friction", slice(1, 2)) of "friction_2"."""
    key, _, direction = name.rpartition("_")
    return (key, slice(int(direction) - 1, int(direction))) if direction in ("1", "2") else (name, slice(None))


def read_number(name, word):
    """(kind, number) of a word: "0.3", a value; "0.5x", a factor; of the gap "1e-5", an offset."""
    factor = word.endswith("x")
    kind = "factor" if factor else "offset" if name == "gap" else "value"
    try:
        number = float(word.removesuffix("x"))
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f"--{name} {word}: wanted is a number, or a factor such as 0.5x")
    if name == "gap" and factor:
        raise ValueError(f"--gap {word}: of the gap, which may be 0, offsets are wanted, as 1e-5")
    if name in FACTORS and not factor:
        raise ValueError(f"--{name} {word}: wanted are factors, such as 0.5x")
    if name != "gap" and number <= 0:
        raise ValueError(f"--{name} {word}: must be greater than 0")
    return kind, number


@dataclass(frozen=True)
class Range:
    """A parameter between two numbers. `kind` is "value", "factor" or "offset". `at` takes places xi from -1 to 1: even in
    the number, of a factor in its logarithm."""

    name: str
    kind: str
    low: float
    high: float

    @classmethod
    def read(cls, name, words):
        """From the two words behind an option."""
        words = [word.strip() for word in words]
        (kind, low), (other, high) = (read_number(name, word) for word in words)
        if kind != other:
            raise ValueError(f"--{name} {' '.join(words)}: wanted are two values, or two factors such as 0.5x 2x")
        if not low < high:
            raise ValueError(f"--{name} {' '.join(words)}: the first must be less than the second")
        return cls(name, kind, low, high)

    def at(self, xi):
        if self.kind == "factor":
            return self.low ** ((1 - xi) / 2) * self.high ** ((1 + xi) / 2)
        return self.low + (self.high - self.low) * (1 + xi) / 2

    @property
    def half(self):
        """What xi from 0 to 1 adds to the number, of a factor to its logarithm."""
        return (math.log(self.high / self.low) if self.kind == "factor" else self.high - self.low) / 2

    def __str__(self):
        kinds = {"value": "", "factor": " times what the case has, even in the logarithm", "offset": " added to what the case has"}
        return f"{self.name} {self.low:g} to {self.high:g}{kinds[self.kind]}"


def need(name, contact):
    """Refuses a parameter that the joint has not; `contact`: values in force, as `Results.contact`."""
    key, directions = split(name)
    rubs = contact["law"] <= 1
    if name in CONTACT and not len(rubs):
        raise ValueError(f"--{name}: the case has no contact point")
    if key in FRICTION and not rubs.any():
        raise ValueError(f"--{name}: no contact point of this case has friction")
    if key == "friction" and directions != slice(None) and np.any(contact["law"] == 1):
        raise ValueError(f'--{name}: a contact of law "cone" has one friction for both directions; vary "friction"')


def contact_values(contact, changes):
    """Changed values of [contact], by key: (N_x,) or (N_x, 2).

    Parameters
    ----------
    contact : dict
        Values in force, as `Results.contact`.
    changes : dict
        name -> (kind, number), or one number per contact point, (N_x,), NaN at points that are left as they are.
    """
    changed = {}
    for name, (kind, number) in changes.items():
        if name not in CONTACT:
            continue
        key, directions = split(name)
        values = changed.setdefault(key, np.array(contact[key], dtype=float))
        part = values[:, directions] if values.ndim == 2 else values
        numbers = np.broadcast_to(number, len(values)).astype(float)
        numbers = numbers[:, None] if values.ndim == 2 else numbers
        new = {"value": numbers + 0 * part, "factor": numbers * part, "offset": numbers + part}[kind]
        part[...] = np.where(np.isnan(numbers), part, new)
    for key in FRICTION:
        if key in changed:
            changed[key][contact["law"] > 1] = 1.0  # has no meaning there, and must be positive
    return changed


def apply(content, contact, changes):
    """A copy of a parsed case with changed parameters; arguments as for `contact_values`."""
    content = copy.deepcopy(content)
    for key, values in contact_values(contact, changes).items():
        section = content.setdefault("contact", {})
        section.pop(f"{key}_per_area", None)
        section[key] = values.flat[0].item() if np.ptp(values) == 0 else values.tolist()
    if "force" in changes:
        excitation = content["excitation"]
        for load in excitation.get("load", [excitation]):
            load["fourier"] = [changes["force"][1] * number for number in load["fourier"]]
    if "damping" in changes:
        section, factor = content.get("damping", {}), changes["damping"][1]
        for key in DAMPING:
            if key == "ratios" and key in section:
                section[key] = [[mode, factor * ratio] for mode, ratio in section[key]]
            elif key in section:
                section[key] *= factor
    return content


def without_model(content, contact, reduced):
    """A copy of a parsed case that starts from a reduced file in place of its model; `contact`: values in force."""
    content = {key: value for key, value in copy.deepcopy(content).items() if key not in ("model", "reduction", "output")}
    section = content.setdefault("contact", {})
    keys = ("normal_stiffness", "gap", *(FRICTION if np.any(contact["law"] <= 1) else ()))
    for key, values in contact_values(contact, dict.fromkeys(keys, ("offset", 0.0))).items():
        if key not in section:
            section.pop(f"{key}_per_area", None)
            section[key] = values.tolist()
    return content | {"reduced": reduced}


def need_damping(content):
    """Refuses a factor on a damping that is not there."""
    section = content.get("damping", {})
    if not any(section.get(key) for key in DAMPING):
        raise ValueError("--damping: the case has no stiffness, mass, structural or ratios in [damping] to be varied")
    if section.get("matrix"):
        raise ValueError("--damping: damping.matrix = true: the matrix of the model has no factor, so that all damping cannot be varied; "
                         "leave it out, or give the numbers in [damping] of their own")
