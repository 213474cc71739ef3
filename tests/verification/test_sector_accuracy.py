"""Errors of a sector against the same sector with many more harmonics, and runs that keep a tolerance, in parts and on several ranks."""

import h5py
import numpy as np
import pytest

import launch
from dovetail import Results
from dovetail.study_errors import distances
from small_wave import OMEGA, scene

ORDER, OFFSET = 1, 3e-6  # of the sweep, for tangents of the reference
BEGIN, END = OMEGA[ORDER]
SWEEP, FREQUENCIES = END - BEGIN, np.linspace(BEGIN, END, 7)[1:-1]
WATCH = 'continuation.watch = "a1"\n'


def at(frequencies):
    return WATCH + f"continuation.at = {np.asarray(frequencies).tolist()}\n"


@pytest.fixture(scope="module")
def truth(tmp_path_factory):
    """A function that gives the true errors of the points of a run at common frequencies, and these points."""
    around = np.sort([f + shift * OFFSET * SWEEP for f in FREQUENCIES for shift in (-1, 0, 1)])
    folder = tmp_path_factory.mktemp("reference")
    case = scene(folder, ORDER, harmonics=18, more=at(around) + "accuracy.estimates = false\n")
    reference = Results(launch.run(case).folder / "results.h5")

    def errors(folder):
        results = Results(folder / "results.h5")
        with h5py.File(folder / "state.h5") as state:
            scales = state["scales"][()]
        points, true = distances(results, reference, scales, SWEEP, FREQUENCIES, OFFSET * SWEEP)
        assert len(points) >= len(FREQUENCIES)
        return results, points, true

    return errors


@pytest.mark.parametrize("harmonics", [3, pytest.param(6, marks=pytest.mark.slow)])
def test_estimates_are_near_the_true_errors(tmp_path, truth, harmonics):
    """By default, and of the indices that further harmonics have."""
    results, points, true = truth(launch.run(scene(tmp_path, ORDER, harmonics=harmonics, more=at(FREQUENCIES))).folder)
    ratio = true / results.error[points]
    assert true.min() > 1e-4 and np.all((ratio > 0.5) & (ratio < 2)), ratio


@pytest.mark.parametrize("tolerance, ranks", [(1e-2, None), *(pytest.param(*other, marks=pytest.mark.slow) for other in
                                                             ((1e-2, 2), (1e-3, None), (1e-3, 3)))])
def test_tolerance_is_kept(tmp_path, truth, tolerance, ranks):
    case = scene(tmp_path, ORDER, harmonics=None, more=at(FREQUENCIES) + f"accuracy.tolerance = {tolerance}\n")
    done = launch.run(case, ranks=ranks)
    results, points, true = truth(done.folder)
    assert np.all(true <= tolerance) and true.max() > 0.01 * tolerance, true
    assert done.summary["accuracy"]["above"] == 0 and done.points["slip"].max() > 0
    with h5py.File(done.folder / "results.h5") as file:
        assert file["cyclic/index"][()].tolist() == results.wave.index.tolist()
        assert len(results.wave.index) == results.harmonics + 1 == done.points["harmonics"].max() + 1


@pytest.mark.slow
def test_a_tolerance_in_parts(tmp_path):
    """A run that is continued has the points of one that is not."""
    case = scene(tmp_path, ORDER, harmonics=None, more=WATCH + "accuracy.tolerance = 3e-3\n")
    expected = Results(launch.run(case, out="whole").folder / "results.h5")
    text = case.path.read_text()
    for stop in (7, 31, 100000):
        case.path.write_text(text.replace(WATCH, f"{WATCH}continuation.max_points = {stop}\n"))
        done = launch.run(case, *(["--restart"] if stop > 7 else []), out="parts")
    found = Results(done.folder / "results.h5")
    np.testing.assert_array_equal(found.omega, expected.omega)
    np.testing.assert_array_equal(found.coefficients, expected.coefficients)
    assert found.wave.index.tolist() == expected.wave.index.tolist() and len(set(expected.points("harmonics"))) > 1
