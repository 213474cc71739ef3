"""The set-up file of `python3 -m dovetail import ... --setup joints.toml`: supports, loads and joints, by the names of sets.

    [[clamp]]
    set = "BOTTOM"

    [[force]]
    set = "TIP"
    vector = [0, 0, 1]

    [[joint]]
    between = ["UPPER", "LOWER"]
    normal_stiffness = 1e12
    tangential_stiffness = 1e12
    friction = 0.3

    units = "t, mm, s, N"    # before the first bracket; a label, nothing is converted; default SI
"""

import copy
import difflib
import sys
import tomllib
from contextlib import contextmanager

from ..joint import Joint
from . import echo, setup_bolts, setup_sector

KEYS = {
    "clamp": {"set", "directions"},
    "spring": {"set", "stiffness"},
    "material": {"set", "young", "poisson", "density", "name"},
    "force": {"set", "vector", "pattern", "phase"},
    "moment": {"set", "vector", "pattern", "phase"},
    "pressure": {"set", "value", "fourier", "pattern"},
    "base": {"direction", "pattern"},
    "preload": {"set", "vector", "step"},
    "gravity": {"vector"},
    "bolt": {"between", "force", "axis", "then", "stiffness", "tighten_with_friction", "name"},
    "joint": {"between", "ground", "normal_stiffness", "tangential_stiffness", "friction", "gap", "tolerance", "t1", "at", "normal",
              "name", "overlap", "next_sector"},
    "cyclic": setup_sector.KEYS,
}
BETWEEN_ONLY = {"tolerance", "overlap", "next_sector"}
TRUE_OR_FALSE = {"overlap", "next_sector"}
DEEPEST = 32  # brackets within brackets, as in a case file


def apply(structure, path):
    """The model of a structure with the supports, loads and joints of a set-up file.

    Parameters
    ----------
    structure : dovetail.Structure
    path : str or Path
        TOML. `set`, `between`, `ground` name node sets or surfaces of the structure, in upper or lower case; `at` may be a list of
        places [m] or the name of a node set; everything else of a joint is as in `Joint.between`.

    Returns
    -------
    dovetail.Model
        `notes` holds totals of the loads and the report of each joint.

    Raises
    ------
    ValueError
        Naming file and entry, for an unknown key or set, and for whatever Structure and Joint refuse. `notes` of it: as above, as far
        as it came.
    """
    notes = []
    try:
        model = _applied(structure, path, notes)
    except ValueError as error:
        error.notes = notes
        raise
    model.notes = notes
    return model


def _applied(structure, path, notes):
    entries, units, sector = _read(path)
    structure = copy.copy(structure)
    structure.units = structure.units if units is None else units
    joints = []
    whole = [entry for entry in entries if entry[0] in ("base", "gravity")]  # inertia of all masses, also beside what is clamped
    for kind, number, table in whole + [entry for entry in entries if entry not in whole]:
        with _named(f"{path}, [[{kind}]] number {number}"):
            if kind == "clamp":
                structure = structure.clamped(_set(structure, _text(table, "set")), _directions(table))
            elif kind == "spring":
                structure = structure.with_springs(_set(structure, _text(table, "set")), _vector(table, "stiffness"))
            elif kind == "material":
                structure = _with_material(structure, table)
            elif kind not in ("joint", "bolt"):
                structure = _loaded(structure, kind, table)
    if structure.held_by_deck and any(kind == "gravity" for kind, _, _ in entries):
        notes.append("CHECK: [[gravity]] has the weight beside nodes that the deck holds in part only, because the matrices have no more; "
                     "hold them with [[clamp]] in the set-up file instead")
    notes += echo.loads(structure)
    with _named(f"{path}, [cyclic]"):
        structure = setup_sector.made(structure, sector, _set, _vector, notes)
    notes += echo.supports(structure)
    bolts = [(number, table) for kind, number, table in entries if kind == "bolt"]
    for number, table in bolts:  # after all clamps, as joints are
        with _named(f"{path}, [[bolt]] number {number}"):
            structure = setup_bolts.pulled(structure, number, table, _set)
    for kind, number, table in entries:  # after all clamps, which renumber the degrees of freedom
        if kind == "joint":
            with _named(f"{path}, [[joint]] number {number}"):
                joints.append(_joint(structure, table))
                notes.append(joints[-1].report(structure.units))
    with _named(path):
        model = structure.join(joints)
        model = setup_bolts.tightened(model, bolts, notes)
    if model.forces:
        notes.append("load patterns, as they stand in a case file:\n" + model.excitation().rstrip())
    return model


