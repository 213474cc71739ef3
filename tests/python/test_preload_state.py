"""What info and the pressure map say about the joints under their preload."""

from types import SimpleNamespace

import brick
import h5py
import matplotlib.image
import numpy as np
import pytest

from dovetail import Joint, Results
from dovetail.__main__ import main
from dovetail.preload_state import at_edge, joint_states
from launch import run

CASE = """model = "model.h5"
reduction.modes = 3
damping.stiffness = 1e-7
excitation.fourier = [0, 1]
harmonic_balance.harmonics = 1
continuation.omega = [3000, 3000]
"""
FORCE = 1e4


@pytest.fixture(scope="module")
def plate(tmp_path_factory):
    """A thin plate that is pressed onto another one at its middle: its rim lifts."""
    folder = tmp_path_factory.mktemp("plate")
    structure = brick.pair(over=(8, 4, 1), under=(8, 4, 1), poisson=0.3, mapping=lambda points: points * [1, 1, 0.15], young=2e11,
                           density=7800.0).clamped("bottom")
    top = structure.node_sets["top"]
    structure.node_sets["bolt"] = top[np.linalg.norm(structure.nodes[top][:, :2] - [1, 0.5], axis=1) < 0.3]
    structure = structure.with_preload("bolt", [0, 0, -FORCE]).with_force("bolt", [0, 10, 0])
    joint = Joint.between(structure.surface("upper"), structure.surface("lower"), normal_stiffness=1e13, tangential_stiffness=5e12,
                          friction=0.3, name="plate")
    structure.join([joint]).write(folder / "model.h5")
    (folder / "case.toml").write_text(CASE)
    run(SimpleNamespace(path=folder / "case.toml"), out="out")
    return folder


def rim_of(position):
    return (abs(position[:, 0] - 1) > 0.99) | (abs(position[:, 1] - 0.5) > 0.49)


def test_points_inside_and_at_the_edge_of_a_joint():
    x, y = np.meshgrid(np.arange(5.0), 0.7 * np.arange(4.0), indexing="ij")
    inside = (x > 0) & (x < 4) & (y > 0) & (y < 2)
    np.testing.assert_array_equal(at_edge(np.column_stack([x.ravel(), y.ravel()])), ~inside.ravel())
    rings = np.concatenate([np.zeros((1, 2)), *(r * np.column_stack([np.cos(turn), np.sin(turn)]) for r, turn in
                                                ((r, 2 * np.pi * np.arange(6 * r) / (6 * r)) for r in (1, 2, 3)))])
    np.testing.assert_array_equal(at_edge(rings), np.linalg.norm(rings, axis=1) > 2.5)
    assert at_edge(np.zeros((2, 2)) + [[0], [1]]).all()


def test_the_joint_carries_the_preload_and_its_rim_is_open(plate):
    results = Results(plate / "out" / "results.h5")
    with h5py.File(plate / "model.h5") as file:
        joint = {key: file[f"contact/{key}"][()] for key in ("position", "axes", "area", "joint")} | {"names": ["plate"]}
    state, = joint_states(results, joint)
    np.testing.assert_allclose(state.normal.sum(), FORCE, rtol=1e-8)
    np.testing.assert_allclose(state.pressure @ state.area, FORCE, rtol=1e-8)
    np.testing.assert_array_equal(state.edge, rim_of(joint["position"]))
    gap = results.xp.reshape(-1, 3)[:, 2] - results.contact["gap"]
    np.testing.assert_array_equal(state.closed, gap > 0)
    assert 0 < state.closed.sum() < len(gap)


def test_info_says_it_joint_by_joint(plate, capsys, tmp_path):
    path = plate / "out" / "results.h5"
    assert main(["info", str(path)]) == 0
    said = capsys.readouterr().out
    pressed = Results(path).g.reshape(-1, 3)[:, 2] != 0
    closed = np.count_nonzero(pressed)
    assert f"preload               plate: {closed} of 45 points closed, normal force 10000 N, shear (0, 0) N, pressure" in said
    with h5py.File(plate / "model.h5") as file:
        unloaded = np.count_nonzero(rim_of(file["contact/position"][()]) & ~pressed)
    assert unloaded > 10 and f"{unloaded} at the edge unloaded" in said
    (tmp_path / "results.h5").write_bytes(path.read_bytes())  # without its reduced file, the model is not known
    assert main(["info", str(tmp_path / "results.h5")]) == 0
    assert f"preload               {closed} of 45 points closed, normal force 10000 N\n" in capsys.readouterr().out


def test_picture_of_the_pressure(plate, capsys, tmp_path):
    path = plate / "out" / "results.h5"
    assert main(["plot", str(path), "--kind", "pressure"]) == 0
    picture = plate / "out" / "results_pressure.png"
    assert capsys.readouterr().out.strip() == str(picture)
    shades = matplotlib.image.imread(picture)[:, :, :3]
    assert np.ptp(shades, axis=2).max() > 0.5  # colours, not axes alone
    (tmp_path / "results.h5").write_bytes(path.read_bytes())
    assert main(["plot", str(tmp_path / "results.h5"), "--kind", "pressure"]) == 2
    assert "with --model" in capsys.readouterr().err
    assert main(["plot", str(tmp_path / "results.h5"), "--kind", "pressure", "--model", str(plate / "model.h5")]) == 0


def test_pressures_are_shown_with_their_unit():
    from dovetail.plot_units import formatter, labelled

    assert formatter("Pa")(2.4e7) == "24 MPa" and labelled("pressure", "Pa") == "pressure"
    assert formatter("psi") is None and labelled("pressure", "psi") == "pressure [psi]"
