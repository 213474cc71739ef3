"""What is in a file, in a few lines: model, reduced model or results."""

import os

import h5py
import numpy as np

from . import friction_energy
from .hdf5_read import dataset, members, numbers, opened, patiently, words
from .model_cyclic import read_cyclic
from .model_mesh import read_joint, read_mesh
from .motion import find_joint
from .parameters import CONTACT_WIDTH
from .preload_state import in_words, joint_states
from .reference import LAWS
from .results import INSTABILITIES, Results, STABLE, UNCERTAIN, UNSTABLE
from .shown import default_dofs
from .units import parse, with_unit


def format_of(path):
    """What kind of file of Dovetail this is: "dovetail-model", "dovetail-reduced" or "dovetail-results"."""
    if os.path.isdir(path):
        raise ValueError(f"{path}: is a folder; a file of Dovetail in it is wanted, such as {os.path.join(path, 'results.h5')}")
    if not os.path.isfile(path):
        raise ValueError(f"{path}: no such file")
    if not h5py.is_hdf5(path):
        raise ValueError(f"{path}: not a file of Dovetail, nor any other HDF5 file")
    kind = patiently(path, lambda file: words(file, "format", "unnamed"), "file of Dovetail")
    if kind not in ("dovetail-model", "dovetail-reduced", "dovetail-results"):
        raise ValueError(f"{path}: not a file of Dovetail (format {kind})")
    return kind


def describe(path):
    """Text for `python3 -m dovetail info`."""
    kind = format_of(path)
    if kind == "dovetail-results":
        lines = _results(Results(path))
    else:
        with opened(path) as file:
            lines = {"dovetail-model": _model, "dovetail-reduced": _reduced}[kind](file)
    width = max(len(label) for label, _ in lines)
    return "\n".join([f"{path}: {kind}"] + [f"  {label:<{width}}  {value}" for label, value in lines])


def _range(values):
    if not np.size(values):
        return "none"
    low, high = np.min(values), np.max(values)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def _contact_lines(values, unit):
    units = {"normal_stiffness": unit.stiffness, "tangential_stiffness": unit.stiffness, "gap": unit.length}
    return [(name.replace("_", " "), with_unit(_range(values[name]), units.get(name, ""))) for name in CONTACT_WIDTH if name in values]


def _laws(numbers):
    """Such as "cone", or "coulomb (3), bilateral (1)"."""
    counts = np.bincount(numbers, minlength=len(LAWS))
    if np.count_nonzero(counts) == 1:
        return LAWS[np.argmax(counts)]
    return ", ".join(f"{name} ({count})" for name, count in zip(LAWS, counts) if count)


def _model(file):
    n, cyclic = dataset(file, "K/jc", (None,), "i").size - 1, read_cyclic(file)
    points = len(dataset(file, "contact/dofs", (None, 3), "i") if cyclic is None else cyclic["nodes"])
    unit = parse(words(file, "units"))
    entries = [dataset(file, f"{name}/data", (None,)).size for name in ("K", "M")]
    lines = [("units", words(file, "units", "not given")), *_freedoms(n, points, cyclic),
             ("entries of K, M", f"{entries[0]}, {entries[1]}")]
    for name in ("force", *(f"forces/{name}" for name in members(file, "forces")), "preload"):
        if name in file:
            values = numbers(file, name)
            lines.append((name, f"{np.count_nonzero(values)} entries, largest "
                          + with_unit(f"{np.abs(values).max(initial=0):g}", unit.force)))
    lines += _contact_lines({name: numbers(file, f"contact/{name}") for name in CONTACT_WIDTH if f"contact/{name}" in file}, unit)
    joint = read_joint(file)
    if joint:
        lines += [("joint", f"{name}: {np.count_nonzero(joint['joint'] == i)} contact points, "
                            "area " + with_unit(f"{joint['area'][joint['joint'] == i].sum():g}", unit.area))
                  for i, name in enumerate(joint["names"])]
    mesh = read_mesh(file)
    if mesh:
        cells = ", ".join(f"{len(rows)} {kind}" for kind, rows in mesh["cells"].items())
        lines.append(("mesh", f"{len(mesh['nodes'])} nodes; cells: {cells or 'none'}"))
        if mesh["sets"]:
            lines.append(("sets", ", ".join(f"{name} ({len(rows)})" for name, rows in mesh["sets"].items())))
    return lines


def _freedoms(n, points, cyclic):
    if cyclic is None:
        return [("degrees of freedom", f"{n} ({n - 3 * points} elastic)"), ("contact points", points)]
    further = np.count_nonzero(cyclic["next_sector"])
    axis = ", ".join(f"{value + 0.0:g}" for value in cyclic["axis"])
    return [("one of", f"{cyclic['sectors']} sectors about the axis ({axis}); {(cyclic['left'] >= 0).sum()} dofs on either side"),
            ("degrees of freedom", n), ("contact points", f"{points}" + (f", {further} of them to the next sector" if further else ""))]


