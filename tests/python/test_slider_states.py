"""Slider positions that other orders of preload leave: the states themselves, and runs that begin with them, against the reference."""

import json
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from scipy.stats import qmc

import cases
import launch
from dovetail import Results, ranges_report, reference
from dovetail.__main__ import main
from dovetail.case_runs import PreloadedRun
from dovetail.slider_states import NAMED, slider_states, sticking
from launch import BINARY


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """Four contact points with preload: the case with samples as the reference has them, and its results at one frequency."""
    folder = tmp_path_factory.mktemp("sliders")
    case = cases.several_points(folder, omega=[1.02, 1.02], friction=1.5, fourier=[0, 0.4])
    return case, Results(launch.run(case).folder / "results.h5")


def reached(case, results, w_0, folder):
    """Results of a run that begins with the sliders at w_0."""
    text = case.path.read_text().replace('model = "model.h5"', 'reduced = "preloaded.h5"')
    text = "\n".join(line for line in text.splitlines() if line not in ("[reduction]", "modes = 5"))
    run = PreloadedRun(None, folder, text, "", source=results.path.parent / "reduced.h5", w_0=w_0)
    run.prepare()
    return Results(launch.run(cases.Case(folder / "case.toml", None, None, {})).folder / "results.h5")


def as_they_are(case, run, w_0):
    """The preload state of such a run in the displacements of the case: `reference.Preload`."""
    foot = np.column_stack([w_0, np.zeros(len(w_0))])
    return reference.Preload(run.xp.reshape(-1, 3) + foot, run.g.reshape(-1, 3), run.w + w_0)


def test_runs_begin_with_the_friction_that_was_asked_for(scene, tmp_path):
    """In every state loads balance, and friction is the part of its bound; the response is the reference's with those sliders."""
    case, results = scene
    states = slider_states(results, results.path.parent / "reduced.h5", 2, 1)
    assert [name for name, _ in states] == [*NAMED, "state 1", "state 2"] and sticking(results).sum() >= 2
    contact, moved = case.contact, []
    for number in (1, 5):
        name, w_0 = states[number]
        run = reached(case, results, w_0, tmp_path / str(number))
        preload = as_they_are(case, run, w_0)
        balance = case.reduced.kxx @ preload.xp.ravel() + preload.g.ravel() + case.reduced.r
        assert np.abs(balance).max() < 1e-9 * np.abs(case.reduced.r).max()
        part = preload.g[:, :2] / (contact.mu * preload.g[:, 2:])
        force = contact.kt * (preload.xp[:, :2] - preload.w)
        rubs = sticking(results)
        np.testing.assert_allclose(force[rubs], preload.g[rubs, :2], atol=1e-9)
        assert np.abs(part[rubs]).max() < 1 + 1e-9
        if number == 1:
            np.testing.assert_allclose(part[rubs], np.tile([1.0, 0.0], (rubs.sum(), 1)), atol=1e-7)
        system = case.system()
        system.preload = preload
        q = run.coefficients_at(0)
        assert np.linalg.norm(system.residual(q, 1.02)) < 1e-7 * np.linalg.norm(system.excitation)
        moved.append(np.linalg.norm(q - results.coefficients_at(0)) / np.linalg.norm(q))
    assert max(moved) > 1e-3


def test_no_friction_is_no_friction(scene, tmp_path):
    case, results = scene
    name, w_0 = slider_states(results, results.path.parent / "reduced.h5", 0, 1)[0]
    run = reached(case, results, w_0, tmp_path / "none")
    assert name == "no friction" and np.abs(results.g.reshape(-1, 3)[:, :2]).max() > 1e-3
    assert np.abs(run.g.reshape(-1, 3)[sticking(results), :2]).max() < 1e-8


def test_more_states_go_on_with_those_that_are_there(scene):
    _, results = scene
    few, many = (slider_states(results, results.path.parent / "reduced.h5", count, 3) for count in (2, 5))
    for (name, w_0), (other, same) in zip(few, many):
        assert name == other and np.array_equal(w_0, same)


def test_only_points_that_stick_take_dimensions_of_the_sequence(scene, monkeypatch):
    """Sobol's sequence has 21201 dimensions at most."""
    _, results = scene
    stuck = np.array([True, False, True, True])
    monkeypatch.setattr("dovetail.slider_states.sticking", lambda _: stuck)
    monkeypatch.setattr(qmc.Sobol, "MAXDIM", 2 * stuck.sum())
    states = slider_states(results, results.path.parent / "reduced.h5", 3, 1)[len(NAMED):]
    assert len(states) == 3
    for _, w_0 in states:
        assert np.all(w_0[stuck] != 0) and not w_0[~stuck].any()


def test_states_without_a_peak_are_named():
    """Curves of records are no matter, whatever holds them."""
    records = [{"status": 0, "peak": True, "omega": 1.0, "amplitude": 2.2}, {"status": 0, "peak": True, "omega": 1.1, "amplitude": 1.8},
               {"status": 0, "peak": False, "omega": 1.0, "amplitude": 9.0}, {"status": 1, "reason": "it stopped"}]
    sliders = [(name, record | {"curve": np.ones(3)}) for name, record in zip("abcd", records)]
    said = ranges_report._sliders(SimpleNamespace(sliders=sliders, middle={"amplitude": 2.0, "omega": 1.0}))
    assert said[2] == "caution: no peak with c, d" and len(said) == 5
    assert "amplitude -10 % (b) to +10 % (a)" in said[3] and "frequency +0 % (a) to +10 % (b)" in said[4]


@pytest.mark.slow
def test_the_command(tmp_path, capsys, monkeypatch):
    """Names of the least and the largest peak, the states themselves in ranges.json; nothing is computed twice."""
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", lambda *_, **__: None)
    case = cases.several_points(tmp_path, omega=[0.8, 1.4], friction=1.5, fourier=[0, 0.4], samples="exact", kind="auto")
    command = ["range", str(case.path), "--sliders", "2", "--watch", "a1", "--binary", str(BINARY)]
    assert main(command) == 0
    said = capsys.readouterr()
    numbers = json.loads((tmp_path / "case_range/ranges.json").read_text())
    assert [entry["name"] for entry in numbers["sliders"]] == [*NAMED, "state 1", "state 2"]
    amplitudes = [entry["amplitude"] for entry in numbers["sliders"] if entry["peak"]]
    low, high = (100 * (end / numbers["middle"]["amplitude"] - 1) for end in (min(amplitudes), max(amplitudes)))
    assert f"amplitude {low:+.3g} %" in said.out and f"to {high:+.3g} %" in said.out and high > low
    assert main(command) == 0
    assert "sliders: 7 of 7 are there from before" in capsys.readouterr().err


def test_refusals(tmp_path, capsys):
    case = cases.dof5(tmp_path, omega=[1.0, 1.02], harmonics=1, samples="exact")
    assert main(["range", str(case.path), "--sliders", "0", "--binary", str(BINARY)]) == 2
    assert "nothing to vary" in capsys.readouterr().err
    with h5py.File(tmp_path / "model.h5", "r+") as file:
        file["preload"][...] = 0
    case.edit("gap = -3.5", "gap = 3.5")
    assert main(["range", str(case.path), "--sliders", "2", "--watch", "a1", "--binary", str(BINARY)]) == 2
    assert "no contact point with friction is pressed" in capsys.readouterr().err
