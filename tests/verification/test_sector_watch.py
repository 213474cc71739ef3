"""The motion of a node of a sector as what is watched: another row of the unknowns in every harmonic."""

import h5py
import numpy as np
import pytest

import cases
import cyclic_sector
import launch
import sector_model
from dovetail import Results
from small_wave import SHROUD
from test_sector_peaks import SWEEP

TOUCHING = np.concatenate([cyclic_sector.DATA[f"sector/{part}_{side}"] for part in ("root", "shroud") for side in "ab"])
NODE = max(set(sector_model.FREE) - set(TOUCHING), key=lambda node: np.hypot(*sector_model.SECTOR["nodes"][node, :2]))
GIVEN = cyclic_sector.given("eo2_separation")


def write(folder, node, more=""):
    """The sector as a model file, watched at a node; a case that sweeps through the first resonance of nodal diameter 2."""
    sector_model.write_model(folder / "model.h5")
    with h5py.File(folder / "model.h5", "r+") as file:
        file["contact/friction"][...], file["contact/gap"][...] = SHROUD, GIVEN["gap"]
    (folder / "case.toml").write_text(
        'model = "model.h5"\nreduction.modes = 20\nreduction.interior_modes = 60\nharmonic_balance.harmonics = 5\n'
        f'damping.stiffness = 2.5e-5\ncontinuation.watch = "{node}"\ncontinuation.omega = {list(SWEEP[2])}\n'
        f'continuation.adaptive = true\n{more}excitation.engine_order = 2\n[[excitation.load]]\npattern = "lift"\nfourier = [0, 40.0]\n')
    return cases.Case(folder / "case.toml", None, None, {})


def of_displacements(results, point, axis):
    """Half the peak-to-peak of the node, without the rows that amplitude() takes."""
    course = results.displacement(point, [NODE], n=4096)[:, 0, axis]
    return (course.max() - course.min()) / 2


@pytest.mark.parametrize("axis, ranks", [(1, None), (0, 2), pytest.param(2, 3, marks=pytest.mark.slow)])
def test_its_peak_is_that_of_the_displacements(tmp_path, axis, ranks):
    name = f"{NODE}.{'xyz'[axis]}"
    done = launch.run(write(tmp_path, name), ranks=ranks)
    results = Results(done.folder / "results.h5")
    peak = results.events.of("peak")
    assert peak.unknown.tolist() == [-1]
    amplitude, point = peak.amplitude[0], peak.point[0]
    assert results.points("slip")[point] > 0
    assert abs(amplitude / results.amplitude(name)[point] - 1) < 1e-10
    assert abs(amplitude / of_displacements(results, point, axis) - 1) < 1e-6
    assert amplitude >= results.amplitude(name).max() * (1 - 1e-9)


def test_its_peak_is_followed(tmp_path):
    """The largest rms amplitude of ordinary points beside it, and derivatives from one place to the next."""
    name, (at, end) = f"{NODE}.y", (1.002, 1.004)
    (folder := tmp_path / "track").mkdir()
    path = f'path = {{ parameter = "force", range = [1.0, {end}], peak = "amplitude", at = [{at}] }}\n'
    track = Results(launch.run(write(folder, name, path)).folder / "results.h5")
    rms = np.linalg.norm(track.response(name).coefficients[:, 1:], axis=1)
    np.testing.assert_allclose(track.tracked_amplitude, rms, rtol=1e-10)
    (folder := tmp_path / "beside").mkdir()
    around = [float(track.omega[0] + shift) for shift in (-0.2, 0.0, 0.2)]
    sweep = Results(launch.run(write(folder, name, f'sensitivity.of = "{name}"\ncontinuation.at = {around}\n')).folder / "results.h5")
    beside = np.linalg.norm(sweep.response(name).coefficients[:, 1:], axis=1)
    left, middle, right = (beside[np.flatnonzero(sweep.omega == omega)[0]] for omega in around)
    assert middle > max(left, right) and abs(middle / rms[0] - 1) < 1e-9
    assert abs((right - left) / (2 * middle - left - right)) < 1e-2  # the parabola has its top there
    one, two, three = (int(np.flatnonzero(track.parameter == value)[0]) for value in (1.0, at, end))
    slope = (-3 * rms[one] + 4 * rms[two] - rms[three]) / (end - 1.0)
    assert abs(float(sweep.sensitivity.amplitude_by["force"][0]) / slope - 1) < 1e-4