@contextmanager
def _named(where):
    """Puts the place in front of what is refused."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def _read(path):
    """(kind, number from 1, table) of every entry, `units` and [cyclic]; every key is known and at least one joint is there."""
    try:
        with open(path, "rb") as stream:
            content = tomllib.load(stream)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: {error}") from None
    except RecursionError:
        content = None
    if content is None or _deeper(content, DEEPEST):
        raise ValueError(f"{path}: more than {DEEPEST} brackets within brackets, or parts of a dotted key; a joint needs 3 at most")
    units = content.pop("units", None)
    if not isinstance(units, (str, type(None))):
        raise ValueError(f'{path}: units must be text such as "t, mm, s, N", found {units!r}')
    sector = content.pop("cyclic", None)
    if not isinstance(sector, (dict, type(None))):
        raise ValueError(f"{path}: wanted [cyclic] in single brackets, once, found cyclic = {sector!r}")
    for key in sector or ():
        if key not in KEYS["cyclic"]:
            raise ValueError(f"{path}, [cyclic]: unknown key {key!r}; {_nearest(key, KEYS['cyclic'])}")
    entries = []
    for kind, tables in content.items():
        if kind not in KEYS:
            raise ValueError(f"{path}: unknown key {kind!r}; {_nearest(kind, [*KEYS, 'units'])}")
        if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
            raise ValueError(f"{path}: wanted [[{kind}]] in double brackets, one for each, found {kind} = {tables!r}")
        for number, table in enumerate(tables, start=1):
            for key in table:
                if key not in KEYS[kind]:
                    raise ValueError(f"{path}, [[{kind}]] number {number}: unknown key {key!r}; {_nearest(key, KEYS[kind])}")
            entries.append((kind, number, table))
    if not any(kind == "joint" for kind, _, _ in entries):
        raise ValueError(f"{path}: wanted at least one [[joint]], found {', '.join(content) or 'nothing'}")
    return entries, units, sector


def _deeper(value, depth):
    """Whether lists and tables are nested deeper; by level, because each level of a recursion takes room on the stack."""
    level = [value]
    for _ in range(depth + 1):
        level = [inner for outer in level for inner in (outer.values() if isinstance(outer, dict) else outer)
                 if isinstance(inner, (dict, list))]
    return bool(level)


def _nearest(word, known):
    spelled = {name.lower(): name for name in known}
    close = difflib.get_close_matches(word.lower(), spelled, n=1)
    return f"did you mean {spelled[close[0]]!r}?" if close else f"known are {', '.join(sorted(known)) or 'none'}"


def _with_material(structure, table):
    for key in ("young", "poisson", "density"):
        if key in table and (not _numeric(table[key]) or isinstance(table[key], list)) or key != "density" and key not in table:
            raise ValueError(f"{key} must be a finite number, found {table.get(key)!r}")
    where = _set(structure, _text(table, "set")) if "set" in table else None
    name = _text(table, "name", "text") if "name" in table else "material"
    return structure.with_material(table["young"], table["poisson"], table.get("density", 0.0), name=name, where=where)


def _loaded(structure, kind, table):
    """The structure with the load of an entry."""
    named = {} if "pattern" not in table else {"name": _text(table, "pattern", "the name of a load pattern")}
    if kind == "gravity":
        return structure.with_gravity(_vector(table))
    if kind == "base":
        return structure.with_base_acceleration(_vector(table, "direction"), **named)
    if kind == "preload" and "step" in table:
        if type(table["step"]) is not int or len(table) > 1:
            raise ValueError(f"step must be the number of a step of the deck, without other keys beside it, found {table!r}")
        return structure.with_step(table["step"])
    where = _set(structure, _text(table, "set"), tied=True)
    if kind == "preload":
        return structure.with_preload(where, _vector(table))
    if kind == "pressure":
        value, fourier = table.get("value"), table.get("fourier")
        if not _numeric(value) or isinstance(value, list):
            raise ValueError(f"value must be a finite number, found {value!r}")
        if fourier is not None and (not isinstance(fourier, list) or not _numeric(fourier) or isinstance(fourier[0], list)):
            raise ValueError(f"fourier must be a list of finite numbers [a0, a1, b1, ...], found {fourier!r}")
        return structure.with_pressure(where, value, fourier=fourier, **named)
    phase = table.get("phase", 0.0)
    if not _numeric(phase) or isinstance(phase, list):
        raise ValueError(f"phase must be a finite number [rad], found {phase!r}")
    add = structure.with_force if kind == "force" else structure.with_moment
    return add(where, _vector(table), phase=phase, **named)


def _joint(structure, table):
    sides = [key for key in ("between", "ground") if key in table]
    if len(sides) != 1:
        raise ValueError('wanted either between = ["A", "B"] or ground = "A", found ' + (" and ".join(sides) or "neither"))
    options = {key: value for key, value in table.items() if key not in ("between", "ground")}
    for key, value in options.items():
        if key == "name":
            _text(table, key, "text")
        elif key in TRUE_OR_FALSE:
            if not isinstance(value, bool):
                raise ValueError(f"{key} must be true or false, found {value!r}")
        elif not (_numeric(value) or key == "at" and isinstance(value, str) or key == "gap" and value == "geometry"):
            raise ValueError(f"{key} must be a number or a list of numbers, found {value!r}")
    if isinstance(options.get("at"), str):
        options["at"] = structure.nodes[structure.node_sets[_set(structure, options["at"], surfaces=False)]]
    if sides == ["ground"]:
        for key in sorted(BETWEEN_ONLY & set(options)):
            raise ValueError(f"{key} has no meaning for a joint with the ground")
        return Joint.ground(structure.surface(_set(structure, _text(table, "ground"))), **options)
    pair = table["between"]
    if not isinstance(pair, list) or len(pair) != 2 or not all(isinstance(name, str) for name in pair):
        raise ValueError(f'between must be two names, such as ["A", "B"], found {pair!r}')
    return Joint.between(*(structure.surface(_set(structure, name)) for name in pair), **options)


def _numeric(value):
    """Whether a value is a finite number, or a list of such or of such lists."""
    if isinstance(value, list):
        return bool(value) and all(map(_numeric, value))
    return type(value) in (int, float) and abs(value) <= sys.float_info.max  # whole numbers may be larger than any float


def _set(structure, name, surfaces=True, tied=False):
    """The name as the structure spells it; `tied`: sets of nodes that follow others, too."""
    known = [*structure.node_sets, *(structure.surfaces if surfaces else ()), *(structure.tied_sets if tied else ())]
    if name in known:
        return name
    alike = [other for other in known if other.upper() == name.upper()]
    if len(alike) == 1:
        return alike[0]
    raise ValueError(f"there is no set {name!r}; {_nearest(name, known)}")


def _text(table, key, what="the name of a set"):
    value = table.get(key)
    if not isinstance(value, str):
        raise ValueError(f"{key} must be {what}, found {value!r}")
    return value


def _directions(table):
    value = table.get("directions", "xyz")
    if not isinstance(value, str):
        raise ValueError(f'directions must be text such as "xyz", found {value!r}')
    return value


def _vector(table, key="vector"):
    value = table.get(key)
    if not isinstance(value, list) or len(value) != 3 or not all(_numeric(v) and not isinstance(v, list) for v in value):
        raise ValueError(f"{key} must be three finite numbers, found {value!r}")
    return value
