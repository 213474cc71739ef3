"""Decks of hexahedral bars for CalculiX, and runs of CalculiX on them."""

import re
import shutil
import subprocess

import numpy as np
import pytest

from launch import SECONDS

CCX = shutil.which("ccx")
EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
CORNERS = np.array([(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)])
YOUNG, DENSITY = 210e3, 7.8e-9  # t, mm, s, N


def bar(size=(40.0, 10.0, 5.0), cells=(4, 2, 1), origin=(0.0, 0.0, 0.0), first=1):
    """Nodes {label: place} and elements {label: 20 labels} of a bar of C3D20; labels count from `first`, with gaps."""
    cells = np.array(cells)
    labels, nodes, elements = {}, {}, {}
    for number, cell in enumerate(np.ndindex(*cells)):
        grid = [2 * np.array(cell) + corner for corner in CORNERS]
        grid += [(grid[i] + grid[j]) // 2 for i, j in EDGES]
        for point in map(tuple, grid):
            if point not in labels:
                labels[point] = first + 3 * len(labels)
                nodes[labels[point]] = np.array(origin) + np.array(size) * np.array(point) / (2 * cells)
        elements[first + number] = [labels[tuple(point)] for point in grid]
    return nodes, elements


def on(nodes, axis, value):
    """Labels of the nodes with a coordinate of that value."""
    return [label for label, place in nodes.items() if abs(place[axis] - value) < 1e-9]


def rows(labels, width=12):
    labels = list(map(str, labels))
    return "\n".join(", ".join(labels[i:i + width]) + "," * (i + width < len(labels)) for i in range(0, len(labels), width))


def mesh_text(nodes, elements, kind="C3D20R", elset="BODY"):
    """*NODE and *ELEMENT; elements of more than 15 nodes go on in a second line."""
    corners = {"C3D8": 8, "C3D8I": 8}.get(kind, 20)
    used = {node for members in elements.values() for node in members[:corners]}
    text = "*NODE\n" + "".join(f"{label}, {x:.12g}, {y:.12g}, {z:.12g}\n" for label, (x, y, z) in nodes.items() if label in used)
    text += f"*ELEMENT, TYPE={kind}, ELSET={elset}\n"
    for label, members in elements.items():
        text += f"{label}, {rows(members[:min(corners, 10)])}" + (",\n" + rows(members[10:]) if corners > 10 else "") + "\n"
    return text


def material(elset="BODY"):
    return f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{YOUNG}, 0.3\n*DENSITY\n{DENSITY}\n*SOLID SECTION, ELSET={elset}, MATERIAL=STEEL\n"


def matrices_step(inside=""):
    return f"*STEP\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n1\n{inside}*END STEP\n"


def held_end(nodes, level):
    """Nodes at x = 0, but not those on z = level, where the contact is."""
    return [label for label in on(nodes, 0, 0) if abs(nodes[label][2] - level) > 1e-9]


def deck(extra="", inside="", kind="C3D20R", level=0, **shape):
    """A bar held at x = 0 outside z = level, with node sets Left (held) and Bottom and the surface UNDER."""
    nodes, elements = bar(**shape)
    if kind.startswith("C3D8"):
        used = {label for members in elements.values() for label in members[:8]}
        nodes = {label: place for label, place in nodes.items() if label in used}
    sets = f"*Nset, nset=Left\n{rows(held_end(nodes, level))}\n*Nset, nset=Bottom\n{rows(on(nodes, 2, 0))}\n"
    return (mesh_text(nodes, elements, kind) + sets + "*SURFACE, NAME=UNDER, TYPE=ELEMENT\nBODY, S1\n" + material()
            + f"*BOUNDARY\nLEFT, 1, 3\n{extra}" + matrices_step(inside))


def solved(text):
    """The deck for CalculiX's own frequencies instead of matrices."""
    return text.replace("SOLVER=MATRIXSTORAGE\n1", "SOLVER=SPOOLES\n6")


def run_ccx(folder, name, text):
    """Writes the deck and runs CalculiX on it; returns the path of the deck."""
    if CCX is None:
        pytest.skip("CalculiX (ccx) is not installed")
    path = folder / f"{name}.inp"
    path.write_text(text)
    done = subprocess.run([CCX, name], cwd=folder, capture_output=True, text=True, timeout=SECONDS)
    assert "Job finished" in done.stdout and "*ERROR" not in done.stdout, done.stdout[-2000:]
    return path


def static_displacement(folder, text, structure):
    """(n,) displacements of a structure under the loads of its deck, as a static step of CalculiX finds them."""
    static = text.replace("*FREQUENCY, SOLVER=MATRIXSTORAGE\n1\n", "*STATIC\n") \
                 .replace("*END STEP", "*NODE PRINT, NSET=NALL\nU\n*END STEP").replace("*NODE\n", "*NODE, NSET=NALL\n", 1)
    printed = run_ccx(folder, "static", static).with_suffix(".dat").read_text()
    found = np.array(re.findall(r"^ +(\d+) +(\S+) +(\S+) +(\S+)$", printed, re.M), dtype=float)
    return found[np.searchsorted(found[:, 0], structure.labels[structure.dof_node]), structure.dof_direction + 1]


def frequencies(path):
    """omega [rad/s] of a *FREQUENCY analysis, from job.dat."""
    text = path.with_suffix(".dat").read_text()
    found = re.findall(r"^\s+\d+\s+\S+\s+(\S+)\s+\S+\s+\S+\s*$", text.split("P A R T I C I P A T I O N")[0], re.M)
    return np.array(found, dtype=float)
