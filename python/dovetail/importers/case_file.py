"""A case file to go with an imported model: runs as it stands, its sweep around the modes of the stuck structure."""

from pathlib import Path

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as sla

from .. import units
from ..loaded import is_zero
from ..reference.cyclic import sector_basis

COUNT = 6  # modes that are named
MODES, HARMONICS = 20, 5  # for a first look
RATIO = 0.002  # damping at the mode of the sweep, a number to start with
BELOW, ABOVE = 0.8, 1.1  # of the frequency of that mode: friction softens, so the peak lies below
MOVED = 1e-3  # a mode counts as excited from this part of the largest motion on
SMALL = 300  # unknowns up to which matrices are dense
LARGE = 20000  # unknowns from which on SLEPc and MUMPS find the modes, where they are there
ENGINE_ORDER = 1  # of a sector, for a first look
LARGEST = 400000  # unknowns above which an import does not look for modes


def stuck_modes(model, count=COUNT):
    """Frequencies [rad/s] and shapes (n, m) of the lowest modes with springs at all contact points without a gap.

    Those of a sector are of nodal diameter `diameter(model)`, its shapes complex. Where all have a gap, the preload is taken to close
    them. Points without known stiffness are held. Ascending; motions without stiffness have frequency 0.
    """
    K, M, dofs, T = sp.csr_matrix(model.K), sp.csr_matrix(model.M), model.contact_dofs, None
    if model.cyclic:
        basis = sector_basis(model, diameter(model))
        K, M, dofs = basis.of(K), basis.of(M), basis.contact
        T, K, M = (A.real if diameter(model) == 0 else A for A in (basis.matrix, K, M))
    size = K.shape[0]
    kept = np.arange(size)
    if {"normal_stiffness", "tangential_stiffness"} <= set(model.contact):
        touch = model.contact.get("gap", np.zeros(len(dofs))) <= 0
        touch = touch | ~touch.any()
        springs = np.column_stack([model.contact["tangential_stiffness"], model.contact["normal_stiffness"]]) * touch[:, None]
        diagonal = np.zeros(size)
        diagonal[dofs] = springs
        K = K + sp.diags(diagonal)
    else:
        kept = np.setdiff1d(kept, dofs)
    count = min(count, len(kept) - 2)
    if count < 1:
        return np.zeros(0), np.zeros((model.n, 0))
    K, M = K[kept][:, kept], M[kept][:, kept]
    shift = -1e-8 * K.diagonal().real.mean() / M.diagonal().real.mean()  # K may be singular
    squares, vectors = _lowest(K, M, count, shift)
    order = np.argsort(squares)
    squares, vectors = squares[order], vectors[:, order]
    squares[squares < 1e-3 * abs(shift)] = 0.0
    shapes = np.zeros((size, count), dtype=vectors.dtype)
    shapes[kept] = vectors
    return np.sqrt(squares), shapes if T is None else T @ shapes


def diameter(model):
    """The nodal diameter whose modes are named: index 0 is real, which large models need."""
    return ENGINE_ORDER if model.n <= LARGE else 0


def _lowest(K, M, count, shift):
    if K.shape[0] > LARGE:
        try:
            from .large_modes import lowest
        except ImportError:
            pass
        else:
            return lowest(K, M, count, shift)
    if K.shape[0] <= SMALL:
        inverse, vectors = scipy.linalg.eigh(M.toarray(), (K - shift * M).toarray())
        return 1 / inverse[-count:] + shift, vectors[:, -count:] / np.sqrt(inverse[-count:])
    return sla.eigsh(sp.csc_matrix(K), count, sp.csc_matrix(M), sigma=shift)


def excited(model, omega, shapes):
    """Number of the lowest mode with a frequency that the loads move by more than a trace, else of the lowest with one; None without."""
    loads = [load for load in (model.force, *model.forces.values()) if load is not None and not is_zero(load)]
    moving = np.flatnonzero(omega > 0)
    if not moving.size:
        return None
    if not loads:
        return int(moving[0])
    push = np.max([np.abs(shapes.conj().T @ load) for load in loads], axis=0)[moving]
    motion = push * np.abs(shapes[:, moving]).max(axis=0) / omega[moving]**2
    return int(moving[np.argmax(motion > MOVED * motion.max())])