def _reduced(file):
    squares, preload = numbers(file, "Kaa", (None,)), numbers(file, "R", (None,))
    frequencies, unit = np.sqrt(np.maximum(squares, 0)), parse(words(file, "units", "SI"))
    lines = [("modes", f"{squares.size}, {_range(frequencies)} {unit.omega} ({_range(unit.hertz(frequencies))} Hz), contact points held"),
             ("contact points", preload.size // 3),
             ("largest contact preload", with_unit(f"{np.abs(preload).max(initial=0):g}", unit.force))]
    if "recovery" in file:
        kept = f"; {len(dataset(file, 'recovery/Phi', (None, None)))} elastic dofs" if "recovery/Phi" in file else ""
        lines.append(("recovery", ", ".join(sorted(members(file, "recovery"))) + kept))
    else:
        lines.append(("recovery", "none: displacements of the full model cannot be computed"))
    return lines


def _amplitude(results, unit, amplitude, place, digits=7):
    value = with_unit(f"{amplitude:.{digits}g}", unit)
    hertz = "" if results.parameter is not None else f" ({results.unit.hertz(place):.{digits}g} Hz)"
    return f"{value} at {results.place(place, digits)}{hertz}"


def _peaks(results):
    if results.tracked_amplitude is not None:
        return _track(results)
    lines = []
    for dof in default_dofs(results):
        curve = results.response(dof)
        omega, highest = max(curve.peaks(), key=lambda peak: peak[1], default=(None, 0.0))
        if omega is not None:
            lines.append((f"peak of {dof}", _amplitude(results, curve.unit, highest, omega)))
        lines += [(f"no peak: {dof}", f"{words}, {_amplitude(results, curve.unit, amplitude, omega)}")
                  for omega, amplitude, words in curve.ends() if amplitude > highest]
    return lines


def _track(results):
    """Where the peak that was followed begins, is highest and lowest, and ends."""
    curve = results.response(results.watched)
    places = {"first": 0, "highest": int(np.argmax(curve.amplitude)), "lowest": int(np.argmin(curve.amplitude)),
              "last": len(results) - 1}
    return [(f"{word} peak of {results.watched}", _amplitude(results, curve.unit, curve.amplitude[i], results.along[i])
             + f", {with_unit(f'{results.omega[i]:.7g}', results.unit.omega)} ({results.frequency[i]:.7g} Hz)")
            for word, i in places.items()]


def _events(results):
    places, names = results.events.of("peak"), results.dof_names()
    watched = [names[row] if row >= 0 else results.watch for row in places.unknown]
    lines = [(f"located peak of {dof}" if dof else "located peak",
              _amplitude(results, results.unit_of(dof) if dof else "", amplitude, place, 9))
             for dof, place, amplitude in zip(watched, places.place, places.amplitude)]
    lines += [(words, results.place(place)) for kind, words in (("fold", "turning point"), ("branch", "crossing branch"))
              for place in results.events.of(kind).place]
    kinds = ("corner", "harmonics", "leap", "integration", "missed", "outside")
    helped = [(kind, len(results.events.of(kind))) for kind in kinds]
    said = ", ".join(f"{kind} ({count})" for kind, count in helped if count)
    return lines + ([("where it was hard", said)] if said else [])


def _stability(results):
    if results.stable is None:
        return []
    counts = [(words, np.count_nonzero(results.stable == verdict))
              for words, verdict in (("stable", STABLE), ("unstable", UNSTABLE), ("uncertain", UNCERTAIN))]
    kinds = np.unique(results.instability[results.stable == UNSTABLE])
    said = ", ".join(f"{count} points {words}" for words, count in counts if count)
    named = ", ".join(INSTABILITIES[kind] for kind in kinds if 0 < kind < len(INSTABILITIES))
    lines = [("stability", said + (f" ({named})" if named else ""))]
    return lines + [("changes", results.place(place)) for place in results.events.of("stability").place]


def _results(results):
    n = len(results)
    lines = [("title", results.title or "none"), ("units", results.units + ("" if results.unit.known else ", plain numbers")),
             *_wave(results),
             ("unknowns", f"{results.modes} modes, {results.contact_points} contact points, {results.harmonics} harmonics"),
             ("contact forces", f"{results.samples} samples" if results.samples else "exact"),
             ("points", n)]
    if n:
        unit = results.unit.omega
        lines.append(("omega", f"{_range(results.omega)} {unit} ({_range(results.frequency)} Hz), last {results.omega[-1]:g} {unit}"))
        if results.parameter is not None:
            lines.append((results.parameter_name, f"{_range(results.parameter)}, last {results.parameter[-1]:g}"))
        if results.damping_ratio is not None:
            lines.append(("damping ratio", f"{_range(results.damping_ratio)}, last {results.damping_ratio[-1]:g}"))
        lines += _peaks(results)
        lines += _events(results) + _stability(results)
        lines += [(f"points that {verb}", f"at most {100 * results.points(name).max():.4g} %, in {np.count_nonzero(results.points(name))}"
                   f" of {n} responses") for name, verb in (("slip", "slip"), ("open", "open"))]
        if results.wave is not None and results.has_activity:
            lines.append(("friction energy", friction_energy.in_words(results)))
        lines.append(("effort", f"{results.points('newton_iterations').sum():.0f} Newton iterations, "
                                f"{results.points('seconds').sum():.3g} s"))
    return lines + _preload(results) + [("contact law", _laws(results.contact["law"]))] + _contact_lines(results.contact, results.unit)


def _wave(results):
    """Of a sector of a cyclic structure: which wave runs round it."""
    if results.wave is None:
        return []
    index = f"{', '.join(map(str, results.wave.index))} of harmonics 0 to {results.harmonics}"
    return [("one of", f"{results.wave.sectors} sectors, engine order {results.wave.engine_order}"), ("index h", index)]


def _preload(results):
    """The state before anything shakes; joint by joint where the model file is there."""
    lines = [("preload", in_words(results))]
    try:
        states = joint_states(results, find_joint(results))
    except ValueError:
        return lines
    return lines * (len(states) > 1) + [("preload", f"{state.name}: {state.in_words(results.unit)}") for state in states]
