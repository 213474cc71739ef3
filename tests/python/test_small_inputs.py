"""The smallest examples of inputs/ show what their pages say."""

import json
import runpy
import shutil
import subprocess
import sys

import numpy as np
import pytest
import scipy.sparse as sp

import dovetail
from dovetail import Joint, Results, Structure
from launch import BINARY, ROOT, SURROUNDINGS, words_of


def results(name, case, folder):
    """Of inputs/NAME, copied: its model is written beside it."""
    shutil.copytree(ROOT / "inputs" / name, folder / name, ignore=shutil.ignore_patterns("*.h5", "out"))
    for command in ([sys.executable, "model.py"], [BINARY, "run", case, "--out", "out"]):
        subprocess.run(command, cwd=folder / name, env=SURROUNDINGS, check=True, capture_output=True)
    return Results(folder / name / "out/results.h5")


def test_slider_lies_on_its_closed_form(tmp_path, monkeypatch):
    found = results("jenkins", "case.toml", tmp_path)
    monkeypatch.syspath_prepend(ROOT / "inputs/jenkins")
    import closed_form

    response = found.response("x1.t1")
    slips = response.amplitude > closed_form.SLIP
    assert slips.any() and not slips.all()
    off = np.abs(closed_form.curve(response.amplitude) / found.omega[:, None] - 1).min(axis=1)
    assert off.max() < 1e-6
    assert response.peaks()[0][1] == pytest.approx(closed_form.PEAK, rel=1e-6)


def test_many_sliders_lie_on_the_closed_form_without_end_of_them(tmp_path):
    closed = runpy.run_path(str(ROOT / "inputs/iwan/closed_form.py"))
    found = results("iwan", "case.toml", tmp_path / "sweep")
    response = found.response("x1.t1")
    off = np.abs(closed["curve"](response.amplitude) / found.omega[:, None] - 1).min(axis=1)
    assert off.max() < 1e-3
    assert response.peaks()[0][1] == pytest.approx(closed["PEAK"], rel=1e-3)
    mode = results("iwan", "mode.toml", tmp_path / "mode")
    X = mode.modal_amplitude[mode.modal_amplitude > 1e-5]
    assert X[-1] == pytest.approx(closed["SLIP"])
    omega, ratio = closed["backbone"](X)
    np.testing.assert_allclose(mode.omega[-len(X):], omega, rtol=1e-4)
    np.testing.assert_allclose(mode.damping_ratio[-len(X):], ratio, rtol=2e-2)


@pytest.mark.parametrize("link, arrives", [("1e12", True), ("1e14", False)])
def test_links_too_stiff_for_rounding(link, arrives, tmp_path):
    """Where rounding leaves more than the tolerance points are taken and that is told; where no step settles the run ends with it."""
    folder = tmp_path / "iwan"
    shutil.copytree(ROOT / "inputs/iwan", folder, ignore=shutil.ignore_patterns("*.h5", "out"))
    model = folder / "model.py"
    model.write_text(model.read_text().replace("LINK = 1e9", f"LINK = {link}"))
    words_of([sys.executable, model])
    out, err = words_of([BINARY, "run", folder / "case.toml", "--out", folder / "out"], 0 if arrives else 3)
    summary = json.loads((folder / "out/summary.json").read_text())
    assert summary["newton_iterations"] < 500
    if not arrives:
        assert "rounding errors alone leave a residual" in err
        return
    assert ["rounding"] == [warning["kind"] for warning in summary["warnings"]] and "rounding errors leave a residual" in out + err
    found = dovetail.Results(folder / "out/results.h5")
    assert found.omega[-1] == 1300 and found.peak("x1.t1")[1] == pytest.approx(61.4e-6, rel=1e-3)
    assert found.points("residual").max() > 1e-8
    words_of([sys.executable, "-m", "dovetail", "verify", folder / "out/results.h5"])


def test_damper_has_a_best_force(tmp_path):
    """Beyond it the wedge sticks, below it has little to damp with: the peak rises, at the stuck or at the open frequency."""
    found = results("damper", "optimum.toml", tmp_path)
    best = np.argmin(found.tracked_amplitude)
    first, last = found.at(6), found.at(0.2)
    assert 0.3 < found.parameter[best] < 0.6
    assert min(found.tracked_amplitude[[first, last]]) > 5 * found.tracked_amplitude[best]
    assert found.frequency[first] == pytest.approx(393.7, rel=5e-3) and found.frequency[last] == pytest.approx(317.9, rel=5e-3)


