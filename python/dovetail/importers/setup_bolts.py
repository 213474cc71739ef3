"""[[bolt]] of the set-up file: its unit pull goes through the joints like a load pattern, then it is tightened."""

import copy
import math

import numpy as np

from ..bolts import Bolt, tightened as tightened_model

PULL = "bolt {} (unit pull)"  # name of the pattern for the time until all joints are made


def pulled(structure, number, table, find):
    """The structure with the unit pull of a bolt among its load patterns; `find(structure, name)` spells the name of a set."""
    pair = table.get("between")
    if not isinstance(pair, list) or len(pair) != 2 or not all(isinstance(name, str) for name in pair):
        raise ValueError(f'between must be two names, such as ["HEAD", "NUT"], found {pair!r}')
    _number(table, "force")
    _number(table, "stiffness", needed=False)
    if table.get("then", "keep") not in ("keep", "lock"):
        raise ValueError(f'then must be "keep", which keeps the force, or "lock", which keeps the length, found {table["then"]!r}')
    if "stiffness" in table and table.get("then") != "lock":
        raise ValueError('stiffness is that of a bolt with then = "lock"')
    if not isinstance(table.get("tighten_with_friction", True), bool):
        raise ValueError(f"tighten_with_friction must be true or false, found {table['tighten_with_friction']!r}")
    ends = [find(structure, name, tied=True) for name in pair]
    axis = _axis(structure, ends, table)
    plain = copy.copy(structure)
    plain.force = np.zeros(structure.n)
    pull = plain.with_force(ends[0], axis).with_force(ends[1], -axis).force
    result = copy.copy(structure)
    result.forces = {**structure.forces, PULL.format(number): pull}
    return result


def tightened(model, bolts, notes):
    """The model with its bolts ((number, table) of each) tightened; says what was done in `notes`."""
    if not bolts:
        return model
    forces = dict(model.forces)
    pulls = [forces.pop(PULL.format(number)) for number, _ in bolts]
    model = model.with_loads(forces=forces)
    if model.force is None and not forces:
        model = model.with_loads(force=np.zeros(model.n))
    ways = {table.get("tighten_with_friction", True) for _, table in bolts}
    if len(ways) > 1:
        raise ValueError("[[bolt]]: tighten_with_friction must be the same for all bolts, which are tightened together")
    made = [Bolt(str(table.get("name", number)), pull, float(table["force"]), table.get("then") == "lock", table.get("stiffness"))
            for (number, table), pull in zip(bolts, pulls)]
    try:
        model, said = tightened_model(model, made, ways.pop())
    except ValueError as error:
        raise ValueError(f"[[bolt]]: {error}") from None
    notes += said
    return model


def _axis(structure, ends, table):
    """Unit vector from the first end to the second."""
    if "axis" in table:
        axis = table["axis"]
        finite = isinstance(axis, list) and len(axis) == 3 and all(type(v) in (int, float) and math.isfinite(v) for v in axis)
        if not finite or not any(axis):
            raise ValueError(f"axis must be three finite numbers, not all zero, from the first set towards the second, found {axis!r}")
        axis = np.array(axis, dtype=float)
    else:
        middle = [structure.nodes[structure._loaded_rows(name, "bolt")].mean(axis=0) for name in ends]
        axis = middle[1] - middle[0]
        if np.linalg.norm(axis) <= 1e-9 * np.ptp(structure.nodes, axis=0).max():
            raise ValueError("both ends have the same middle; give axis, from the first set towards the second when they are pulled")
    return axis / np.linalg.norm(axis)


def _number(table, key, needed=True):
    value = table.get(key)
    if value is None and not needed:
        return
    if type(value) not in (int, float) or not math.isfinite(value) or value <= 0:
        raise ValueError(f"{key} must be a positive number, found {value!r}")
