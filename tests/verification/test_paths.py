"""Sweeps over another parameter than the frequency: against the reference, cases made with the value, and given folds."""

import json
import re

import h5py
import numpy as np
import pytest

import cases
import launch
from dovetail import Results, reference
from test_against_core import close

# parameter: [from, to, one in between]
RANGES = {"force": [1, 0.4, 0.7], "preload": [1, 1.4, 1.2], "normal_stiffness": [1, 2, 1.5], "tangential_stiffness": [1, 2, 1.5],
          "tangential_stiffness_1": [1, 0.5, 0.75], "tangential_stiffness_2": [1, 2, 1.5], "friction": [1, 2, 1.5],
          "friction_1": [1, 0.3, 0.6], "friction_2": [1, 2, 1.5], "gap": [0, -0.1, -0.05], "damping": [1, 0.4, 0.7]}
OMEGA = 1.0
MILD, STRONG = [0.2, 1, 0.5, 0, 0.3], [0.6, 3, 1.5, 0, 0.9]  # loads under which some points slip; all slip and lift off


def path_of(folder, parameter, values, points=None, **overrides):
    case = cases.several_points(folder, omega=None, kind="auto", **{"fourier": STRONG, **overrides})
    start, end, between = values
    case.path.write_text(case.path.read_text() + f'\n[path]\nparameter = "{parameter}"\nrange = [{start}, {end}]\n'
                                                 f"omega = {OMEGA}\nat = [{between}]\n" + (f"points = {points}\n" if points else ""))
    return case


def made_with(case, parameter, value, points=None):
    """The reference's equations and preload of a case whose parameter has that value, at these points or all."""
    name, _, direction = parameter.rpartition("_")
    if direction not in "12":
        name, direction = parameter, ""
    settings, reduced = dict(case.settings), case.reduced
    rows = slice(None) if not direction else int(direction) - 1
    which = [True] * 4 if points is None else [point in points for point in range(1, 5)]
    if name in ("normal_stiffness", "tangential_stiffness", "friction"):
        values = np.array(settings[name], float)
        factors = np.where(which, value, 1.0)
        if values.ndim == 1:
            values *= factors
        else:
            values[:, rows] *= factors if direction else factors[:, None]
        settings[name] = values.tolist()
    elif name == "gap":
        settings["gap"] = [gap + value * varied for gap, varied in zip(settings["gap"], which)]
    elif name == "damping":
        settings["stiffness"] = value * settings["stiffness"]
    elif name == "preload":
        reduced = reference.Reduced(**{**vars(reduced), "r": value * reduced.r})
    else:
        settings["fourier"] = [value * number for number in settings["fourier"]]
    return cases.Case(case.path, case.structure, reduced, settings)


def run(case, ranks=None, *options):
    done = launch.run(case, *options, ranks=ranks)
    return done, done.points


OF_POINTS = [(name, [2, 3]) for name in ("normal_stiffness", "tangential_stiffness_1", "friction", "gap")]
QUICK = [("force", None), ("preload", None), ("damping", None), ("gap", None), ("tangential_stiffness", None), ("friction_2", None),
         ("normal_stiffness", [2, 3]), ("tangential_stiffness_1", [2, 3])]  # every kind, direction and choice of points


@pytest.mark.parametrize("parameter, of", [pytest.param(*one, marks=() if one in QUICK else pytest.mark.slow) for one in
                                           (*((name, None) for name in RANGES), *OF_POINTS)])