@pytest.mark.slow
def test_flange_opens_and_leans(tmp_path):
    """Bolts press what they pull; between them it opens, which makes the peak lower, softer, and the curve turn back."""
    found = results("flange", "case.toml", tmp_path)
    at_rest = found.g.reshape(-1, 3)
    assert at_rest[:, 2].sum() == pytest.approx(6 * 3000.0, rel=1e-9) and at_rest[:, 2].min() > 0
    np.testing.assert_allclose(at_rest[:, :2].sum(axis=0), 0, atol=1e-6 * 18000)
    top = found.peak_point("top.x")
    assert found.points("open")[top] > 0.2 and found.points("slip")[top] > 0.2
    assert found.frequency[top] == pytest.approx(2102.2, rel=2e-3)  # with seven harmonics
    assert found.amplitude("top.x")[top] == pytest.approx(44.57e-6, rel=3e-2)
    assert np.any(np.diff(found.omega) < 0)


def whole_damper(folder, right=1.0):
    """The case of two blades with a whole wedge between them, which nothing holds but both faces, at their bounds from the preload on; and
    that of its half, by symmetry, in folder/damper. `right`: stiffness of the second blade, in those of the first."""
    shutil.copytree(ROOT / "inputs/damper", folder / "damper", ignore=shutil.ignore_patterns("*.h5", "out"))
    script = folder / "damper/model.py"
    script.write_text(script.read_text().replace("np.radians(70)", "np.radians(35)"))
    given = runpy.run_path(str(script))
    blade, link = np.array(given["BLADE_STIFFNESS"]), given["MIRROR"] / 2 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    K = sp.block_diag([np.diag([*blade, *right * blade]), np.kron(link, np.eye(3))], format="csr")
    M = sp.diags([given["BLADE"]] * 6 + [given["WEDGE"]] * 6, format="csr")
    sets = {"left": [0], "right": [1], "wedge left": [2], "wedge right": [3]}
    whole = Structure(K=K, M=M, nodes=np.zeros((4, 3)), dof_node=np.repeat([0, 1, 2, 3], 3), dof_direction=np.tile([0, 1, 2], 4),
                      node_sets=sets)
    joints = []
    for side, sign in (("left", 1), ("right", -1)):
        whole = whole.with_force(side, [sign, 0.0, 0.0]).with_preload(f"wedge {side}", [0.0, 0.0, given["CENTRIFUGAL"]])
        joints.append(Joint.between(whole.surface(side), whole.surface(f"wedge {side}"), normal=[sign * given["c"], 0.0, -given["s"]],
                                    t1=[sign * given["s"], 0.0, given["c"]], name=side))
    whole.join(joints).write(folder / "model.h5")
    half = folder / "damper/case.toml"
    path = folder / "case.toml"
    path.write_text(half.read_text().replace("modes = 3 ", "modes = 6 "))
    return path, half


def run_at(path, at):
    """Results of a case with these frequencies [Hz] among its points."""
    path.write_text(path.read_text().replace("omega = [250, 600]", f"omega = [250, 600]\nat = {at}"))
    subprocess.run([BINARY, "run", path, "--out", path.parent / "out"], env=SURROUNDINGS, check=True, capture_output=True)
    return Results(path.parent / "out/results.h5")


def test_whole_damper_moves_as_its_half_does(tmp_path):
    at, found = [300.0, 350.0, 450.0], []
    for path in whole_damper(tmp_path):
        run = run_at(path, at)
        found.append([run.amplitude("x1.t1")[np.argmin(abs(run.frequency - hertz))] for hertz in at])
    assert found[0] == pytest.approx(found[1], rel=1e-7)


def test_damper_between_unlike_blades(tmp_path):
    """The load moves the first mode by a hundred thousandth of what it moves others: no unit of motion."""
    run = run_at(whole_damper(tmp_path, right=1.02)[0], [300.0])
    assert len(run.events.of("leap")) == 0 and len(run.peaks()) >= 1
    verify = [sys.executable, "-m", "dovetail", "verify", run.path, "--points", "2"]
    done = subprocess.run(verify, env=SURROUNDINGS, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
