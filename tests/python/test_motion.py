"""Motion of nodes through joints; the map of a joint; pictures of meshes and joints."""

import brick
import h5py
import matplotlib.pyplot as plt
import meshio
import numpy as np
import pytest
import synthetic_results
from lattice import lattice
from test_joint import transformation

from dovetail import Joint, Results
from dovetail.__main__ import main
from dovetail.contact_map import contact_map, in_plane, lying, over_period
from dovetail.info import describe
from dovetail.mesh_picture import MOST_TRIANGLES, joint_picture, mesh_picture, skin
from dovetail.motion import find_model, read_model_parts
from dovetail.plot import history, response
from dovetail.shown import default_dofs, loaded_node


@pytest.fixture(autouse=True)
def closed():
    """Figures that a test has drawn."""
    yield
    plt.close("all")


@pytest.fixture
def run(tmp_path):
    """A joined pair, and a results file with one point and random recovery matrices: model, Results, and the unknowns q(t) (8, n)."""
    structure = brick.pair(over=(3, 4, 1)).clamped("bottom")
    joint = Joint.between(structure.surface("upper"), structure.surface("lower"), name="middle")
    model = structure.join([joint])
    model.write(tmp_path / "model.h5")
    rng, modes = np.random.default_rng(3), 2
    contact = model.contact_dofs.ravel()
    elastic = rng.permutation(np.setdiff1d(np.arange(model.n), contact))  # any order will do
    n_c, n_e = contact.size, elastic.size
    recovery = {"Phi": rng.standard_normal((n_e, modes)), "Psi": rng.standard_normal((n_e, n_c)), "xe0": rng.standard_normal(n_e)}
    with h5py.File(tmp_path / "reduced.h5", "w") as file:
        file.attrs.update({"format": "dovetail-reduced", "model": "elsewhere/model.h5"})
        for name, values in {**recovery, "elastic_dofs": elastic, "contact_dofs": model.contact_dofs}.items():
            file[f"recovery/{name}"] = values
    coefficients, xp = rng.standard_normal((1, modes + n_c, 3)), rng.standard_normal(n_c)
    points = n_c // 3
    parameters = {"normal_stiffness": np.ones(points), "tangential_stiffness": np.ones((points, 2)), "friction": np.ones((points, 2)),
                  "gap": np.zeros(points)}
    path = synthetic_results.write(tmp_path / "results.h5", [2.0], coefficients, modes, parameters, xp=xp, reduced="reduced.h5")
    theta = 2 * np.pi * np.arange(8) / 8
    motion = np.stack([np.full(8, 0.5), np.cos(theta), np.sin(theta)], axis=1) @ coefficients[0].T
    q = np.empty((8, model.n))
    q[:, contact] = motion[:, modes:] + xp
    q[:, elastic] = recovery["xe0"] + motion[:, :modes] @ recovery["Phi"].T + q[:, contact] @ recovery["Psi"].T
    return model, Results(path), q


def test_displacement_of_nodes(run):
    model, results, q = run
    u = (transformation(model) @ q.T).T
    wanted = np.zeros((8, len(model.mesh["nodes"]), 3))
    wanted[:, model.mesh["dof_node"], model.mesh["dof_direction"]] = u
    np.testing.assert_allclose(results.displacement(0, n=8), wanted, atol=1e-12)
    assert not wanted[:, model.mesh["sets"]["bottom"]].any()
    np.testing.assert_allclose(results.displacement(0, "upper", n=8), wanted[:, model.mesh["sets"]["upper"]], atol=1e-12)
    np.testing.assert_allclose(results.displacement(0, [40, 3], times=[np.pi / 8]), wanted[1:2, [40, 3]], atol=1e-12)
    np.testing.assert_allclose(results.unknowns(0, [7, 5, 100, 5], 8), q[:, [7, 5, 100, 5]], atol=1e-12)
    np.testing.assert_allclose(results.displacement(0, [40, 3, 40], times=[np.pi / 8]), wanted[1:2, [40, 3, 40]], atol=1e-12)
    with pytest.raises(ValueError, match="no set 'uper'; there are bottom"):
        results.displacement(0, "uper")


