"""What friction takes from a wheel: energy per period and sector, power of all sectors, shares of the joints."""

import numpy as np

from .hdf5_read import patiently
from .motion import find_joint
from .units import with_unit


def per_period(results):
    """(n,) energy that the contact points of a sector, or of a structure that is none, take in a period at every point of the branch."""
    if not results.has_activity:
        raise ValueError(f"{results.path}: has no /points/contact: it was written by an older version; run the case again")
    n = len(results)
    return patiently(results.path, lambda file: file["points/contact/dissipation"][:n]).sum(axis=1)


def by_joint(results, point):
    """Name of each joint to the energy that it takes in a period, of one sector. ValueError where the model is not there."""
    joint, taken = find_joint(results), results.contact_activity(point).dissipation
    return {name: float(taken[joint["joint"] == i].sum()) for i, name in enumerate(joint["names"])}


def in_words(results):
    """Where the curve dissipates most: energy of a sector and of the wheel, power of the wheel, joints."""
    energy, wave, unit = per_period(results), results.wave, results.unit
    point = int(np.argmax(energy))
    largest = max(float(energy[point]), 0.0)
    words = [f"at most {with_unit(f'{largest:.4g}', unit.energy)} per period and sector, at {results.place(results.along[point], 6)}",
             f"in {wave.sectors} sectors {with_unit(f'{wave.sectors * largest:.4g}', unit.energy)}"]
    if unit.energy == "J":
        words.append(f"power {wave.sectors * largest * results.frequency[point]:.4g} W")
    try:
        parts = by_joint(results, point)
    except ValueError:
        parts = {}
    if largest > 0 and len(parts) > 1:
        words.append(", ".join(f"{name} {100 * max(taken, 0) / largest:.3g} %" for name, taken in parts.items()))
    return "; ".join(words)
