"""The equations that a run has solved, dense and in NumPy: a `reference.HarmonicBalance` of results and their reduced file."""

import tomllib
from dataclasses import replace

import h5py
import numpy as np
import scipy.linalg

from . import reference
from .case_changes import contact_values
from .hdf5_read import numbers, opened, text
from .motion import find_joint
from .parameters import CONTACT_WIDTH
from .recovery import reduced_file

LOADS = ("force", "damping")  # parameters of a path that leave the joint and its preload as they are
FIELDS = {"normal_stiffness": "kn", "tangential_stiffness": "kt", "friction": "mu", "gap": "gap"}  # of reference.Contact


def equations(results, samples=None, parameter=None, harmonics=None):
    """The equations (11) with the loads and the damping of the case that the results hold.

    Parameters
    ----------
    results : Results
    samples : int, optional
        Instants per period, as the reference has sampled forces alone; default: those of the run, of an exact one so many that
        they are good for drawing.
    parameter : float, optional
        Of a run over another parameter, its value; default: what the case has. Unknowns are measured from the preload state with it.
    harmonics : int, optional
        Another number than that of the results, of runs that are not of a sector.
    """
    case = tomllib.loads(results.case)
    path = reduced_file(results)
    name = None if parameter is None else results.parameter_name
    with opened(path) as file:
        reduced, names = reduced_of(file, results)
        damping = _damping(file, results, case.get("damping", {}), reduced)
        further = [] if results.wave is None else [of_index(file, results, h) for h in range(1, results.wave.sectors // 2 + 1)]
    contact, preload = _at_rest(results, case, reduced, parameter)
    loads = courses(case, names, path)
    if name == "force":
        loads = [[parameter * value for value in course] for course in loads]
    elif name == "damping":
        damping = replace(damping, **{key: parameter * getattr(damping, key) for key in ("stiffness", "mass", "structural", "matrix")})
    rest = contact, preload, damping, loads, harmonics or results.harmonics, samples or results.drawing_samples
    if results.wave is None:
        return reference.HarmonicBalance(reduced, *rest)
    return reference.SectorBalance([reduced, *further], results.wave.index, *rest)


def at_rest(results, parameter=None):
    """(reference.Contact, reference.Preload) with a value of the parameter of the path; default: those of the case."""
    with opened(reduced_file(results)) as file:
        return _at_rest(results, tomllib.loads(results.case), reduced_of(file, results)[0], parameter)


def _at_rest(results, case, reduced, parameter):
    contact = reference.Contact(*(results.contact[key] for key in CONTACT_WIDTH), law=results.contact["law"])
    if parameter is None or results.parameter_name in LOADS:
        return contact, reference.Preload(results.xp.reshape(-1, 3), results.g.reshape(-1, 3), results.w)
    if results.parameter_name == "preload":
        return contact, reference.contact_preload(replace(reduced, r=parameter * reduced.r), contact, results.xp)
    contact = _varied(results, case, contact, parameter)
    return contact, reference.contact_preload(reduced, contact, results.xp)


def _varied(results, case, contact, value):
    """The contact points whose parameter, at those that `[path]` names, has another value: a factor, or for the gap an offset."""
    path, damping = case["path"], case.get("damping", {})
    if "stiffness" in results.parameter_name and (damping.get("contact") or damping.get("ratios")):
        raise ValueError(f"{results.path}: {results.parameter_name} varies, and [damping] depends on it by `contact` or `ratios`")
    which = np.isin(np.arange(1, results.contact_points + 1), path["points"]) if "points" in path else np.full(results.contact_points, True)
    if "joint" in path:
        joint = find_joint(results)
        which = joint["joint"] == joint["names"].index(path["joint"])
    kind = "offset" if results.parameter_name == "gap" else "factor"
    values = contact_values(results.contact, {results.parameter_name: (kind, np.where(which, value, np.nan))})
    return replace(contact, **{FIELDS[key]: numbers for key, numbers in values.items()})


def courses(case, names, path):
    """One Fourier series for each load pattern of a reduced file, by the names of the patterns; [0] for those that rest."""
    given = _given(case)
    if unknown := set(given) - set(names):
        raise ValueError(f"{path}: has no load pattern {', '.join(sorted(unknown))}, which the case names; there are {', '.join(names)}")
    return [given.get(name, [0.0]) for name in names]


def courses_of(results):
    """The Fourier series that the case gives, by load pattern."""
    return _given(tomllib.loads(results.case))


def _given(case):
    excitation = case["excitation"]
    return {load["pattern"]: load["fourier"] for load in excitation.get("load", [])} or {"force": excitation["fourier"]}


def stuck(system, closed=None, harmonic=1):
    """Matrix of the structure with the springs of its contact points, (n, n), of a harmonic of a `HarmonicBalance`.

    closed : (N_x, 3) bool, springs that count; default: of the points that press in the preload state, those without friction in
        their normal alone.
    """
    contact = system.contact
    if closed is None:
        pressed = (system.preload.g[:, 2] > 0) | (contact.kind == reference.contact.BILATERAL)
        closed = np.column_stack([pressed & (contact.kind <= reference.contact.CONE)] * 2 + [pressed])
    springs = closed * np.column_stack([contact.kt, contact.kn])
    return system.matrices(harmonic)[0] + np.diag(np.concatenate([np.zeros(system.modes), springs.ravel()]))


def reduced_of(file, results):
    """`reference.Reduced` of an open reduced file, and the names of its load patterns."""
    n, m = results.modes, 3 * results.contact_points
    names = [text(name) for name in np.atleast_1d(file.attrs.get("force_names", "force"))]
    loads = {}
    for name, width in (("Fa", n), ("Fx", m)):
        values = np.asarray(file[name], dtype=float)
        loads[name] = values.reshape(-1, width) if width else np.zeros((len(names), 0))
    shapes = {"Kaa": (n,), "Max": (n, m), "Mxx": (m, m), "Kxx": (m, m), "R": (m,)}
    parts = {name: numbers(file, name, shape) for name, shape in shapes.items()}
    return reference.Reduced(parts["Kaa"], parts["Max"], parts["Mxx"], parts["Kxx"], loads["Fa"], loads["Fx"], parts["R"]), names


def of_index(file, results, h):
    """The same of a sector in the index h > 0, complex."""
    n, m = results.modes, 3 * results.contact_points

    def values(name, *shape):
        parts = numbers(file, f"cyclic/{h}/{name}", (*shape, 2))
        return parts[..., 0] + 1j * parts[..., 1]

    return reference.Reduced(numbers(file, f"cyclic/{h}/Kaa", (n,)), values("Max", n, m), values("Mxx", m, m), values("Kxx", m, m),
                             values("Fa", None, n), values("Fx", None, m), np.zeros(m))


def _matrix(file, letter, results):
    """A matrix of damping by its blocks, zero where the file has none of it, or None where it has no block at all."""
    n, m = results.modes, 3 * results.contact_points
    blocks = {name: f"{letter}{name}" for name in ("aa", "ax", "xx")}
    if not any(name in file for name in blocks.values()):
        return None
    aa, ax, xx = (np.asarray(file[name], dtype=float) if name in file and isinstance(file[name], h5py.Dataset) else None
                  for name in blocks.values())
    aa = np.zeros((n, n)) if aa is None else np.diag(aa) if aa.ndim == 1 else aa
    ax = np.zeros((n, m)) if ax is None else ax
    xx = np.zeros((m, m)) if xx is None else xx
    return np.block([[aa, ax], [ax.T, xx]])


def _damping(file, results, section, reduced):
    """Every kind of [damping], by its definition in the case file's reference."""
    stiffness, mass, structural = (section.get(key, 0.0) for key in ("stiffness", "mass", "structural"))
    matrix, given = 0.0, section.get("ratios", [])
    if section.get("matrix") and (C := _matrix(file, "C", results)) is not None:
        matrix = matrix + C
    if given and section.get("of", "stuck") == "fixed":
        rates = np.zeros(results.modes + 3 * results.contact_points)
        for mode, ratio in given:
            rates[mode - 1] = 2 * ratio * np.sqrt(reduced.kaa[mode - 1])
        matrix = matrix + np.diag(rates)
    elif given:
        K = scipy.linalg.block_diag(np.diag(reduced.kaa), reduced.kxx) + np.diag(_springs(results, np.ones((results.contact_points, 3))))
        M = np.block([[np.eye(results.modes), reduced.max], [reduced.max.T, reduced.mxx]])
        squares, shapes = scipy.linalg.eigh(K, M)
        rates = np.zeros(len(squares))
        for mode, ratio in given:
            rates[mode - 1] = 2 * ratio * np.sqrt(squares[mode - 1])
        matrix = matrix + M @ shapes @ np.diag(rates) @ shapes.T @ M
    if section.get("contact"):
        force = results.g.reshape(-1, 3)
        sticks = np.abs(force[:, :2]) < results.contact["friction"] * force[:, 2:] * (1 - 1e-9)
        matrix = matrix + stiffness * np.diag(_springs(results, np.column_stack([sticks, force[:, 2] > 0])))
    return reference.Damping(stiffness, mass, structural, matrix, _matrix(file, "S", results) if structural else None)


def _springs(results, closed):
    """Diagonal (N_a + 3 N_x,) of the contact springs that count."""
    springs = closed * np.column_stack([results.contact["tangential_stiffness"], results.contact["normal_stiffness"]])
    return np.concatenate([np.zeros(results.modes), springs.ravel()])
