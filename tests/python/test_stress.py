"""Strain and stress at nodes, fatigue criteria, and the command stress: closed forms, numbers by hand, an independent computation."""

import csv
import itertools

import brick
import numpy as np
import pytest
import ring
from ring_results import computed

from dovetail import fatigue, solids
from dovetail.__main__ import main
from dovetail.life import life
from dovetail.material import Material
from dovetail.model_mesh import checked_mesh
from dovetail.motion import read_model_parts
from dovetail.nodal_stress import nodal_stress, of_displacements
from dovetail.reactions import held_forces
from dovetail.strains import cell_forces, cell_stress
from dovetail.units import bracket

YOUNG, POISSON = 3.0, 0.3
SHEAR = YOUNG / (2 * (1 + POISSON))
LAME = 2 * SHEAR * POISSON / (1 - 2 * POISSON)
AFFINE = np.array([[1.1, 0.2, -0.1], [0.15, 0.8, 0.3], [0.05, -0.2, 1.3]])
STRENGTHS = ["--fatigue-strength", "200", "--tensile", "500"]


def stress_of(gradient):
    """(6,) by Hooke's law of one displacement gradient (3, 3)."""
    strain = (gradient + gradient.T) / 2
    stress = 2 * SHEAR * strain + LAME * np.trace(strain) * np.eye(3)
    return stress[[0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]]


def cell(kind, distortion=0.0):
    """(w, 3) places of the nodes of a cell, an affine image of the reference cell with its nodes moved at random."""
    places = solids.places(kind) @ AFFINE.T
    return places + distortion * np.random.default_rng(1).uniform(-1, 1, places.shape)


def at_nodes(kind, integration, X, u):
    return cell_stress(kind, integration, X[None], u[None, None], np.array([YOUNG]), np.array([POISSON]))[0, 0]


@pytest.mark.parametrize("kind, integration", solids.POINTS)
def test_constant_strain_is_exact(kind, integration):
    """Patch test on distorted cells; incompatible modes, those of CalculiX, pass it on parallelepipeds alone."""
    X = cell(kind, 0.0 if integration == solids.INCOMPATIBLE else 0.1)
    gradient = np.random.default_rng(2).standard_normal((3, 3))
    wanted = stress_of(gradient)
    np.testing.assert_allclose(at_nodes(kind, integration, X, X @ gradient.T), np.tile(wanted, (len(X), 1)), rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind, integration", [("tetra10", solids.USUAL), ("wedge15", solids.USUAL), ("hexahedron20", solids.USUAL),
                                               ("hexahedron20", solids.FULL), ("hexahedron", solids.INCOMPATIBLE)])
def test_bending_is_exact(kind, integration):
    """Pure bending: sigma_xx = E y / R, all else zero. C3D8I has it from its incompatible modes, on a brick along the axes."""
    X = solids.places(kind) * [2.0, 0.5, 0.7] if integration == solids.INCOMPATIBLE else cell(kind)
    x, y, z = X.T
    u = np.column_stack([x * y, -(x**2 + POISSON * (y**2 - z**2)) / 2, -POISSON * y * z])
    stress = at_nodes(kind, integration, X, u)
    np.testing.assert_allclose(stress[:, 0], YOUNG * y, rtol=0, atol=1e-11)
    np.testing.assert_allclose(stress[:, 1:], 0, rtol=0, atol=1e-11)


@pytest.mark.parametrize("kind, integration", solids.POINTS)
def test_forces_of_a_constant_stress(kind, integration):
    """They are in balance, and their moments are the stress times the volume: sum of f_i x_j = sigma_ij V."""
    X = cell(kind)
    stress = np.array([[2, 1, -1], [1, 3, 0.5], [-1, 0.5, -2]])
    strain = (stress - LAME / (3 * LAME + 2 * SHEAR) * np.trace(stress) * np.eye(3)) / (2 * SHEAR)
    args = X[None], (X @ strain.T)[None, None], np.array([YOUNG]), np.array([POISSON])
    force = cell_forces(kind, integration, *args)[0, 0]
    volume = {"tetra": 1 / 6, "wedge": 1, "hexahedron": 8}[solids.SHAPE[kind]] * np.linalg.det(AFFINE)
    np.testing.assert_allclose(force.sum(axis=0), 0, atol=1e-12)
    np.testing.assert_allclose(force.T @ X, stress * volume, rtol=0, atol=1e-11)


