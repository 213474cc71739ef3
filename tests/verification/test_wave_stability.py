"""Whether a travelling wave stays: the program's word on a sector of whole_rotor.py."""

import re

import numpy as np
import pytest

import cases
import cyclic_sector
import launch
from whole_rotor import DATA

NAME, MODES, LOAD = "eo3_aliased", 12, 2.0
UNSTABLE = 3100.0  # [rad/s]


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