def test_exported_contact_points_move_with_side_a(run, tmp_path):
    """Partners have one place; the points of a joint are nodes of its first surface, on the whole mesh and on its outer faces."""
    model, results, _ = run
    nodes, upper = model.mesh["nodes"], model.mesh["sets"]["upper"]
    sides = [rows[np.linalg.norm(nodes[rows] - place, axis=1).argmin()] for rows, place in
             ((upper, place) for place in model.joint["position"])]
    wanted = results.displacement(0, sides, n=2)
    for options in ([], ["--surface"]):
        assert main(["export", str(results.path), "--frames", "2", "--replace", "-o", str(tmp_path / "out"), *options]) == 0
        for i in range(2):
            data = meshio.read(tmp_path / f"out/contact_{i:03d}.vtu").point_data
            np.testing.assert_allclose(data["displacement"], wanted[i], rtol=0, atol=1e-6 * np.abs(wanted).max())


def test_motion_that_was_not_kept_is_refused(run):
    model, results, _ = run
    with h5py.File(results.reduced, "r+") as file:
        kept = file["recovery/elastic_dofs"][:50]
        for name in ("elastic_dofs", "Phi", "Psi", "xe0"):
            values = file[f"recovery/{name}"][:50]
            del file[f"recovery/{name}"]
            file[f"recovery/{name}"] = values
    results.unknowns(0, kept)
    with pytest.raises(ValueError, match="keeps 50 elastic degrees of freedom, and .* of the ones wanted"):
        results.displacement(0)


def test_model_file_is_found_or_asked_for(run, tmp_path):
    _, results, _ = run
    results.displacement(0, [0])  # the name in the reduced file is out of date, but the model lies beside the results
    (tmp_path / "model.h5").rename(tmp_path / "moved.h5")
    with pytest.raises(ValueError, match=r"the model file of .* is not there \(elsewhere/model.h5\); name it with --model"):
        results.displacement(0, [0])
    results.displacement(0, [0], model=tmp_path / "moved.h5")
    with pytest.raises(ValueError, match="format must be dovetail-model, found dovetail-results"):
        results.displacement(0, [0], model=results.path)


def test_curve_of_a_node_is_the_motion_of_that_node(run):
    _, results, _ = run
    mesh, _ = read_model_parts(find_model(results))
    upper, free = mesh["sets"]["upper"], int(mesh["dof_node"].max())
    for name, nodes in (("upper.x", upper), (f"{free}.y", [free]), ("upper.z", upper)):
        motion = results.displacement(0, nodes, n=8)[:, :, "xyz".index(name[-1])].mean(axis=1)
        curve = results.response(name)
        t, q = results.time_history(0, name, 8)
        np.testing.assert_allclose(q - q.mean(), motion - motion.mean(), atol=1e-12)  # one is from the preload state
        assert curve.amplitude[0] == results.amplitude(name)[0] == pytest.approx(np.hypot(*curve.coefficients[0, 1:]), rel=1e-12)
        assert curve.unit == "m" and curve.frequency[0] == pytest.approx(1 / np.pi)
    assert [curve.name for curve in results.response([f"{free}.y", "x1.t1"])] == [f"{free}.y", "x1.t1"]


def test_names_of_nodes_and_their_errors(run):
    _, results, _ = run
    for name, message in (("uper.x", "no node or node set 'uper', as in 'uper.x'; there are nodes 0 to .*, and sets bottom"),
                          ("4000.x", "no node or node set '4000'"), ("bottom.z", "bottom does not move along z: it is held there")):
        with pytest.raises(ValueError, match=message):
            results.amplitude(name)
    with pytest.raises(KeyError, match="and node sets or nodes of the model with .x, .y and .z"):
        results.amplitude("upper.q")


def test_default_picture_shows_the_loaded_node_first(run, tmp_path, capsys):
    model, results, _ = run
    assert loaded_node(results) is None  # nothing is
    force = np.zeros(model.n)
    mesh = model.mesh
    free = np.setdiff1d(np.flatnonzero(mesh["dof_direction"] == 1), mesh["changed"]["dof"])
    force[free[-1]] = -3.0
    model.with_loads(force=force).write(tmp_path / "model.h5")
    node = mesh["dof_node"][free[-1]]
    names = [name for name, nodes in mesh["sets"].items() if list(nodes) == [node]]
    wanted = f"{names[0] if names else node}.y"
    assert loaded_node(results) == wanted and default_dofs(results)[0] == wanted
    figure = response(results)
    assert [axis.get_ylabel() for axis in figure.axes] == ["amplitude", "relative amplitude", "points [%]"]
    assert figure.axes[0].get_legend().get_texts()[0].get_text().startswith(wanted)
    assert main(["plot", str(results.path), "--dof", "upper.x", "x1.t1", "--model", str(tmp_path / "model.h5")]) == 0
    for options, words in ((["--kind", "map"], "is a model, of which the mesh is drawn"), (["--at", "1"], "--at: changes nothing")):
        assert main(["plot", str(tmp_path / "model.h5"), *options]) == 2 and words in capsys.readouterr().err
    (tmp_path / "model.h5").unlink()
    assert loaded_node(Results(results.path)) is None  # and there is still a picture
    assert len(response(Results(results.path)).axes) == 2
    assert main(["plot", str(results.path), "--dof", "upper.x"]) == 2
    assert "name it with --model" in capsys.readouterr().err