def test_reactions_balance_the_load():
    """A block held below, in one place in two directions only, under a static load: force and moment."""
    block = brick.pair(young=YOUNG, poisson=POISSON).with_material(YOUNG, POISSON)
    glued = block.clamped("bottom").clamped([block.node_sets["lower"][4]], "xy").with_force("lower", [1.0, -2.0, 3.0])
    under = np.flatnonzero(np.isin(glued.dof_node, glued.node_sets["under"]))
    u = np.zeros((1, len(glued.nodes), 3))
    u[0, glued.dof_node[under], glued.dof_direction[under]] = np.linalg.solve(glued.K[under][:, under].toarray(), glued.force[under])
    mesh = checked_mesh({"nodes": glued.nodes, "cells": glued.cells, "dof_node": glued.dof_node, "dof_direction": glued.dof_direction,
                         "materials": glued.materials, "material": glued.material}, glued.n)
    at = np.append(glued.node_sets["bottom"], block.node_sets["lower"][4])
    found = held_forces(mesh, u, at)[0]
    load = np.zeros_like(u[0])
    load[glued.dof_node, glued.dof_direction] = glued.force
    np.testing.assert_allclose(found.sum(axis=0), -load.sum(axis=0), atol=1e-12)
    np.testing.assert_allclose(np.cross(glued.nodes[at], found).sum(axis=0), -np.cross(glued.nodes, load).sum(axis=0), atol=1e-11)
    assert found[-1, 2] == 0 and held_forces(mesh, u, glued.node_sets["top"]) is None


def test_stress_is_not_averaged_where_materials_meet():
    """Two bricks in a row under the same strain: nodes between them have a stress of each."""
    nodes, cells = brick.grid((0, 0, 0), (2, 1, 1), (2, 1, 1))
    mesh = {"nodes": nodes, "cells": {"hexahedron": cells, "line": np.array([[0, 1]])},
            "materials": [Material(1.0, 0.0), Material(4.0, 0.0)],
            "material": {"hexahedron": np.array([0, 1]), "line": np.array([-1])},
            "integration": {"hexahedron": np.zeros(2, int), "line": np.zeros(1, int)}}
    found = of_displacements(mesh, (nodes * [0.5, 0, 0])[None])
    assert len(found.node) == len(nodes) + 4 and found.left_out == {"line": 1}
    for number, young in enumerate((1.0, 4.0)):
        mine = found.material == number
        np.testing.assert_allclose(found.series[0, mine, 0], 0.5 * young, rtol=1e-13)
        np.testing.assert_array_equal(np.sort(found.node[mine]), np.unique(cells[number]))


def courses(*tensors):
    """(2H+1, 1, 6) of [a0, a1, b1, ...] tensors."""
    return np.array(tensors, dtype=float)[:, None]


X, XY, NONE = [1, 0, 0, 0, 0, 0], [0, 0, 0, 1, 0, 0], [0] * 6


@pytest.mark.parametrize("criterion", fatigue.CRITERIA)
def test_tension_by_hand(criterion):
    """100 + 50 sin: 50/200 + 100/500 of the strength. Under -100 the mean is no help: 50/200."""
    for mean, wanted in ((100.0, 0.45), (-100.0, 0.25)):
        found = fatigue.CRITERIA[criterion](courses(2 * mean * np.array(X), NONE, 50 * np.array(X)))
        np.testing.assert_allclose(np.ravel(found), [mean, 50], rtol=1e-12)
        assert fatigue.goodman(*found, fatigue.Strength(200, 500))[0] == pytest.approx(wanted, rel=1e-12)


def test_sines_by_hand():
    """Torsion 30 on a mean of 90, 60 and 0: mean 150, amplitude sqrt(3) 30. Tension and torsion a quarter of a period apart: the
    path is an ellipse with half axes 50 and sqrt(3) 20. Harmonics 1 and 2 in tension: half the peak-to-peak."""
    mean, amplitude = fatigue.sines(courses(2 * np.array([90, 60, 0, 5, 0, 0]), 30 * np.array(XY), NONE))
    np.testing.assert_allclose([mean[0], amplitude[0]], [150, 30 * np.sqrt(3)], rtol=1e-12)
    assert fatigue.sines(courses(NONE, 50 * np.array(X), 20 * np.array(XY)))[1] == pytest.approx(50, rel=1e-12)
    a, b = 10, 7  # a cos + b cos 2: highest a + b, lowest -b - a^2 / 8 b
    mean, amplitude = fatigue.sines(courses(NONE, a * np.array(X), NONE, b * np.array(X), NONE))
    low = -b - a**2 / (8 * b)
    np.testing.assert_allclose([mean[0], amplitude[0]], [(a + b + low) / 2, (a + b - low) / 2], rtol=1e-10)