def test_points_solve_the_equations_with_its_value(tmp_path, parameter, of):
    case = path_of(tmp_path, parameter, RANGES[parameter], of, samples=64)
    _, points = run(case)
    start, end, between = RANGES[parameter]
    assert points["parameter"][0] == start and points["parameter"][-1] == end and between in points["parameter"]
    assert np.all(points["omega"] == OMEGA) and len(points["omega"]) > 3
    assert (points["contact/slip"] > 0).any() and (points["contact/open"] > 0).any()
    first, last = points["coefficients"][[0, -1], :, 1:]
    assert np.linalg.norm(last - first) > 1e-3 * np.linalg.norm(first)  # the parameter is in the equations
    nominal = case.preload.xp
    for i in {*range(0, len(points["omega"]), 10), *np.flatnonzero(np.isin(points["parameter"], [end, between]))}:
        value, q = points["parameter"][i], points["coefficients"][i]
        made = made_with(case, parameter, value, of)
        system = made.system()
        motion = q.copy()
        motion[len(case.reduced.kaa):, 0] += 2 * (nominal - made.preload.xp).ravel()
        assert np.linalg.norm(system.residual(motion, OMEGA)) < 1e-8 * np.linalg.norm(system.excitation), value


@pytest.fixture(scope="module")
def over_friction(tmp_path_factory):
    """A case over friction, and its points on one rank."""
    case = path_of(tmp_path_factory.mktemp("friction"), "friction", RANGES["friction"], fourier=MILD)
    return case, run(case)[1]


def test_ranks_do_not_change_the_branch(over_friction):
    case, alone = over_friction
    together = launch.run(case, ranks=2, out="on2").points
    close(together["parameter"], alone["parameter"], 1e-8)
    close(together["coefficients"], alone["coefficients"], 1e-8)


@pytest.mark.slow
def test_both_forms_end_at_the_same_point(over_friction, tmp_path):
    assembled = run(path_of(tmp_path, "friction", RANGES["friction"], fourier=MILD, solver="assembled"))[1]
    close(assembled["coefficients"][-1], over_friction[1]["coefficients"][-1], 1e-8)


def two_blocks(folder, lines, **contact):
    """Two joints, "left" with four points and "right" with two, between a bar and the ground; a path over friction, with these lines."""
    joints = {"left": 4, "right": 2}
    case = cases.several_points(folder, omega=None, kind="auto", structure=cases.random_structure(12, points=6), **{
        "normal_stiffness": 4.0, "tangential_stiffness": 2.0, "friction": 0.4, "gap": -0.1, **contact})
    with h5py.File(folder / "model.h5", "r+") as file:
        file["contact/joint"] = np.repeat(np.arange(2), list(joints.values()))
        file["contact"].attrs["joints"] = np.array([name.encode() for name in joints])
    case.path.write_text(case.path.read_text() + f'\n[path]\nparameter = "friction"\nrange = [1, 0.5]\nomega = {OMEGA}\n{lines}\n')
    return case


def test_a_joint_is_its_points(tmp_path):
    """By name as by number, and another curve than all joints have."""
    found = {}
    for name, lines in (("joint", 'joint = "right"'), ("points", "points = [5, 6]"), ("all", "")):
        (folder := tmp_path / name).mkdir()
        found[name] = run(two_blocks(folder, lines))[1]["coefficients"]
    np.testing.assert_array_equal(found["joint"], found["points"])
    first, last = found["joint"][[0, -1], :, 1:]
    assert np.linalg.norm(last - first) > 1e-4 * np.linalg.norm(first)
    assert np.linalg.norm(found["all"][-1, :, 1:] - last) > 1e-4 * np.linalg.norm(first)


@pytest.mark.slow
def test_ranks_share_the_points_of_a_path(tmp_path):
    """The first of two ranks owns none of them."""
    case = two_blocks(tmp_path, 'joint = "right"')
    alone, together = run(case)[1], run(case, 2)[1]
    close(together["coefficients"][-1], alone["coefficients"][-1], 1e-8)


