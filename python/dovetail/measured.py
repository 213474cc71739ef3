"""A measured response curve: two columns of a text file, whose header says units."""

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .units import SIZES

FREQUENCIES = {"Hz": 1.0, "kHz": 1e3}  # in Hz
NAMED = r"([^,;\t\[\]]+?)\s*\[([^\]]*)\]"  # a name and its unit
HEADER = 'a header such as "frequency [Hz], amplitude [mm]"'


@dataclass(frozen=True)
class Measured:
    """omega (m,) in rad per unit of time of the model, rising; amplitude (m,) in its unit of length."""

    omega: np.ndarray
    amplitude: np.ndarray


def read_measured(path, unit):
    """The Measured of a file; unit: `Results.unit` of the model. Raises ValueError where it is not what is wanted."""
    lines = [(number, line.strip()) for number, line in enumerate(Path(path).read_text(encoding="utf-8-sig").splitlines(), 1)]
    lines = [(number, line) for number, line in lines if line and not line.startswith("#")]
    if not lines:
        raise ValueError(f"{path}: is empty; wanted is {HEADER}, and a line per frequency")
    names = re.fullmatch(rf"{NAMED}\s*[,;]?\s*{NAMED}", lines[0][1])
    if names is None:
        raise ValueError(f"{path}:{lines[0][0]}: found {lines[0][1]!r}; wanted is {HEADER}")
    first, in_unit, _, length = (text.strip() for text in names.groups())
    rows = []
    for number, line in lines[1:]:
        try:
            rows.append([float(word) for word in re.split(r"\s*[,;]\s*|\s+", line)])
        except ValueError:
            rows.append([])
        if len(rows[-1]) != 2 or not all(math.isfinite(value) and value > 0 for value in rows[-1]):
            raise ValueError(f"{path}:{number}: found {line!r}; wanted are a frequency and an amplitude, both greater than 0, "
                             "with decimal points, and no further column")
    if not rows:
        raise ValueError(f"{path}: has a header and no line behind it")
    frequency, amplitude = np.array(sorted(rows)).T
    if np.any(np.diff(frequency) == 0):
        again = frequency[:-1][np.diff(frequency) == 0][0]
        raise ValueError(f"{path}: frequency {again:g} is there twice; one amplitude for each is wanted")
    return Measured(_omega(path, frequency, first, in_unit, unit), amplitude * _length(path, length, unit))


def _omega(path, frequency, name, in_unit, unit):
    if in_unit in FREQUENCIES:
        return unit.from_hertz(FREQUENCIES[in_unit] * frequency)
    if in_unit == unit.omega:
        return frequency
    if in_unit == "rad/s":
        return frequency * unit.seconds
    raise ValueError(f"{path}: {name} [{in_unit}]: the unit of a frequency is one of {', '.join([*FREQUENCIES, 'rad/s', unit.omega])}")


def _length(path, name, unit):
    name = name.replace("um", "µm")
    if name not in SIZES["length"]:
        raise ValueError(f"{path}: amplitude [{name}]: the unit of a displacement is wanted, one of {', '.join(SIZES['length'])}")
    if not unit.known:  # amplitudes are taken as they are
        return 1.0
    return SIZES["length"][name] / SIZES["length"][unit.length]