def test_criteria_do_not_depend_on_where_the_period_begins():
    rng = np.random.default_rng(3)
    H, shift = 3, 0.7
    series = rng.standard_normal((2 * H + 1, 40, 6)) * (0.4 ** ((np.arange(2 * H + 1) + 1) // 2))[:, None, None]
    k = np.arange(1, H + 1)[:, None, None]
    later = series.copy()
    later[1::2] = np.cos(k * shift) * series[1::2] + np.sin(k * shift) * series[2::2]
    later[2::2] = np.cos(k * shift) * series[2::2] - np.sin(k * shift) * series[1::2]
    np.testing.assert_allclose(fatigue.sines(later), fatigue.sines(series), rtol=1e-6)


def test_principal_stresses_by_hand():
    np.testing.assert_allclose(fatigue.principal([3, 1, -2, 0, 0, 0]), [3, 1, -2], atol=1e-14)
    np.testing.assert_allclose(fatigue.principal([0, 0, 5, 4, 0, 0]), [5, 4, -4], atol=1e-14)
    assert fatigue.von_mises([0, 0, 0, 4, 0, 0]) == pytest.approx(4 * np.sqrt(3)) and fatigue.von_mises([7, 7, 7, 0, 0, 0]) < 1e-14


@pytest.fixture(scope="module", params=[True, False], ids=["sector", "alone"])
def ringed(request, tmp_path_factory):
    return computed(tmp_path_factory.mktemp("ring"), cyclic=request.param)


def by_hand(nodes, cells, u, node, young, poisson):
    """Stress (3, 3) at a node: from Gauss points of the bricks around it, by the trilinear weights (1 +- sqrt 3) / 2, and their mean."""
    shear, found = young / (2 * (1 + poisson)), []
    for rows in cells[(cells == node).any(axis=1)]:
        own, stress = 2 * brick.CORNERS[np.flatnonzero(rows == node)[0]] - 1, np.zeros((3, 3))
        for point in itertools.product((-1, 1), repeat=3):
            factors = 1 + (2 * brick.CORNERS - 1) * np.array(point) / np.sqrt(3)
            local = np.stack([(2 * brick.CORNERS[:, i] - 1) * np.delete(factors, i, axis=1).prod(axis=1) / 8 for i in range(3)])
            gradient = (np.linalg.solve(local @ nodes[rows], local) @ u[rows]).T
            strain = (gradient + gradient.T) / 2
            at_point = 2 * shear * (strain + poisson / (1 - 2 * poisson) * np.trace(strain) * np.eye(3))
            stress += np.prod((1 + own * np.array(point) * np.sqrt(3)) / 2) * at_point
        found.append(stress)
    return np.mean(found, axis=0)


def test_stress_of_results_is_that_of_their_displacements(ringed):
    """With friction and preload, at instants of the period; the worst node and one on the inner side."""
    point = ringed.largest_point("x1.t1")
    assert ringed.points("slip")[point] + ringed.points("open")[point] > 0
    young, poisson = ring.MATERIAL["young"], ring.MATERIAL["poisson"]
    found = nodal_stress(ringed, point, material=Material(young, poisson))
    mesh, _ = read_model_parts(ringed.path.with_name("model.h5"))
    u = ringed.displacement(point, n=16)
    scale = np.abs(found.series).max()
    for node in (int(found.node[life(found).worst(1)[0]]), 0):
        for i in (0, 3, 11):
            wanted = by_hand(mesh["nodes"], mesh["cells"]["hexahedron"], u[i], node, young, poisson)[[0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]]
            np.testing.assert_allclose(found.at(2 * np.pi * i / 16)[found.node == node][0], wanted, rtol=0, atol=1e-11 * scale)


def test_exported_stress_of_another_sector(ringed, tmp_path):
    """Along the axes of the model, from the displacements that stand beside it."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    sector = ["--sector", "3"] if ringed.wave else []
    material = ["--material", str(ring.MATERIAL["young"]), str(ring.MATERIAL["poisson"])]
    options = [*sector, *material, *STRENGTHS, "--frames", "3", "--wear", "1e-3"]
    assert main(["export", str(ringed.path), *options, "-o", str(tmp_path / "out")]) == 0
    fields = []
    for name in ("motion_002.vtu", "contact_002.vtu"):
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(tmp_path / "out" / name))
        reader.Update()
        data = reader.GetOutput().GetPointData()
        fields.append({data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())})
        fields[-1]["places"] = vtk_to_numpy(reader.GetOutput().GetPoints().GetData())
    found, contact = fields
    mesh, _ = read_model_parts(ringed.path.with_name("model.h5"))
    u = found["displacement"].astype(float)
    for node in (0, 7):
        places, cells = found["places"].astype(float), mesh["cells"]["hexahedron"]
        wanted = by_hand(places, cells, u, node, ring.MATERIAL["young"], ring.MATERIAL["poisson"])
        wanted = wanted[[0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]]
        np.testing.assert_allclose(found["stress"][node], wanted, rtol=0, atol=2e-5 * np.abs(found["stress"]).max())
    np.testing.assert_allclose(found["von_mises"], fatigue.von_mises(found["stress"]), rtol=1e-4, atol=1e-5 * found["von_mises"].max())
    np.testing.assert_allclose(found["utilisation"], found["stress_amplitude"] / 200 + np.maximum(found["stress_mean"], 0) / 500, rtol=1e-5)
    per = contact["friction_energy_per_area"]
    np.testing.assert_allclose(contact["wear_depth_per_million_periods"], 1e3 * per, rtol=1e-5)
    assert per.max() > 0
    np.testing.assert_allclose(contact["friction_power_per_area"] / per.max(), per / per.max() * ringed.frequency[shown(ringed)], rtol=1e-4)


def shown(results):
    from dovetail.shown import chosen_point, default_dofs

    return chosen_point(results, dofs=default_dofs(results))


def test_the_command(ringed, tmp_path, capsys):
    assert main(["stress", str(ringed.path)]) == 2
    assert "have no material; say --material E NU here, or give the model one: with_material(E, nu)" in capsys.readouterr().err
    table, picture = tmp_path / "s.csv", tmp_path / "s.png"
    words = ["stress", str(ringed.path), "--material", "100", "0.3", "--worst", "4"]
    assert main([*words, *STRENGTHS, "-o", str(table), *([] if ringed.wave else [str(picture)])]) == 0
    said = capsys.readouterr().out
    with open(table) as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0])[1:4] == [axis + bracket(ringed.unit.length) for axis in "xyz"]
    used = np.array([float(row["utilisation"]) for row in rows])
    worst = np.argsort(-used)[:4]
    listed = [line.split() for line in said.split("utilisation", 1)[1].splitlines()[1:5]]
    assert [line[0] for line in listed] == [rows[i]["node"] for i in worst] and (ringed.wave or picture.stat().st_size > 10000)
    np.testing.assert_allclose([float(line[8]) for line in listed], used[worst], rtol=1e-3)
    left_out = set(map(str, read_model_parts(ringed.path.with_name("model.h5"))[0]["sets"]["bore"]))
    assert main([*words, *STRENGTHS, "--without", "bore"]) == 0
    without = [line.split()[0] for line in capsys.readouterr().out.split("utilisation", 1)[1].splitlines()[1:5]]
    assert without == [rows[i]["node"] for i in np.argsort(-used) if rows[i]["node"] not in left_out][:4] != [line[0] for line in listed]
    (tmp_path / "strengths.csv").write_text("material,fatigue_strength,tensile_strength\ngiven,200,500\n")
    assert main([*words, "--strengths", str(tmp_path / "strengths.csv")]) == 0
    again = [line for line in capsys.readouterr().out.splitlines() if line in said]
    assert len(again) >= 8


@pytest.mark.parametrize("options, words", [
    (["--fatigue-strength", "3"], "--fatigue-strength and --tensile together make the line of Goodman; give both"),
    (["--fatigue-strength", "-3", "--tensile", "5"], "strengths must be positive and finite, found fatigue strength -3"),
    (["--material", "-1", "0.3"], "must have a positive Young's modulus"),
    (["--without", "x"], "--without: there is no node set 'x'; there are bore, "),
    (["--reaction", "over_left"], "no node of 'over_left' is held"), (["--reaction", "x"], "there is no node set 'x'; there are bore, "),
    (["--worst", "0"], "--worst: 1 or more points are wanted, found 0"),
    (["-o", "s.txt"], "a table is written as FILE.csv, a picture as FILE.png; found the ending .txt"),
    (["--strengths", "s.csv"], "s.csv, line 2: wanted a material and two strengths, found steel,1"),
    (["--strengths", "t.csv"], "t.csv: has none of the materials of the model, given"),
    (["--strengths", "u.csv"], "u.csv, line 1: wanted the header material,fatigue_strength,tensile_strength, found a")])
def test_refusals(ringed, options, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name, text in (("s", "steel,1"), ("t", "steel,1,2")):
        (tmp_path / f"{name}.csv").write_text(f"material,fatigue_strength,tensile_strength\n{text}\n")
    (tmp_path / "u.csv").write_text("a\n")
    assert main(["stress", str(ringed.path), "--material", "100", "0.3", *options]) == 2
    assert words in capsys.readouterr().err


def test_materials_of_a_structure():
    pair = brick.pair().with_material(2.0, 0.1, 3.0, name="a").with_material(5.0, 0.2, name="b", where="under")
    assert pair.materials == [Material(2.0, 0.1, 3.0, "a"), Material(5.0, 0.2, 0.0, "b")]
    assert sorted(pair.material["hexahedron"]) == [0] * 8 + [1] * 8
    with pytest.raises(ValueError, match="there is no cell with all of its nodes among those of 'top'"):
        pair.with_material(1.0, 0.0, where="top")
    with pytest.raises(ValueError, match="between -1 and 0.5"):
        pair.with_material(1.0, 0.5)
