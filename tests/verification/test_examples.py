"""The examples users start from, run by the compiled program, against published and independently integrated numbers."""

import re
import subprocess
import sys

import h5py
import numpy as np
import pytest

import cases
import launch
import truth
from dovetail import Results
from launch import BINARY, ROOT, SECONDS, SURROUNDINGS
from test_against_core import run


@pytest.fixture(scope="module")
def delivered(tmp_path_factory):
    """The five-dof example with its authors' settings and fixed step."""
    return Results(run(cases.dof5(tmp_path_factory.mktemp("dof5"), adaptive=False)).directory / "results.h5")


@pytest.mark.parametrize("dof, omega, peak", [("a1", 1.02150, 2.699938), ("a2", 1.01925, 0.080870), ("x1.t1", None, 5.724547),
                                              ("x1.t2", None, 3.913528), ("x1.n", 1.02647, 1.920393)])
def test_delivered_peaks(delivered, dof, omega, peak):
    """The original's peaks over the cycle (a fixed step of 0.05 finds the place of a peak to 1e-3)."""
    at, amplitude = truth.top(delivered, truth.over_the_cycle(delivered, dof))
    assert amplitude == pytest.approx(peak, rel=2e-4)
    if omega is not None:
        assert at == pytest.approx(omega, abs=1e-3)


def test_delivered_sweep_is_as_long_as_the_originals(delivered):
    """436 points there; the arc length is measured the same way, only the first tangent and the end differ."""
    assert len(delivered) == pytest.approx(436, rel=0.05)


@pytest.mark.parametrize("omega, exact", [(1.0215, 2.698249), (1.05, 2.526097)])
def test_converged_values(tmp_path, omega, exact):
    """H = 40, N = 4096: the true amplitudes, known from time integration."""
    done = run(cases.dof5(tmp_path, harmonics=40, samples=4096, omega=[omega, omega], kind="auto", **cases.TIGHT))
    assert truth.over_the_cycle(Results(done.directory / "results.h5"), "a1")[0] == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize("omega", [[5, 16], [16, 5]])
def test_mass_that_lifts_off_in_every_cycle(tmp_path, omega):
    """Check 1 against the published normal peak 29.12 at 9.881; lifting off softens, so the curve folds twice."""
    done = run(cases.single_mass(tmp_path, 1, omega=omega, kind="auto"))
    results = Results(done.directory / "results.h5")
    at, amplitude = truth.top(results, truth.over_the_cycle(results, "x1.n"))
    assert amplitude == pytest.approx(29.12, rel=1e-3)
    assert at == pytest.approx(9.881, rel=1e-3)
    steps = np.sign(np.diff(done.omega))
    assert (steps == 1).any() and (steps == -1).any()


@pytest.mark.parametrize("omega", [[5, 16], [16, 5]])
def test_mass_that_slips_before_it_lifts_off(tmp_path, omega):
    """Check 2: the mean tangential position runs off within 11.849 to 11.856, where the contact slips, but does not open yet."""
    done = launch.run(cases.single_mass(tmp_path, 2, omega=omega, kind="auto"))
    assert done.summary["end"] == "arrived" and done.summary["leaps"] == 0 and done.summary["corners"] >= 1
    results = Results(done.folder / "results.h5")
    assert [fold for fold in results.events.of("fold").omega if fold > 11] == [pytest.approx(11.867237, abs=1e-6)]
    assert truth.over_the_cycle(results, "x1.n").max() == pytest.approx(29.13, rel=1e-3)
    tangential = results.amplitude("x1.t1")[results.omega < 9].max()
    assert tangential == pytest.approx(29.88, rel=1e-3)


@pytest.mark.parametrize("omega, turn", [([11.8, 11.862], 95), ([16, 5], 160)])
def test_corner_that_arc_length_cannot_turn(tmp_path, omega, turn):
    """Check 2 near 11.856: where the mass begins to lift off the curve turns by so much that a plane of arc length across the old
    tangent never meets the new leg."""
    done = launch.run(cases.single_mass(tmp_path, 2, omega=omega, kind="auto"))
    assert done.summary["end"] == "arrived" and done.summary["leaps"] == 0
    turns = re.findall(r"^ +11\.85\d* corner of the curve, turning by (\d+) degrees", done.out, re.MULTILINE)
    assert turns and max(map(int, turns)) >= turn