@pytest.mark.parametrize("units, length, work, place", [("t, mm, s, N", "[mm]", "[mJ/mm²]", "x [mm]"),
                                                        pytest.param("furlongs", "", "", "x", marks=pytest.mark.slow)])
def test_pictures_are_in_the_units_of_the_model(run, tmp_path, units, length, work, place):
    model, results, _ = run
    with h5py.File(results.path, "r+") as file:
        file.attrs["units"] = units
    results = Results(results.path)
    axes = response(results, ["upper.x", "x1.t1", "a1"]).axes
    assert [axis.get_ylabel() for axis in axes[:3]] == [f"{word} {unit}".strip() for word, unit in (
        ("amplitude", length), ("relative amplitude", length), ("modal amplitude", "[mm √t]" if length else ""))]
    axis = history(results, 0, ["x1.t1"]).axes[0]
    assert axis.get_ylabel() == f"motion from preload {length}".strip()
    figure = contact_map(results, 0)
    figure.canvas.draw()
    titles = [axis.get_title(loc="left") for axis in figure.axes]
    assert f"friction work per period and area {work}".strip() in titles
    assert figure.axes[0].get_xlabel() == f"t1 {length}".strip() or figure.axes[0].get_xlabel() == f"t2 {length}".strip()
    figure = mesh_picture(model.mesh, model.joint, units=units)
    assert figure.axes[0].get_xlabel() == place
    everything = [*axes, axis, *contact_map(results, 0).axes, *figure.axes]
    for axis in everything:
        assert not any(tick.get_text().endswith("m") for tick in axis.get_xticklabels() + axis.get_yticklabels())


def test_frequencies_are_right_where_time_is_in_milliseconds(run):
    _, results, _ = run
    with h5py.File(results.path, "r+") as file:
        file.attrs["units"] = "kg, mm, ms"
    results = Results(results.path)
    assert results.frequency[0] == pytest.approx(2.0 / (2 * np.pi) * 1000)
    assert response(results, ["x1.t1"]).axes[-1].get_xlabel() == "excitation frequency [rad/ms]"
    figure = response(results, ["x1.t1"], hz=True)
    assert figure.axes[-1].get_xlabel() == "excitation frequency [Hz]"
    assert figure.axes[0].lines[0].get_xdata()[0] == pytest.approx(results.frequency[0])
    assert "2 rad/ms (318.31 Hz)" in describe(results.path)


def test_states_and_work_over_a_period(tmp_path):
    """Four points moved by cos along t1 with N = 2 and mu = 0.5: stick, slip, at times open, always open; work in closed form."""
    coefficients = np.zeros((1, 12, 3))
    coefficients[0, ::3, 1] = [0.1, 3.0, 3.0, 3.0]
    coefficients[0, 8, 1] = 3.0  # opens for part of the period
    xp = np.tile([0.0, 0, 2], 4)
    xp[11] = -1.0
    contact = {"normal_stiffness": np.ones(4), "tangential_stiffness": 4 * np.ones((4, 2)), "friction": 0.5 * np.ones((4, 2)),
               "gap": np.zeros(4)}
    results = Results(synthetic_results.write(tmp_path / "r.h5", [1.0], coefficients, 0, contact, xp=xp))
    state, slipping, work = over_period(results, 0)
    np.testing.assert_array_equal(state, [0, 1, 2, 3])
    assert work[0] == 0 and work[3] == 0 and work[2] > 0 and slipping[0] == slipping[3] == 0
    assert work[1] == pytest.approx(4 * 1.0 * (3.0 - 1.0 / 4), rel=2e-3)  # 4 mu N (X - mu N / k_t)
    # it sticks while x comes back by 2 mu N / k_t = 0.5 from either end: cos from 1 to 1 - 0.5 / 3
    assert slipping[1] == pytest.approx(1 - np.arccos(1 - 0.5 / 3) / np.pi, abs=0.02)


