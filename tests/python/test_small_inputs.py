"""The smallest examples of inputs/ show what their pages say."""

import shutil
import subprocess
import sys

import numpy as np
import pytest

from dovetail import Results
from launch import BINARY, ROOT, SURROUNDINGS


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


def test_damper_has_a_best_force(tmp_path):
    """Beyond it the wedge sticks, below it has little to damp with: the peak rises, at the stuck or at the open frequency."""
    found = results("damper", "optimum.toml", tmp_path)
    best = np.argmin(found.tracked_amplitude)
    first, last = found.at(6), found.at(0.2)
    assert 0.3 < found.parameter[best] < 0.6
    assert min(found.tracked_amplitude[[first, last]]) > 5 * found.tracked_amplitude[best]
    assert found.frequency[first] == pytest.approx(393.7, rel=5e-3) and found.frequency[last] == pytest.approx(317.9, rel=5e-3)