@pytest.mark.parametrize("lines, words", [
    ('joint = "middle"', ["path.joint", '"middle"', "no such joint", '"left", "right"']),
    ("points = [7]", ["path.points = 7", "6 contact points", "from 1"]),
    ("points = [0]", ["path.points", "0"]),
    ("points = [2, 2]", ["path.points", "there already"]),
    ("points = []", ["path.points", "no contact point"]),
    ('points = [2]\njoint = "left"', ["path.points", "path.joint is given as well"]),
])
def test_points_that_are_not_there(tmp_path, lines, words):
    done = launch.run(two_blocks(tmp_path, lines), status=2)
    for word in words:
        assert word in done.err


@pytest.mark.parametrize("parameter", ["force", "preload", "damping"])
def test_what_is_of_no_joint(tmp_path, parameter):
    case = path_of(tmp_path, parameter, [1, 2, 1.5], [1])
    done = launch.run(case, status=2)
    assert "path.points" in done.err and f'"{parameter}" is of no contact points' in done.err


def test_a_model_without_joints(tmp_path):
    case = path_of(tmp_path, "friction", RANGES["friction"])
    case.path.write_text(case.path.read_text() + 'joint = "left"\n')
    done = launch.run(case, status=2)
    assert "path.joint" in done.err and "write path.points" in done.err


def test_points_of_a_path_stay_in_a_restart(tmp_path):
    case = two_blocks(tmp_path, "points = [5, 6]")
    text = case.path.read_text()
    case.path.write_text(text.replace("step = 0.05", "step = 0.05\nmax_points = 2"))
    run(case)
    case.path.write_text(text.replace("[5, 6]", "[5]"))
    assert "path.points = [5]: this run began with [5, 6]" in launch.run(case, "--restart", status=2).err


def test_damping_moves_stability(tmp_path):
    """Stability of a point is that of a case made with its damping."""
    case = path_of(tmp_path, "damping", RANGES["damping"], harmonics=3, fourier=MILD)
    case.path.write_text(case.path.read_text() + "\n[stability]\nenabled = true\n")
    points = run(case)[1]
    made = cases.several_points(tmp_path, kind="auto", harmonics=3, omega=[OMEGA, OMEGA], stiffness=0.4 * case.settings["stiffness"])
    made.path.write_text(made.path.read_text() + "\n[stability]\nenabled = true\n")
    assert points["multiplier"][-1] == pytest.approx(run(made)[1]["multiplier"][0], rel=1e-6)
    assert abs(points["multiplier"][0] - points["multiplier"][-1]) > 1e-4


def lift_off(folder, forces):
    """One mass on a preloaded spring that only pushes, driven at a fixed frequency: its curve over the force is an S."""
    data = np.load(cases.Path(__file__).parent / "data/liftoff.npz")
    reduced = reference.Reduced(kaa=np.ones(1), max=np.zeros((1, 3)), mxx=np.eye(3), kxx=float(data["k"]) * np.eye(3),
                                fa=np.zeros(1), fx=np.array([0.0, 0, 1]), r=np.array([0.0, 0, -float(data["push"])]))
    cases.write_reduced(folder, reduced)
    case = cases.write(folder, "lift-off", "reduced.h5", None, reduced, {}, stiffness=0.0, mass=0.03, fourier=[0, 1],
                       normal_stiffness=float(data["kn"]), law="unilateral", gap=0.0, initial=0.0, harmonics=15, samples="exact",
                       kind="auto", **cases.TIGHT)
    case.path.write_text(case.path.read_text() + f'\n[path]\nparameter = "force"\nrange = {json.dumps(forces)}\n'
                                                 f'omega = {float(data["scurve_omega"])}\n')
    return case, data


