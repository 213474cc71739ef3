"""What a run says of the amplitude between its points, against runs with far more points."""

import cases
import numpy as np
import pytest
from launch import run
from scipy.interpolate import Akima1DInterpolator, CubicHermiteSpline

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
