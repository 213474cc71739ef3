"""What is made of results of a sweep over a parameter of the joint: forces, loops and motion with its value at each point."""

import tomllib

import numpy as np
import pytest

import cases
import dovetail
from dovetail.contact_period import contact_period
from launch import BINARY, SURROUNDINGS

OMEGA = 1.02  # [rad/s], where the contact point slips
SAMPLES = 4096


@pytest.fixture
def run(tmp_path, monkeypatch):
    for name, value in SURROUNDINGS.items():
        monkeypatch.setenv(name, value)
    monkeypatch.chdir(tmp_path)  # from where a dict names files
    case = cases.dof5(tmp_path, omega=[OMEGA, OMEGA], samples="exact", step_tolerance=1e-9, residual_tolerance=1e-9)

    def run(folder, path=None, **changes):
        content = tomllib.loads(case.path.read_text())
        if path:
            del content["continuation"]["omega"]
            content["path"] = {"omega": OMEGA, **path}
        return dovetail.run(content, out=folder, binary=BINARY, **{"output.motion": "all", **changes})

    return run


def over(run, parameter, low, high):
    return run("path", {"parameter": parameter, "range": [low, high]})


def work(results, point):
    loops = (results.hysteresis(point, 1, direction, SAMPLES) for direction in (0, 1))
    return sum(np.sum((T + np.roll(T, -1)) / 2 * (np.roll(x, -1) - x)) for x, T in loops)


@pytest.mark.parametrize("parameter, low, high", [("friction", 1.0, 0.7), ("tangential_stiffness", 1.0, 1.3), ("gap", 0.0, -0.3),
                                                  ("normal_stiffness", 1.0, 1.2), ("preload", 1.0, 1.5), ("force", 1.0, 0.9)])
def test_loops_are_those_of_each_point(run, parameter, low, high):
    results = over(run, parameter, low, high)
    assert results.parameter[-1] == pytest.approx(high) and results.points("slip").min() == 1
    for point in (0, len(results) // 2, -1):
        assert work(results, point) == pytest.approx(results.dissipated(point, 1), rel=2e-4)
        period = contact_period(results, point, SAMPLES)
        activity = results.contact_activity(point)
        slips = np.mean(period.state == 1)
        assert slips == pytest.approx(activity.slip[0], abs=3e-3)


@pytest.mark.parametrize("parameter, factor, key, value", [
    ("friction", 0.7, "contact.friction", [0.7, 0.7]), ("tangential_stiffness", 1.3, "contact.tangential_stiffness", [1.3, 1.3]),
    ("gap", -0.3, "contact.gap", -3.8), ("preload", 1.5, "model", None)])
def test_the_end_is_the_run_with_that_value(run, tmp_path, parameter, factor, key, value):
    """Total forces and displacements, of elastic dofs too: a preload there moves them with the contact dofs held."""
    path = over(run, parameter, 0.0 if parameter == "gap" else 1.0, factor)
    if key == "model":
        model = dovetail.Model.read(tmp_path / "model.h5")
        value = str(tmp_path / "other.h5")
        model.with_loads(preload=factor * model.preload).write(value)
    other = run("other", **{key: value})
    force, states = path.contact_force(-1, 1, SAMPLES)
    wanted, same = other.contact_force(-1, 1, SAMPLES)
    np.testing.assert_allclose(force, wanted, rtol=0, atol=2e-5 * np.abs(wanted).max())
    assert np.mean(states != same) < 2e-3
    motion = other.full(-1, 64)
    np.testing.assert_allclose(path.full(-1, 64), motion, rtol=0, atol=2e-5 * np.abs(motion).max())
    np.testing.assert_allclose(path.unknowns(-1, [0, 1, 4], 64), motion[:, [0, 1, 4]], rtol=0, atol=2e-5 * np.abs(motion).max())
