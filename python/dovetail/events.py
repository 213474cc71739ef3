"""What happened along a branch: /events of a results file."""

from dataclasses import dataclass, fields

import numpy as np

from .hdf5_read import numbers, words

COLUMNS = {"kind": "i", "point": "i", "omega": "f", "amplitude": "f"}


@dataclass(frozen=True)
class Events:
    """What happened along the branch, in the order in which it did; (k,) arrays.

    kind : str
        Places, located: "fold" (turning point), "peak" (maximum of the watched amplitude), "branch" (another branch crosses),
        "stability" (lost or regained). How the run helped itself: "start", "cut", "corner", "harmonics", "leap",
        "integration". "missed": a frequency of continuation.at without solution. "outside": the curve leaves the sweep at its
        beginning, and the next point is where it comes back.
    point : int
        The point that is this place, or the last point before; -1 before the first.
    omega : rad/s, or rad per unit of time of the model
    amplitude : of the watched unknown, half its peak-to-peak; 0 where it is no place on the curve
    unknown : row in `coefficients` of the unknown that it is of; -1 where that is a node (`watch`), or there is none
    place : value of `Results.along` there
    """

    kind: np.ndarray
    point: np.ndarray
    omega: np.ndarray
    amplitude: np.ndarray
    unknown: np.ndarray
    place: np.ndarray

    def __len__(self):
        return len(self.kind)

    def of(self, *kinds):
        """Those of some kinds."""
        chosen = np.isin(self.kind, kinds)
        return Events(*(getattr(self, field.name)[chosen] for field in fields(self)))


def read_events(file, points, rows, over_parameter):
    """Those of an open results file with so many points, and rows in /points/coefficients. `over_parameter`: the branch is followed
    over another parameter than the frequency. Raises ValueError where numbers stand for nothing."""
    if "events" not in file:  # older files
        return Events(*(np.zeros(0, kind) for kind in (str, int, float, float, int, float)))
    columns = [numbers(file, f"events/{name}", (None,), kind) for name, kind in COLUMNS.items()]
    known = "events/unknown" in file  # older files do not say whose amplitudes they are
    columns.append(numbers(file, "events/unknown", (None,), "i") if known else np.full(len(columns[0]), -1))
    columns.append(numbers(file, "events/parameter", (None,)) if over_parameter else columns[2])
    kind, point, omega, amplitude, unknown, place = (column[:min(map(len, columns))] for column in columns)
    names = np.array(words(file["events/kind"], "names").split())
    if np.any((kind < 0) | (kind >= len(names))) or np.any(point < -1):
        raise ValueError("/events/kind must hold numbers of the attribute names, and /events/point numbers of points")
    if np.any((unknown < -1) | (unknown >= rows)):
        raise ValueError("/events/unknown must hold rows of /points/coefficients, or -1")
    known = point < points
    return Events(names[kind[known]], *(column[known] for column in (point, omega, amplitude, unknown, place)))
