"""Stress of a part and what it uses of the strength: `python3 -m dovetail stress RESULTS.h5`."""

import csv
from pathlib import Path

import numpy as np

from .export import number
from .fatigue import principal
from .life import asked_life
from .nodal_stress import given_material
from .motion import find_model, read_model_parts
from .output_files import made
from .reactions import reactions
from .results import Results
from .shown import default_dofs
from .strains import COMPONENTS
from .units import bracket, with_unit

MOST_SETS = 3  # named in the list
ENDINGS = (".csv", ".png")


def stress(arguments):
    """The command."""
    results = Results(arguments.file, arguments.model)
    results.need_points()
    if arguments.worst < 1:
        raise ValueError(f"--worst: 1 or more points are wanted, found {arguments.worst}")
    outputs = [Path(name) for name in arguments.output]
    for path in outputs:
        if path.suffix.lower() not in ENDINGS:
            raise ValueError(f"{path}: a table is written as FILE.csv, a picture as FILE.png; found the ending {path.suffix or 'none'}")
    point = number(results, arguments, (arguments.dof or default_dofs(results))[0])
    mesh, _ = read_model_parts(find_model(results))
    found = asked_life(results, point, arguments, _left_out(mesh, arguments.without))
    if not len(found.mean):
        raise ValueError("--without: no node is left")
    forces = reactions(results, point, arguments.reaction, material=given_material(arguments.material)) if arguments.reaction else {}
    print("\n".join([*in_words(results, point, found, mesh, arguments.worst), *_reactions_in_words(forces, results.unit)]))
    for path in outputs:
        if path.suffix.lower() == ".csv":
            write(made(path), found, mesh, results.unit)
        else:
            from .stress_picture import save

            save(made(path), results, point, found, arguments)
        print(path)


def _left_out(mesh, names):
    """Rows of the nodes of sets."""
    for name in names:
        if mesh is None or name not in mesh["sets"]:
            known = sorted(mesh["sets"] if mesh else ())
            raise ValueError(f"--without: there is no node set {name!r}; there are {', '.join(known) or 'none'}")
    return np.concatenate([np.zeros(0, int), *(mesh["sets"][name] for name in names)])


def in_words(results, point, found, mesh, count):
    """Lines: which point, which materials, and the worst points."""
    stress, unit = found.stress, results.unit
    rows = found.worst(count)
    counts = np.bincount(stress.material, minlength=len(stress.materials))
    materials = [f"{one.name} (E {with_unit(f'{one.young:.6g}', unit.stress)}, nu {one.poisson:g}): {number} nodes"
                 for one, number in zip(stress.materials, counts) if number]
    lines = [f"{results.path}, point {point}: {results.place(results.along[point], 6)}, {results.frequency[point]:.6g} Hz",
             *(f"  {text}" for text in materials)]
    if stress.left_out:
        lines.append("  no stress in " + ", ".join(f"{number} {what}" for what, number in stress.left_out.items()))
    lines.append(f"  criterion {found.criterion}; stresses" + bracket(unit.stress))
    heads = columns(found, mesh, unit)
    cells = [list(heads), *([show(row) for show in heads.values()] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells)]
    lines += ["  " + "  ".join(f"{cell:>{width}}" for cell, width in zip(line, widths)) + f"  {said}".rstrip()
              for line, said in zip(cells, ["sets", *(_sets(mesh, stress.node[row]) for row in rows)])]
    return lines


def _reactions_in_words(forces, unit):
    lines = []
    for name, of_set in forces.items():
        mean, amplitude = (", ".join(f"{value:.5g}" for value in values) for values in of_set)
        lines.append(f"  supports on {name!r}{bracket(unit.force)}: mean ({mean}), amplitude ({amplitude}), without their inertia")
    return lines


def columns(found, mesh, unit):
    """Headers of the list, and what each shows of a pair, as text."""
    stress = found.stress
    largest = {}

    def most(row):
        if row not in largest:
            largest[row] = largest_principal(stress, row)
        return largest[row]

    shown = {"node": lambda row: str(stress.node[row])}
    for axis, name in enumerate("xyz"):
        shown[name + bracket(unit.length)] = lambda row, axis=axis: f"{mesh['nodes'][stress.node[row], axis]:.5g}"
    if len(np.unique(stress.material)) > 1:
        shown["material"] = lambda row: stress.materials[stress.material[row]].name
    shown |= {"static von Mises": lambda row: f"{found.static[row]:.5g}", "largest principal": lambda row: f"{most(row):.5g}",
              "mean": lambda row: f"{found.mean[row]:.5g}", "amplitude": lambda row: f"{found.amplitude[row]:.5g}"}
    if found.utilisation is not None:
        shown["utilisation"] = lambda row: f"{found.utilisation[row]:.4g}"
    return shown


def largest_principal(stress, row, instants=256):
    """The largest principal stress of a pair over the period, from samples."""
    from . import fourier

    return principal(fourier.basis(len(stress.series) // 2, fourier.phases(instants)) @ stress.series[:, row])[:, 0].max()


def _sets(mesh, node):
    names = [name for name, rows in sorted(mesh["sets"].items()) if node in rows]
    return ", ".join(names[:MOST_SETS]) + ", ..." * (len(names) > MOST_SETS)


def write(path, found, mesh, unit):
    """All nodes as a table: places, the mean tensor, and what the criterion makes of the course."""
    stress, length, unit = found.stress, bracket(unit.length), bracket(unit.stress)
    table = {"node": stress.node, **{axis + length: place for axis, place in zip("xyz", mesh["nodes"][stress.node].T)},
             "material": [stress.materials[number].name for number in stress.material]}
    table |= {f"static {name}{unit}": values for name, values in zip(COMPONENTS, stress.series[0].T / 2)}
    table |= {f"static von Mises{unit}": found.static, f"mean{unit}": found.mean, f"amplitude{unit}": found.amplitude}
    if found.utilisation is not None:
        table["utilisation"] = found.utilisation
    with open(path, "w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow(table)
        out.writerows([f"{value:.9g}" if isinstance(value, float) else value for value in row] for row in zip(*table.values()))