def test_folds_of_an_s_curve(tmp_path):
    case, data = lift_off(tmp_path, [0.01, 0.6])
    done, points = run(case)
    folds = done.summary["located"]["folds"]
    assert len(folds) == 2 and done.summary["folds"] == 2
    for fold, (force, amplitude) in zip(folds, data["scurve_folds"]):
        first = points["coefficients"][fold["point"], -1, 1:3]
        assert abs(fold["parameter"] - force) < 1e-6 and fold["omega"] == float(data["scurve_omega"])
        assert abs(np.hypot(*first) - amplitude) < 1e-5
    changes = done.summary["located"]["stability_changes"]
    assert [change["parameter"] for change in changes] == pytest.approx([fold["parameter"] for fold in folds], abs=1e-8)
    assert [line.split()[-1] for line in done.out.splitlines() if line.startswith("  stability changes at force ")] == [
        f"{change['parameter']:.9g}" for change in changes]
    first, second = (fold["point"] for fold in folds)
    stable = points["stable"]
    assert first > 3 and np.all(stable[:first - 1] == 1)
    assert second > first + 5 and np.all(stable[first + 2:second - 1] == 0)
    assert len(stable) > second + 5 and np.all(stable[second + 2:] == 1)


def test_modes_and_harmonics_to_a_tolerance(tmp_path):
    """They are tried on the path, too."""
    case = path_of(tmp_path, "force", RANGES["force"], elastic=40, modes=None, harmonics=None, tolerance=2e-2, samples=None)
    done, points = run(case)
    accuracy = done.summary["accuracy"]
    assert accuracy["above"] == 0 and accuracy["modes"] < 2e-2
    assert int(re.search(r"\((\d+) points of a trial run", done.out)[1]) > 3


def test_restart_goes_on_along_the_path(over_friction, tmp_path):
    case = path_of(tmp_path, "friction", RANGES["friction"], fourier=MILD)
    whole = over_friction[1]
    text = case.path.read_text()
    case.path.write_text(text.replace("step = 0.05", "step = 0.05\nmax_points = 3"))
    first, _ = run(case)
    assert first.summary["end"] == "max_points"
    case.path.write_text(text)
    again, points = run(case, None, "--restart")
    assert "restart: goes on at friction" in again.out
    for name in points.keys() - {"seconds"}:
        np.testing.assert_array_equal(points[name], whole[name])


def test_python_reads_the_parameter(over_friction):
    case, points = over_friction
    results = Results(case.path.parent / "results.h5")
    assert results.parameter_name == "friction"
    np.testing.assert_array_equal(results.parameter, points["parameter"])


@pytest.mark.parametrize("lines, words", [
    ('parameter = "stiffness"\nrange = [1, 2]\nomega = 1', ["path.parameter", '"normal_stiffness"', '"gap"']),
    ('parameter = "friction"\nomega = 1', ["path.range is missing"]),
    ('parameter = "friction"\nrange = [1, 2]', ["path.omega is missing", "rad/s"]),
    ('parameter = "friction"\nrange = [0, 2]\nomega = 1', ["path.range", "greater than 0"]),
    ('parameter = "friction"\nrange = [1, 1]\nomega = 1', ["path.range", "the same"]),
    ('parameter = "friction"\nrange = [1, 2]\nomega = 1\nat = [3]', ["path.at = 3", "outside path.range"]),
    ("range = [1, 2]\nomega = 1", ["path.range", "path.parameter is not given"]),
    ('parameter = "friction"\nrange = [1, 2]\nomega = 1\n[continuation]\nomega = [1, 2]', ["continuation.omega", "[path]"]),
])
def test_wrong_input(tmp_path, lines, words):
    case = cases.several_points(tmp_path, omega=None, step=None)
    case.path.write_text(case.path.read_text() + "\n[path]\n" + lines + "\n")
    done = launch.run(case, status=2)
    for word in words:
        assert word in done.err


def test_what_the_joint_has_not(tmp_path):
    for law, parameter, word in (("unilateral", "friction", "no contact point has friction"),
                                 ("cone", "friction_1", "one friction for both directions")):
        friction = 0.3 if law == "cone" else None
        case = path_of(tmp_path, parameter, [1, 2, 1.5], law=law, friction=friction,
                       tangential_stiffness=1.0 if law == "cone" else None)
        assert word in launch.run(case, status=2).err