def test_places_in_the_plane_of_a_joint():
    turn = brick.turned((1, 2, 3), 0.7, (5, 6, 7))
    flat = np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])
    axes = np.tile(turn(np.eye(3)) - turn(np.zeros((1, 3))), (4, 1, 1))
    np.testing.assert_allclose(in_plane(turn(flat), axes), flat[:, :2] - [1, 0.5], atol=1e-14)


def test_long_joints_lie_down():
    upright = np.array([[0.0, 0], [0, 3], [1, 3]])
    for places, names in ((upright, ("t2", "t1")), (upright[:, ::-1], ("t1", "t2"))):
        turned, axes = lying(places)
        assert axes == names
        np.testing.assert_array_equal(turned, upright[:, ::-1])


def test_map_has_a_row_for_each_joint(run):
    model, results, _ = run
    figure = contact_map(results, 0)
    titles = [axis.get_title(loc="left") for axis in figure.axes]
    assert titles.count("middle: slips [% of the period]") == 1 and "at 2 rad/s" in figure._suptitle.get_text()
    drawn = sum(len(collection.get_offsets()) for axis in figure.axes for collection in axis.collections
                if axis.get_xlabel() in ("t1", "t2"))
    assert drawn == 2 * len(model.contact_dofs)


def test_skin_is_the_outer_surface():
    structure = brick.pair(over=(3, 2, 2))
    triangles = skin(structure.nodes, structure.cells)
    area = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1).sum() / 2
    assert area == pytest.approx(2 * 10)  # two blocks 2 x 1 x 1


@pytest.mark.slow
def test_large_skins_are_thinned_without_holes():
    nodes, cells = brick.grid((0, 0, 0), (1, 1, 1), (70, 70, 20))
    triangles = skin(nodes, {"hexahedron": cells})
    assert 2 * (2 * 70 * 20 * 2 + 70 * 70) * 2 > len(triangles) and len(triangles) <= MOST_TRIANGLES
    size = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]) / 2
    assert np.linalg.norm(size, axis=1).sum() == pytest.approx(6, rel=0.05)
    np.testing.assert_allclose(size.sum(axis=0), 0, atol=1e-9)  # a closed surface


@pytest.mark.slow
def test_pictures_from_the_command_line(run, tmp_path, capsys):
    for words, name in ((["model.h5", "--up", "y"], "model_mesh.png"), (["results.h5", "--kind", "map"], "results_map.png")):
        assert main(["plot", str(tmp_path / words[0]), *words[1:]]) == 0
        assert capsys.readouterr().out.strip() == str(tmp_path / name)
        image = plt.imread(tmp_path / name)
        assert image.shape[0] > 300 and np.ptp(image[..., :3]) > 0.5
    assert main(["plot", str(tmp_path / "reduced.h5")]) == 2
    assert "format must be dovetail-results, found dovetail-reduced" in capsys.readouterr().err
    assert main(["plot", str(tmp_path / "results.h5"), "--kind", "map", "--model", str(tmp_path / "none.h5")]) == 2
    assert "none.h5" in capsys.readouterr().err
    assert main(["info", str(tmp_path / "model.h5")]) == 0
    told = capsys.readouterr().out
    assert "middle: 20 contact points, area 2" in told and "upper (20)" in told and "hexahedron" in told


def test_pictures_of_joints():
    a, b = lattice((4, 3), 6, lambda x, y: 0.01 + 0.002 * x, up=False), lattice((3, 2), 4, lambda x, y: 0 * x)
    figure = joint_picture([Joint.between(a, b, gap="geometry"), Joint.ground(a)])
    assert len([axis for axis in figure.axes if axis.name == "3d"]) == 2
    assert [axis.get_title() for axis in figure.axes if "everywhere" in axis.get_title()] == ["gap: 0 m everywhere"]


def test_mesh_without_faces_is_refused():
    with pytest.raises(ValueError, match="no cells with faces, only line"):
        mesh_picture({"nodes": np.zeros((2, 3)), "cells": {"line": np.array([[0, 1]])}})
