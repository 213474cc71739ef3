"""Stress at nodes against CalculiX: single cells of every kind, a bar under a static load, and its amplitude under a harmonic one."""

import re

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse.linalg as sla
from brick_deck import DENSITY, YOUNG, bar, material, matrices_step, mesh_text, on, rows, run_ccx

from dovetail import fatigue, solids
from dovetail.importers import calculix
from dovetail.material import Material
from dovetail.nodal_stress import of_displacements
from dovetail.strains import cell_stress

KINDS = {"C3D4": ("tetra", solids.USUAL), "C3D10": ("tetra10", solids.USUAL), "C3D15": ("wedge15", solids.USUAL),
         "C3D8": ("hexahedron", solids.USUAL), "C3D8I": ("hexahedron", solids.INCOMPATIBLE), "C3D20": ("hexahedron20", solids.FULL),
         "C3D20R": ("hexahedron20", solids.USUAL)}
MODES, RATIO, NEAR = 12, 0.01, 0.97  # of the harmonic load: modes, damping ratio, frequency by that of the first mode
FORCE = 100.0
TURNS = np.linspace(0, np.pi, 400)


def nodal(path, heading="STRESS"):
    """(n, 6) of all nodes in their order, from the first block of that heading in job.frd; components as here."""
    text = path.with_suffix(".frd").read_text()
    block = text[text.index(f" -4  {heading:<8}"):].split("\n -3")[0]
    lines = [line for line in block.splitlines() if line.startswith(" -1")]
    return np.array([[float(line[13 + 12 * i:25 + 12 * i]) for i in range(6)] for line in lines])


@pytest.mark.parametrize("kind", KINDS)
def test_single_cells(tmp_path, kind):
    """Distorted, with displacements at random: the same values at the integration points, and the same way to the nodes."""
    name, integration = KINDS[kind]
    rng = np.random.default_rng(4)
    X = solids.places(name) + 0.12 * rng.uniform(-1, 1, solids.places(name).shape)
    u = 1e-3 * rng.uniform(-1, 1, X.shape)
    labels = list(range(1, len(X) + 1))
    text = "*NODE, NSET=NALL\n" + "".join(f"{i}, {x:.12g}, {y:.12g}, {z:.12g}\n" for i, (x, y, z) in zip(labels, X))
    members = rows(labels[:10]) + (",\n" + rows(labels[10:]) if len(labels) > 10 else "")
    text += f"*ELEMENT, TYPE={kind}, ELSET=BODY\n1, {members}\n{material()}*STEP\n*STATIC\n*BOUNDARY\n"
    held = [(i, d) for i in range(len(X)) for d in range(3)][:-1]  # CalculiX wants an unknown
    text += "".join(f"{i + 1}, {d + 1}, {d + 1}, {u[i, d]:.12g}\n" for i, d in held)
    path = run_ccx(tmp_path, "cell", text + "*NODE PRINT, NSET=NALL\nU\n*EL FILE\nS\n*END STEP\n")
    printed = path.with_suffix(".dat").read_text()
    u = np.array(re.findall(r"^ +\d+ +(\S+) +(\S+) +(\S+)$", printed, re.M), dtype=float)
    found = cell_stress(name, integration, X[None], u[None, None], np.array([YOUNG]), np.array([0.3]))[0, 0]
    wanted = nodal(path)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-4 * np.abs(wanted).max())


def deck(kind, step):
    """A bar held at x = 0, with a force at its end in two directions."""
    nodes, elements = bar(cells=(4, 2, 2))
    text = mesh_text(nodes, elements, kind)
    used = set(map(int, re.findall(r"^(\d+), [-\d.]+e?[-\d]*, [-\d.]+e?[-\d]*, [-\d.]+", text, re.M)))
    held, tip = ([label for label in on(nodes, 0, x) if label in used] for x in (0, 40))
    text += f"*NSET, NSET=LEFT\n{rows(held)}\n*NSET, NSET=TIP\n{tip[0]},\n{material()}*BOUNDARY\nLEFT, 1, 3\n"
    return text + step.format(load=f"*CLOAD\nTIP, 3, {FORCE}\nTIP, 2, {FORCE / 3}\n")


def displacements(structure, u):
    """(1, n_nodes, 3) of unknowns (n,), zero where held."""
    field = np.zeros((1, len(structure.nodes), 3), u.dtype)
    field[0, structure.dof_node, structure.dof_direction] = u
    return field


def mesh_of(structure):
    return {"nodes": structure.nodes, "cells": structure.cells, "materials": structure.materials, "material": structure.material,
            "integration": structure.integration}


@pytest.mark.parametrize("kind", ["C3D20R", "C3D8I"])
def test_a_bar_under_a_static_load(tmp_path, kind):
    """With the material of the deck."""
    structure = calculix.read([run_ccx(tmp_path, "bar", deck(kind, matrices_step("{load}")))])
    assert structure.materials == [Material(YOUNG, 0.3, DENSITY, "STEEL")]
    assert any(note.startswith("materials for stresses: STEEL (E 210000, nu 0.3)") for note in structure.notes)
    u = sla.spsolve(structure.K.tocsc(), structure.force)
    found = of_displacements(mesh_of(structure), displacements(structure, u))
    wanted = nodal(run_ccx(tmp_path, "static", deck(kind, "*STEP\n*STATIC\n{load}*EL FILE\nS\n*END STEP\n")))
    np.testing.assert_array_equal(found.node, np.arange(len(structure.nodes)))
    np.testing.assert_allclose(found.series[0], wanted, rtol=0, atol=1e-4 * np.abs(wanted).max())


def test_a_bar_under_a_harmonic_load(tmp_path):
    """Amplitudes near the first resonance, of the same modes with the same damping; and Sines' amplitude by hand from CalculiX's."""
    structure = calculix.read([run_ccx(tmp_path, "bar", deck("C3D20R", matrices_step("{load}")))])
    K, M = structure.K.toarray(), structure.M.toarray()
    compliance, modes = scipy.linalg.eigh(M, K, subset_by_index=[len(M) - MODES, len(M) - 1])  # 1 / omega^2
    omega = NEAR / np.sqrt(compliance[-1])
    q = modes.T @ structure.force / (1 - omega**2 * compliance + 2j * RATIO * omega * np.sqrt(compliance))
    u = displacements(structure, modes @ q)
    found = of_displacements(mesh_of(structure), np.concatenate([0 * u.real, u.real, -u.imag]))
    hertz = omega / (2 * np.pi)
    step = (f"*STEP\n*FREQUENCY, STORAGE=YES\n{MODES}\n*END STEP\n*STEP\n*STEADY STATE DYNAMICS\n{hertz:.12g}, {hertz * 1.001:.12g}, 2\n"
            f"*MODAL DAMPING\n1, {MODES}, {RATIO}\n{{load}}*EL FILE\nS\n*END STEP\n")
    path = run_ccx(tmp_path, "steady", deck("C3D20R", step))
    real, imaginary = nodal(path), nodal(path, "STRESSI")
    largest = np.hypot(real, imaginary).max()
    np.testing.assert_allclose(found.series[1], real, rtol=0, atol=1e-3 * largest)
    np.testing.assert_allclose(-found.series[2], imaginary, rtol=0, atol=1e-3 * largest)
    instants = np.cos(TURNS)[:, None, None] * real - np.sin(TURNS)[:, None, None] * imaginary  # half a period later the opposite
    np.testing.assert_allclose(fatigue.sines(found.series)[1], fatigue.von_mises(instants).max(axis=0), rtol=0, atol=1e-3 * largest)
