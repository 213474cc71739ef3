"""Derivatives of a peak by the contact parameters: against given ones, and against peaks of cases that are computed anew."""

import re

import h5py
import numpy as np
import pytest

import cases
import launch
from dovetail import Results, reference
from dovetail.__main__ import main
from test_against_core import close

DATA = cases.Path(__file__).parent / "data"
NAMES = ("normal_stiffness", "tangential_stiffness", "friction", "gap")
SCENES = {"dof5": ("a1", 2, 0.05, [0.9, 1.3]), "chain": ("x4.t1", 3, None, None)}  # watched, N_a, b of C = b K, sweep


def given(folder, scene, samples="exact"):
    """A scene of the data as a case, and the data."""
    watched, modes, stiffness, sweep = SCENES[scene]
    data = np.load(DATA / f"{scene}.npz")
    K, M, par = data["K"], data["M"], data["par"]
    stiffness = stiffness or float(np.vdot(data["C"], K) / np.vdot(K, K))
    assert np.abs(data["C"] - stiffness * K).max() < 1e-12
    values = {"normal_stiffness": par[:, 0].tolist(), "tangential_stiffness": par[:, 1:3].tolist(), "friction": par[:, 3:5].tolist(),
              "gap": par[:, 5].tolist()}
    load = data["load"]
    course = int(np.argmax(np.abs(load).max(axis=0)))
    fourier = [0.0] * (course + 1)
    fourier[course] = 1.0
    peak = data["sens_peak"][0]
    a = slice(0, modes)
    x = slice(modes, None)
    reduced = reference.Reduced(kaa=np.diag(K)[a].copy(), max=M[a, x], mxx=M[x, x], kxx=K[x, x], fa=load[a, course], fx=load[x, course],
                                r=-data["static"][x])
    cases.write_reduced(folder, reduced)
    case = cases.write(folder, scene, "reduced.h5", None, reduced, {}, stiffness=stiffness, fourier=fourier, initial=0.0,
                       harmonics=5, samples=samples, omega=[0.97 * peak, 1.03 * peak], step=0.02, kind="auto", **values, **cases.TIGHT)
    case.path.write_text(case.path.read_text() + f'\n[sensitivity]\nof = "{watched}"\n')
    return case, data


def sensitivities(case, ranks=None):
    done = launch.run(case, ranks=ranks)
    with h5py.File(done.folder / "results.h5", "r") as file:
        group = file["sensitivity"]
        found = {name: group[name][()] for name in ("omega", "amplitude", "point")}
        for slopes in ("amplitude_by", "omega_by"):
            found[slopes] = {name: values[()] for name, values in group[slopes].items()}
        found["located"] = file["points/located"][()]
    return found


def in_columns(slopes, row=0):
    """(N_x, 6) as the data have them: k_n, k_t1, k_t2, mu_1, mu_2, gap."""
    return np.column_stack([slopes["normal_stiffness"][row], slopes["tangential_stiffness"][row], slopes["friction"][row],
                            slopes["gap"][row]])


@pytest.mark.parametrize("ranks", [None, 2])
@pytest.mark.parametrize("scene", SCENES)
def test_given_derivatives(tmp_path, scene, ranks):
    case, data = given(tmp_path, scene)
    found = sensitivities(case, ranks)
    assert len(found["omega"]) == 1 and found["located"][found["point"][0]]
    close(np.array([found["omega"][0], found["amplitude"][0]]), data["sens_peak"], 1e-8)
    for slopes, name in (("amplitude_by", "sens_amplitude"), ("omega_by", "sens_omega")):
        close(in_columns(found[slopes]), data[name], 1e-6)
        assert np.abs(in_columns(found[slopes]) - data[name + "_differences"]).max() < 1e-6 * np.abs(data[name]).max()


@pytest.mark.slow
@pytest.mark.parametrize("samples", [100, "exact"])
def test_against_peaks_computed_anew(tmp_path, samples):
    """By every kind of parameter, of contact point 2 alone, by the load and by the preload."""
    h, point = 1e-4, 2

    def peak(folder, name=None, change=1.0):
        """Sensitivities, and the value that was changed: by a factor, the gap by an addend."""
        folder.mkdir()
        case, _ = given(folder, "chain", samples=samples)
        value = 1.0
        if name == "force":
            fourier = case.settings["fourier"]
            case.edit(f"fourier = {fourier}", f"fourier = {[change * number for number in fourier]}")
        elif name == "damping":
            case.edit(f"stiffness = {case.settings['stiffness']}", f"stiffness = {change * case.settings['stiffness']}")
        elif name == "preload":
            with h5py.File(folder / "reduced.h5", "r+") as file:
                file["R"][...] = change * file["R"][()]
        elif name:
            old = np.array(case.settings[name])
            new = old.copy()
            new[point] = old[point] + change - 1 if name == "gap" else old[point] * change
            case.edit(f"{name} = {old.tolist()}", f"{name} = {new.tolist()}")
            value = 1.0 if name == "gap" else old[point]
        return sensitivities(case), value

    middle, _ = peak(tmp_path / "middle")
    assert len(middle["omega"]) == 1
    factors = ("force", "preload", "damping")
    for name in (*NAMES, *factors):
        (up, value), (down, _) = (peak(tmp_path / f"{name}{side}", name, 1 + side * h) for side in (1, -1))
        for number in ("omega", "amplitude"):
            slope = (up[number][0] - down[number][0]) / (2 * h)
            by = middle[f"{number}_by"][name][0]
            own = np.sum((by[point] if name in NAMES else by) * value)
            size = max(abs(own), 1e-3 * middle[number][0])
            assert abs(own - slope) < 2e-4 * size, (name, number, own, slope)


