"""Whether a travelling wave stays: of a sector, against the word on all sectors as one structure."""

import re

import numpy as np
import pytest

import cases
import cyclic_sector
import launch
import small_ring
from whole_rotor import DATA

NAME, MODES, LOAD = "eo3_aliased", 12, 2.0
UNSTABLE = 3100.0  # [rad/s]
NEAR = 5e-4  # multipliers: what 6 harmonics are off by


def scene(folder, omega):
    """Engine order N/2 with twice the load: shrouds slip and part."""
    path, _ = cyclic_sector.write(folder, NAME, omega[0], samples='"exact"', modes=MODES)
    series = (LOAD * DATA[f"{NAME}/fourier"]).tolist()
    lines = {"fourier": f"fourier = {series[0]}", "harmonic_balance": "harmonic_balance.harmonics = 5",
             "newton": "newton = { step_tolerance = 1e-9, residual_tolerance = 1e-9 }",
             "continuation.omega": f"continuation = {{ omega = {list(omega)}, adaptive = true }}\n"
                                   "stability.enabled = true\naccuracy.estimates = false"}
    text = path.read_text()
    for key, line in lines.items():
        text, found = re.subn(rf"(?m)^{re.escape(key)} = .*$", line, text)
        assert found == 1, key
    path.write_text(text)
    return cases.Case(path, None, None, {})


@pytest.mark.slow
def test_ranks_and_a_restart_say_the_same(tmp_path):
    found = []
    for ranks in (None, 3):
        folder = tmp_path / str(ranks)
        folder.mkdir()
        case = scene(folder, (UNSTABLE, 2 * np.pi * 472))
        case.edit("adaptive = true", "adaptive = true, max_points = 2")
        launch.run(case, ranks=ranks)
        case.edit("max_points = 2", "max_points = 3")
        found.append(launch.run(case, "--restart", ranks=ranks).points)
    for name in ("omega", "multiplier", "stable", "unstable_diameter"):
        assert len(found[0][name]) == 3
        np.testing.assert_allclose(found[1][name], found[0][name], rtol=1e-8)
    assert (found[0]["stable"] == 0).all()


@pytest.mark.slow
def test_a_ring_of_sectors_as_one_structure_says_the_same(tmp_path):
    """Contacts slip in every period and lift off in most; the ring is judged by the map over one period, sliders among the states."""
    N, order, force = 4, 1, 0.5
    sector, ring = small_ring.write(tmp_path, N, order, 6, force, (1.5, 0.9), points=100)
    points = launch.run(sector).points
    rows = np.argsort(points["multiplier"])[[0, 10, 55, 80, 99]]
    verdicts = []
    for row in rows:
        omega, multiplier = float(points["omega"][row]), points["multiplier"][row]
        X = small_ring.write_start(ring, N, order, force, omega, points["coefficients"][row])
        found = launch.run(ring).points
        np.testing.assert_allclose(found["coefficients"][0][-len(X):], X, rtol=0, atol=1e-9 * np.abs(X).max())
        truth = found["multiplier"][0]
        if found["stable"][0] == -1:  # its two methods disagree
            continue
        assert abs(multiplier - truth) < max(NEAR, 0.02 * abs(truth - 1)), (omega, multiplier, truth)
        if abs(truth - 1) > NEAR:
            assert points["stable"][row] == found["stable"][0] == (truth < 1), (omega, multiplier, truth)
            assert points["instability"][row] == found["instability"][0]
            verdicts.append(truth < 1)
    assert 1 <= sum(verdicts) < len(verdicts)