def make_posts(folder, *options):
    """model.h5 of inputs/two_solids."""
    command = [sys.executable, ROOT / "inputs/two_solids/model.py", "-o", folder / "model.h5", *options]
    subprocess.run(command, check=True, capture_output=True, env=SURROUNDINGS)


AT = [4090.0, 4095.0, 4100.0, 4105.0, 4110.0]


@pytest.fixture(scope="module")
def posts(tmp_path_factory):
    """inputs/two_solids with a short sweep over the top of its resonance, on 1 and 2 ranks."""
    folder = tmp_path_factory.mktemp("two_solids")
    make_posts(folder)
    text = (ROOT / "inputs/two_solids/case.toml").read_text()
    assert "omega = [4000, 4250]" in text
    text = text.replace("omega = [4000, 4250]", f"omega = [4085, 4135]\nat = {AT}").replace("harmonics = 10", "harmonics = 3")
    done = {}
    for ranks in (1, 2):  # the whole sweep on one rank, the way into slip on several
        case = folder / f"case{ranks}.toml"
        case.write_text(text + ("max_points = 25\n" if ranks > 1 else "") +
                        "\n[newton]\nstep_tolerance = 1e-10\nresidual_tolerance = 1e-9\n")
        command = ["mpirun", "-n", str(ranks), BINARY, "run", case, "--out", folder / f"out{ranks}"]
        subprocess.run(command, check=True, capture_output=True, env=SURROUNDINGS, timeout=SECONDS)
        done[ranks] = Results(folder / f"out{ranks}" / "results.h5")
    return done


@pytest.mark.slow
def test_posts_fixed_interface_frequencies(tmp_path):
    """Published for the original's mesh of about this size with the four corners of the patch held."""
    make_posts(tmp_path, "--points", "2x2")
    (tmp_path / "case.toml").write_text((ROOT / "inputs/two_solids/case.toml").read_text())
    subprocess.run([BINARY, "reduce", tmp_path / "case.toml"], check=True, capture_output=True, env=SURROUNDINGS)
    with h5py.File(tmp_path / "reduced.h5") as file:
        frequencies = np.sqrt(file["Kaa"][()]) / (2 * np.pi)
    np.testing.assert_allclose(frequencies, [808.6, 1508.8, 2727.2, 2989.6, 4226.1], rtol=0.02)


@pytest.mark.slow
def test_more_posts_points_slip_towards_resonance(posts):
    slip = posts[1].points("slip")
    amplitude = posts[1].amplitude("x4.t2")
    assert slip[0] < slip.max() / 2
    assert slip[amplitude.argmax()] == slip.max() > 0.5


@pytest.mark.slow
def test_posts_friction_limits_the_peak(posts):
    """The linear peak is four times as high; the NumPy reference finds 148.5 um at 654 Hz with H = 3 on a 1 Hz grid."""
    omega, amplitude = posts[1].peak("x4.t2")
    assert amplitude == pytest.approx(148e-6, rel=0.01)
    assert omega / (2 * np.pi) == pytest.approx(653.6, abs=0.5)


@pytest.mark.slow
def test_posts_on_two_ranks(posts):
    one, many = posts[1], posts[2]
    assert len(many) == 25
    assert many.points("slip").max() > many.points("slip")[0]  # points begin to slip on the way
    np.testing.assert_allclose(many.omega, one.omega[:25], rtol=1e-8)
    for omega in AT:  # elsewhere steps differ by 1e-7 of their length, and the motion by the slope of the curve times that
        mine, theirs = (results.coefficients_at(results.at(omega)) for results in (one, many))
        np.testing.assert_allclose(theirs, mine, rtol=0, atol=1e-8 * np.abs(mine).max())
