"""What a run says of the amplitude between its points, against runs with far more points."""

import cases
import h5py
import numpy as np
import pytest
from launch import run
from scipy.interpolate import Akima1DInterpolator, CubicHermiteSpline
from scipy.spatial import cKDTree

from dovetail import Results

# Kind of motion -> (maker, keys, arc length of a fine step).
SCENES = {"dof5": (cases.dof5, {"omega": [0.95, 1.2], "harmonics": 5}, 1e-2),
          "several points": (cases.several_points, {"omega": [0.8, 1.2], "harmonics": 5}, 3e-3)}


def curve(done):
    """Frequency and largest amplitude of any contact dof at every point."""
    results = Results(done.folder / "results.h5")
    dofs = [name for name in results.dof_names() if name.startswith("x")]
    return results.omega, np.max([results.amplitude(dof) for dof in dofs], axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCENES)
def test_amplitude_between_points(tmp_path, scene):
    """The largest error is known within a factor of 3, and of four errors that count three within a factor of 5."""
    make, keys, fine = SCENES[scene]
    keys = {**keys, "samples": None, **cases.TIGHT}
    coarse = run(make(tmp_path, **keys, adaptive=True, step=0.02), out="coarse")
    omega, amplitude = curve(run(make(tmp_path, **keys, adaptive=False, step=fine, estimates=False), out="fine"))
    arc = Results(tmp_path / "fine/results.h5").points("arclength")
    assert np.all(np.diff(omega) > 0)
    truth, place = Akima1DInterpolator(arc, amplitude), Akima1DInterpolator(omega, arc)
    omega, amplitude = curve(coarse)
    estimates = coarse.points["error_between"]
    s = np.clip(place(np.clip(omega, place.x[0], place.x[-1])), arc[0], arc[-1])  # the ends to rounding
    slope = truth(s, 1)
    errors = np.full(len(s), np.nan)
    for i in range(1, len(s)):
        between = np.linspace(s[i - 1], s[i], 40)
        cubic = CubicHermiteSpline(s[i - 1:i + 1], amplitude[i - 1:i + 1], slope[i - 1:i + 1])
        errors[i] = np.abs(cubic(between) - truth(between)).max() / amplitude[:i + 1].max()
    known = np.isfinite(estimates)
    assert known.sum() > 0.9 * len(s)
    largest = np.nanmax(estimates)
    assert 1 / 3 < np.nanmax(errors[known]) / largest < 3
    count = known & (errors > 0.05 * largest)
    ratio = errors[count] / estimates[count]
    assert np.mean((ratio > 0.2) & (ratio < 5)) >= 0.75, ratio
    assert coarse.summary["accuracy"]["between"] == pytest.approx(largest, rel=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCENES)
def test_the_curve_that_is_drawn(tmp_path, scene):
    """Its distance from the points of a fine run, relative to its height and to the sweep, is what was asked for; fewer points draw it
    less well."""
    make, keys, fine = SCENES[scene]
    keys = {**keys, "samples": None, **cases.TIGHT, "estimates": False}
    finest, counts = Results(run(make(tmp_path, **keys, adaptive=False, step=fine), out="fine").folder / "results.h5"), []
    dof = finest.watched
    reach, top = abs(finest.omega[-1] - finest.omega[0]), finest.amplitude(dof).max()
    for between in (1e-2, 1e-3, 1e-4):
        results = Results(run(make(tmp_path, **keys, adaptive=True, step=0.02, between=between), out=f"{between}").folder / "results.h5")
        along, amplitude = results.curve(dof, n=4000)  # far closer to each other than to the curve
        drawn = np.c_[along / reach, amplitude / top]
        distance = cKDTree(drawn).query(np.c_[finest.omega / reach, finest.amplitude(dof) / top])[0]
        assert distance.max() < 3 * between, between  # which holds at the middle of a step, and for all dofs in the mean
        counts.append(len(results))
    assert counts[0] < counts[1] < counts[2]


def test_runs_without_tangents_are_drawn_through_their_points(tmp_path):
    done = run(cases.dof5(tmp_path, harmonics=3, samples="exact", adaptive=True, step=0.02), out="out")
    results = Results(done.folder / "results.h5")
    along, amplitude = results.curve("x1.t1", n=4)
    at = np.flatnonzero(np.isin(along, results.along))
    np.testing.assert_allclose(amplitude[at], results.amplitude("x1.t1"), rtol=1e-12)
    assert len(along) > 3 * len(results)
    with h5py.File(done.folder / "results.h5", "r+") as file:
        del file["points/tangent"]
    along, amplitude = Results(done.folder / "results.h5").curve("x1.t1")
    np.testing.assert_array_equal(along, results.along)
    np.testing.assert_allclose(amplitude, results.amplitude("x1.t1"), rtol=1e-12)
