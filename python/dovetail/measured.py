"""A measured response curve or backbone: columns of a text file, whose header says units."""

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .units import SIZES

FREQUENCIES = {"Hz": 1.0, "kHz": 1e3}  # in Hz
RATIOS = {"-": 1.0, "%": 0.01}
NAMED = r"([^,;\t\[\]]+?)\s*\[([^\]]*)\]"  # a name and its unit
HEADER = 'a header such as "frequency [Hz], amplitude [mm]"'
OF_BACKBONE = 'a header such as "amplitude [mm], frequency [Hz], damping [%]", where one of the last two may be missing'


@dataclass(frozen=True)
class Measured:
    """omega (m,) in rad per unit of time of the model, rising; amplitude (m,) in its unit of length."""

    omega: np.ndarray
    amplitude: np.ndarray


@dataclass(frozen=True)
class MeasuredBackbone:
    """amplitude (m,) in the unit of length of the model, rising.

    quantities : `omega` (m,) in rad per unit of time of the model, `damping_ratio` (m,), or one of them
    hertz : whether frequencies were given in Hz
    """

    amplitude: np.ndarray
    quantities: dict
    hertz: bool


def read_measured(path, unit):
    """The Measured of a file; unit: `Results.unit` of the model. Raises ValueError where it is not what is wanted."""
    (number, head), lines = _lines(path, HEADER)
    columns = _columns(head)
    if columns and _is_length(columns[0][1]):
        raise ValueError(f"{path}:{number}: begins with an amplitude, as a measured backbone does: that wants a case with [mode]; of a "
                         f"response curve, wanted is {HEADER}")
    if len(columns) != 2:
        raise ValueError(f"{path}:{number}: found {head!r}; wanted is {HEADER}")
    rows = _rows(path, lines, 2, "a frequency and an amplitude, both")
    frequency, amplitude = np.array(sorted(rows)).T
    if np.any(np.diff(frequency) == 0):
        again = frequency[:-1][np.diff(frequency) == 0][0]
        raise ValueError(f"{path}: frequency {again:g} is there twice; one amplitude for each is wanted")
    (first, in_unit), (_, length) = columns
    return Measured(_omega(path, frequency, first, in_unit, unit), amplitude * _length(path, length, unit))


def read_backbone(path, unit):
    """The MeasuredBackbone of a file; unit as for `read_measured`. An amplitude may come again, as from another test."""
    (number, head), lines = _lines(path, OF_BACKBONE)
    columns = _columns(head)
    frequencies = (*FREQUENCIES, "rad/s", unit.omega)
    if columns and columns[0][1] in frequencies:
        raise ValueError(f"{path}:{number}: begins with a frequency, as a measured response curve does: that wants a case without "
                         f"[mode]; of a backbone, wanted is {OF_BACKBONE}")
    names = ["damping_ratio" if in_unit in RATIOS else "omega" for _, in_unit in columns[1:]]
    if sorted(names) not in (["omega"], ["damping_ratio"], ["damping_ratio", "omega"]):
        raise ValueError(f"{path}:{number}: found {head!r}; wanted is {OF_BACKBONE}")
    size = _length(path, columns[0][1], unit)
    if wrong := [f"{word} [{in_unit}]" for word, in_unit in columns[1:] if in_unit not in (*frequencies, *RATIOS)]:
        raise ValueError(f"{path}:{number}: {wrong[0]}: wanted is a frequency in {_frequencies(unit)}, or a damping ratio in "
                         f"{', '.join(RATIOS)}")
    amplitude, *others = np.array(sorted(_rows(path, lines, len(columns), "an amplitude and what was measured there, all"))).T
    if amplitude[0] == amplitude[-1]:
        raise ValueError(f"{path}: has one amplitude, {amplitude[0]:g}; a backbone wants two or more")
    found = {name: values * RATIOS[in_unit] if name == "damping_ratio" else _omega(path, values, word, in_unit, unit)
             for name, values, (word, in_unit) in zip(names, others, columns[1:])}
    if "damping_ratio" in found and (most := found["damping_ratio"].max()) >= 1:
        raise ValueError(f"{path}: a damping ratio of {most:g}; wanted are ratios below 1, in [-] or [%]")
    return MeasuredBackbone(amplitude * size, {name: found[name] for name in ("omega", "damping_ratio") if name in found},
                            any(in_unit in FREQUENCIES for _, in_unit in columns[1:]))


def _lines(path, wanted):
    """The first line and the others, each (number, text), without remarks."""
    lines = [(number, line.strip()) for number, line in enumerate(Path(path).read_text(encoding="utf-8-sig").splitlines(), 1)]
    lines = [(number, line) for number, line in lines if line and not line.startswith("#")]
    if not lines:
        raise ValueError(f"{path}: is empty; wanted is {wanted}, and a line for each that was measured")
    return lines[0], lines[1:]


def _columns(head):
    """(name, unit) of each column of a header; none where it is no header."""
    found = re.fullmatch(rf"{NAMED}(?:\s*[,;]?\s*{NAMED})*", head)
    return [(name.strip(), unit.strip()) for name, unit in re.findall(NAMED, head)] if found else []


def _rows(path, lines, count, what):
    rows = []
    for number, line in lines:
        try:
            rows.append([float(word) for word in re.split(r"\s*[,;]\s*|\s+", line)])
        except ValueError:
            rows.append([])
        if len(rows[-1]) != count or not all(math.isfinite(value) and value > 0 for value in rows[-1]):
            raise ValueError(f"{path}:{number}: found {line!r}; wanted are {what} greater than 0, with decimal points, and no further "
                             "column")
    if not rows:
        raise ValueError(f"{path}: has a header and no line behind it")
    return rows


def _omega(path, frequency, name, in_unit, unit):
    if in_unit in FREQUENCIES:
        return unit.from_hertz(FREQUENCIES[in_unit] * frequency)
    if in_unit == unit.omega:
        return frequency
    if in_unit == "rad/s":
        return frequency * unit.seconds
    raise ValueError(f"{path}: {name} [{in_unit}]: the unit of a frequency is one of {_frequencies(unit)}")


def _frequencies(unit):
    return ", ".join(dict.fromkeys([*FREQUENCIES, "rad/s", unit.omega]))


def _is_length(name):
    return name.replace("um", "µm") in SIZES["length"]


def _length(path, name, unit):
    name = name.replace("um", "µm")
    if not _is_length(name):
        raise ValueError(f"{path}: amplitude [{name}]: the unit of a displacement is wanted, one of {', '.join(SIZES['length'])}")
    if not unit.known:  # amplitudes are taken as they are
        return 1.0
    return SIZES["length"][name] / SIZES["length"][unit.length]