def write(model, path):
    """Writes case.toml beside the model file, unless one is there; returns what it did, in words."""
    target = Path(path).with_name("case.toml")
    if target.exists():
        return f"{target}: is there already and stays as it is"
    if model.n > LARGEST:
        return f"no case file: the modes of {model.n} unknowns are left to the program, dovetail run --dry-run"
    try:
        omega, shapes = stuck_modes(model)
    except (RuntimeError, ValueError, np.linalg.LinAlgError) as error:
        return f"no case file: the modes of the stuck structure were not found ({error})"
    number = excited(model, omega, shapes)
    if number is None:
        return "no case file: no mode of the stuck structure has a frequency; is it held, by joints at least?"
    target.write_text(text(model, Path(path).name, omega, number), encoding="utf-8")
    whose = "held at its contact points" if _held(model) else "stuck"
    found = ", ".join(f"{units.parse(model.units).hertz(value):.5g}" for value in omega)
    return f"{target}: its sweep is around mode {number + 1} of the structure {whose}; the lowest are {found} Hz"


def _held(model):
    return not {"normal_stiffness", "tangential_stiffness"} <= set(model.contact)


def text(model, name, omega, number):
    """The case file; `omega` are the modes, `number` that of the sweep."""
    at = omega[number]
    low, high = _round(BELOW * at), _round(ABOVE * at)
    whose = "with its contact points held, whose stiffness is not known yet" if _held(model) else "stuck, with all contact points closed"
    lines = ["# Written when the model was imported, to start from. docs/reference/case-file.md has every key.", "",
             f'model = "{name}"', "",
             f"# Lowest modes of the structure {whose}:"]
    unit = units.parse(model.units)
    if model.cyclic:
        lines[-1] = lines[-1][:-1] + f", nodal diameter {diameter(model)}:"
    lines += [f"#   {k}  {value:.6g} {unit.omega}  {unit.hertz(value):.6g} Hz" for k, value in enumerate(omega, start=1)]
    damping = [f"{key} = {value:g}  # of the deck" for key, value in model.damping.items()] or [
        f"stiffness = {_round(2 * RATIO / at):g}  # a ratio of {RATIO:g} at that mode, for want of better; put in yours"]
    lines += ["", "[continuation]", f"omega = [{low:g}, {high:g}]  # [{unit.omega}], around mode {number + 1}; slipping lowers a peak", "",
              "[damping]", *damping, "", "[reduction]", f"modes = {min(MODES, model.n - 3 * model.contact_points)}", "",
              "[harmonic_balance]", f"harmonics = {HARMONICS}", "",
              "# In place of both numbers, to have them chosen:  accuracy.tolerance = 1e-2", "",
              "[output]", 'directory = "out"', ""]
    whole = model.joint is not None and np.all(model.joint["area"] > 0)
    ending, of = ("_per_area", "times the area of each point") if whole else ("", "of each point")
    per = units.bracket(f"{unit.stress}/{unit.length}" if whole and unit.known else unit.stiffness if not whole else "")
    number = "1e11" if model.units == "SI" else "..."
    wanted = {"normal_stiffness": (ending, number, f"k_n{per}, {of}"), "tangential_stiffness": (ending, number, f"k_t{per}, {of}"),
              "friction": ("", "0.3", "mu")}
    missing = [key for key in wanted if key not in model.contact]
    lines += ["[contact]"] * bool(missing)
    lines += [f"# {key}{wanted[key][0]} = {wanted[key][1]}  # {wanted[key][2]}: give yours, the model has none" for key in missing]
    lines += [""] * bool(missing)
    travelling = [f"engine_order = {ENGINE_ORDER}  # so many lobes round the disk; put in yours"] if model.cyclic else []
    if model.forces:
        return "\n".join(lines + ["[excitation]", *travelling, ""] * bool(travelling) + [model.excitation()])
    lines += ["[excitation]", *travelling, "fourier = [0, 1]  # cos(omega t) times the force of the model", ""]
    return "\n".join(lines)


def _round(value):
    return float(f"{value:.4g}")