def test_python_gives_them_relative(tmp_path):
    case, data = given(tmp_path, "chain")
    sensitivity = Results(launch.run(case).folder / "results.h5").sensitivity
    assert len(sensitivity) == 1
    wanted = data["par"][:, 3] * data["sens_amplitude"][:, 3] / data["sens_peak"][1]
    close(sensitivity.relative("friction")[0, :, 0], wanted, 1e-6)
    by_omega = data["par"][:, 0] * data["sens_omega"][:, 0] / data["sens_peak"][0]
    close(sensitivity.relative("normal_stiffness", of="omega")[0], by_omega, 1e-6)
    assert sensitivity.relative("force").shape == (1,)


def with_joints(case, names=("left", "right")):
    """The run's results, beside a model that says which joint each of four points is of."""
    done = launch.run(case)
    path = done.folder / "model.h5"
    with h5py.File(path, "w") as file:
        file.attrs["format"], file.attrs["version"] = "dovetail-model", 1
        file["contact/position"] = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1.0, 1, 0]]
        file["contact/axes"], file["contact/area"] = np.tile(np.eye(3), (4, 1, 1)), np.ones(4)
        file["contact/joint"] = [0, 0, 0, 1]
        file["contact"].attrs["joints"] = np.array([name.encode() for name in names])
    return Results(done.folder / "results.h5", path), path


def test_sums_by_joint(tmp_path):
    case, data = given(tmp_path, "chain")
    results, path = with_joints(case)
    sensitivity = results.sensitivity
    for column, name in (((3, 4), "friction"), ((1, 2), "tangential_stiffness"), ((0,), "normal_stiffness")):
        wanted = sum(data["par"][:, i] * data["sens_amplitude"][:, i] for i in column) / data["sens_peak"][1]
        found = sensitivity.by_joint(name, model=path)
        assert list(found) == ["left", "right"]
        close(np.array([found["left"][0], found["right"][0]]), np.array([wanted[:3].sum(), wanted[3]]), 1e-6)
        close(sensitivity.of_points(name)[0], wanted, 1e-6)
    with pytest.raises(ValueError, match="force is of no contact point"):
        sensitivity.by_joint("force", model=path)


def test_map_of_what_matters(tmp_path):
    from dovetail.sensitivity_map import PARAMETERS, sensitivity_map

    case, _ = given(tmp_path, "chain")
    results, path = with_joints(case)
    figure = sensitivity_map(results, model=path)
    titles = [axis.get_title(loc="left") for axis in figure.axes]
    for name in PARAMETERS:
        sums = results.sensitivity.by_joint(name, model=path)
        for joint in sums:
            assert any(f"{name.replace('_', ' ')}: together {sums[joint][0]:+.3g} % per %" in title for title in titles)
    drawn = [np.ravel(part.get_array()) for axis in figure.axes for part in axis.collections if part.get_array() is not None]
    values = np.concatenate([results.sensitivity.of_points(name)[0] for name in PARAMETERS])
    shown = np.sort(np.concatenate(drawn))
    assert set(np.round(shown[shown > 0], 12)) <= set(np.round(np.abs(values), 12)) and len(shown) >= 8
    out = tmp_path / "map.png"
    assert main(["plot", str(results.path), "--kind", "sensitivity", "--model", str(path), "-o", str(out)]) == 0
    assert out.stat().st_size > 5000


def test_no_map_without_sensitivities(tmp_path, capsys):
    case, _ = given(tmp_path, "chain")
    case.path.write_text(re.sub(r"\n\[sensitivity\]\nof = .*", "", case.path.read_text()))
    results = launch.run(case).folder / "results.h5"
    assert main(["plot", str(results), "--kind", "sensitivity"]) == 2
    assert "has no sensitivities; write [sensitivity]" in capsys.readouterr().err


def test_a_restart_keeps_them(tmp_path):
    case, _ = given(tmp_path, "chain")
    whole = sensitivities(case)
    text = case.path.read_text()
    case.path.write_text(text.replace("step = 0.02", "step = 0.02\nmax_points = " + str(whole["point"][0] + 3)))
    launch.run(case)
    case.path.write_text(text)
    launch.run(case, "--restart")
    with h5py.File(tmp_path / "results.h5", "r") as file:
        np.testing.assert_array_equal(file["sensitivity/amplitude_by/friction"][()], whole["amplitude_by"]["friction"])
        assert file["sensitivity/point"][()] == whole["point"]


def test_the_unknown_is_the_one_that_is_watched(tmp_path):
    case, _ = given(tmp_path, "dof5")
    text = case.path.read_text()
    case.path.write_text(text.replace("[continuation]", '[continuation]\nwatch = "x1.n"'))
    assert "continuation.watch" in launch.run(case, status=2).err
    case.path.write_text(text.replace('of = "a1"', 'of = "tip"'))
    assert "sensitivity.of" in launch.run(case, status=2).err
