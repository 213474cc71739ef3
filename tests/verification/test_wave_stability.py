"""Whether a travelling wave stays, as one sector says, against all sectors integrated in time."""

import re

import numpy as np
import pytest

import cases
import cyclic_sector
import launch
import wheel_in_time
from whole_rotor import DATA, N

NAME, ORDER, MODES, LOAD = "eo3_aliased", 3, 12, 2.0
UNSTABLE, STABLE = 2 * np.pi * 485, 2 * np.pi * 472


def scene(folder, omega, at=()):
    """Engine order N/2 with twice the load: shrouds slip and part."""
    path, models = cyclic_sector.write(folder, NAME, omega[0], samples='"exact"', modes=MODES)
    series = (LOAD * DATA[f"{NAME}/fourier"]).tolist()
    lines = {"fourier": f"fourier = {series[0]}", "harmonic_balance": "harmonic_balance.harmonics = 5",
             "newton": "newton = { step_tolerance = 1e-9, residual_tolerance = 1e-9 }",
             "continuation.omega": f"continuation = {{ omega = {list(omega)}, at = {list(at)}, adaptive = true, step = 1.0 }}\n"
                                   "stability.enabled = true\naccuracy.estimates = false"}
    text = path.read_text()
    for key, line in lines.items():
        text, found = re.subn(rf"(?m)^{re.escape(key)} = .*$", line, text)
        assert found == 1, key
    path.write_text(text)
    return cases.Case(path, None, None, {}), models


@pytest.mark.slow
def test_a_push_grows_where_the_sector_says_so_and_dies_out_elsewhere(tmp_path):
    case, models = scene(tmp_path, (2 * np.pi * 520, STABLE), at=[UNSTABLE])
    done = launch.run(case)
    assert re.search("unstable from here on: the wave loses its stability to nodal diameter [03],", done.out), done.out
    assert " stable from here on" in done.out
    contact = {key: DATA[f"{NAME}/{key}"] for key in ("kn", "kt", "mu", "gap")}
    with launch.h5py.File(tmp_path / "results.h5") as file:
        preload = file["preload/xp"][()], file["preload/w"][()]
    push = np.random.default_rng(0).standard_normal((N, MODES + 24))
    for omega, grows in ((UNSTABLE, True), (STABLE, False)):
        row = np.argmin(np.abs(done.points["omega"] - omega))
        c, multiplier = done.points["coefficients"][row], done.points["multiplier"][row]
        assert done.points["stable"][row] == (0 if grows else 1)
        assert done.points["unstable_diameter"][row] in ((0, 3) if grows else (-1,))  # both are large in what grows
        wheel = wheel_in_time.Wheel(models, contact, float(DATA["sector/xi"]), LOAD * DATA[f"{NAME}/fourier"], ORDER, omega, preload, 768)
        seen = []
        for size in (0, 1e-5):
            wheel.start(c, size * np.abs(c[:, 1:]).max(axis=1) * push)
            seen.append(wheel.run(13))
        change = wheel_in_time.by_diameter(seen[1] - seen[0])[:-1].reshape(13, 768, -1)
        change = np.sqrt((change**2).mean(axis=1))
        assert change[12, [1, 2]].max() < 0.1 * change[12, [0, 3]].min()
        rate = (change[12, 3] / change[3, 3]) ** (1 / 9)  # 0 also has what sliders remember
        assert multiplier > 1.1 and rate > 1.06 if grows else rate < 0.97


@pytest.mark.slow
def test_ranks_and_a_restart_say_the_same(tmp_path):
    found = []
    for ranks in (None, 3):
        folder = tmp_path / str(ranks)
        folder.mkdir()
        case, _ = scene(folder, (3100.0, STABLE))
        case.edit("adaptive = true", "adaptive = true, max_points = 2")
        launch.run(case, ranks=ranks)
        case.edit("max_points = 2", "max_points = 3")
        found.append(launch.run(case, "--restart", ranks=ranks).points)
    for name in ("omega", "multiplier", "stable", "unstable_diameter"):
        assert len(found[0][name]) == 3
        np.testing.assert_allclose(found[1][name], found[0][name], rtol=1e-8)
    assert (found[0]["stable"] == 0).all()
