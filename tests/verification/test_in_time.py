"""Curves that are followed in time, where harmonic balance winds or does not begin: parts of scenes of the atlas."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from launch import BINARY, ROOT, in_parts

sys.path.insert(0, str(ROOT / "scripts/bench"))
import atlas_scenes

from dovetail import Results

pytestmark = pytest.mark.slow
SCENE = "249"  # two bodies, three stiff contact points: no first point by harmonic balance with all the harmonics that there may be
PART = (0.995, 0.96)  # of the sweep: from its end, at which integration from rest settles


def sweep(part, folder, more=""):
    """The case of a part of the sweep, its frequencies, and its number of modes."""
    built = atlas_scenes.build(atlas_scenes.scenes()[SCENE])
    omega = tuple(float(np.interp(end, (0, 1), built.omega)) for end in part)
    case = atlas_scenes.write(replace(built, omega=omega), folder)
    case.write_text(case.read_text() + more)
    return case, omega, built.modes


def run(case, *more):
    return subprocess.run([BINARY, "run", case, *more], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)


@pytest.fixture(scope="module")
def followed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("in_time")
    case, omega, modes = sweep(PART, folder)
    said = run(case)
    assert said.returncode == 0, said.stdout[-2000:]
    return case, omega, modes, Results(folder / "results.h5"), said.stdout


def test_said(followed):
    *_, results, said = followed
    assert "followed in time from there" in said and "points followed in time" in said


def test_what_coefficients_miss_is_told(followed):
    """The estimated error is what the motion has beyond its harmonics: small where the upper half of them is."""
    *_, results, _ = followed
    in_time = results.points("in_time") == 1
    errors = results.points("error_harmonics")[in_time]
    assert np.all(errors >= 0) and np.median(errors) < 1e-2
    q = results.coefficients[np.flatnonzero(in_time)[0]][:, 1:]
    H = q.shape[1] // 2
    assert np.linalg.norm(q[:, H:]) < 0.1 * np.linalg.norm(q)


def test_frequencies_are_met(tmp_path):
    """Those of `at` and the ends exactly, in time as well. At which end a first motion is found hangs on the last bits."""
    wanted = [float(np.interp(part, (0, 1), atlas_scenes.build(atlas_scenes.scenes()[SCENE]).omega)) for part in (0.99, 0.98)]
    case, omega, _ = sweep((PART[0], 0.97), tmp_path, f"at = {wanted}\n")
    said = run(case)
    assert said.returncode == 0, said.stdout[-2000:]
    results = Results(tmp_path / "results.h5")
    missed = results.events.of("missed").omega
    for one in wanted:
        assert one in missed or results.points("in_time")[np.flatnonzero(results.omega == one)].any()
    assert len(missed) < len(wanted) and {results.omega[0], results.omega[-1]} == set(omega)


def test_restart(followed):
    """A run in parts does what one in one go does, to the last bit: within a piece in time, and at its ends."""
    case, _, _, whole, _ = followed
    in_time = whole.points("in_time")
    ends = np.flatnonzero(np.diff(in_time)) + 1
    stops = sorted({10, len(whole.omega) // 2, *(int(i) for i in ends[:3]), *(int(i) + 1 for i in ends[:3])} - {0, len(whole.omega)})
    parts = in_parts(case, stops)
    np.testing.assert_array_equal(parts.omega, whole.omega)
    np.testing.assert_array_equal(parts.points("in_time"), in_time)


def test_stability_by_multipliers(tmp_path):
    """Told at every point, the same as the multiplier says. Whether multipliers are right is tested where there are two turning points
    (tests/unit/test_orbit_curve.cpp)."""
    case, omega, _ = sweep((PART[0], 0.98), tmp_path, "\n[stability]\nenabled = true\n")
    assert run(case).returncode == 0
    results = Results(tmp_path / "results.h5")
    in_time = results.points("in_time") == 1
    multiplier, stable = results.points("multiplier")[in_time], results.points("stable")[in_time]
    assert len(multiplier) > 20 and np.all(multiplier > 0)
    clear = np.abs(multiplier - 1) > 1e-3
    np.testing.assert_array_equal(stable[clear], multiplier[clear] < 1)
