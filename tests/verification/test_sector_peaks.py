"""Peaks of a sector over a parameter against dense sweeps, and their derivatives against peaks of cases that are computed anew."""

import h5py
import numpy as np
import pytest

import cyclic_sector
import launch
from dovetail import Results
from small_wave import SHROUD, scene

WATCHED = "a1"
SENSITIVE = f'sensitivity.of = "{WATCHED}"\n'
FORCE = 40.0
SWEEP = {2: (1992.0, 2000.0), 1: (2330.0, 2350.0)}  # around the peak
GIVEN = cyclic_sector.given("eo2_separation")
CONTACT = {"friction": SHROUD, "normal_stiffness": GIVEN["kn"], "tangential_stiffness": GIVEN["kt"], "gap": GIVEN["gap"]}
# Of contact point 8, between the shrouds, in the direction in which it slips; the gap of 7.
PLACES = {"friction": (7, 0), "normal_stiffness": 7, "tangential_stiffness": (7, 0), "gap": 6}


def sensitivity(folder, force=FORCE, edit=str, **changed):
    """Peak and derivatives of the one peak within the sweep."""
    done = launch.run(scene(folder, 2, force, omega=SWEEP[2], more=SENSITIVE, edit=edit, **{**CONTACT, **changed}))
    with h5py.File(done.folder / "results.h5") as file:
        group = file["sensitivity"]
        assert len(group["omega"]) == 1 and done.points["slip"].max() > 0
        return {name: group[name][0] for name in ("omega", "amplitude")} | {
            f"{name}_by": {key: values[0] for key, values in group[f"{name}_by"].items()} for name in ("omega", "amplitude")}


@pytest.fixture(scope="module")
def nominal(tmp_path_factory):
    return sensitivity(tmp_path_factory.mktemp("nominal"))


def other(name, factor):
    """Keywords of `sensitivity` for a parameter that many times what it is."""
    if name == "force":
        return {"force": FORCE * factor}
    if name == "damping":
        return {"edit": lambda text: text.replace("damping.stiffness = 2.5e-05", f"damping.stiffness = {2.5e-5 * factor!r}")}
    values = CONTACT[name].copy()
    values[PLACES[name]] *= factor
    return {name: values}


@pytest.mark.parametrize("name", ["friction", *(pytest.param(name, marks=pytest.mark.slow) for name in (
    "tangential_stiffness", "normal_stiffness", "gap", "force", "damping"))])
def test_derivatives_against_peaks_computed_anew(tmp_path, nominal, name):
    """By an extrapolated central difference."""
    slopes = {"omega": 0.0, "amplitude": 0.0}
    for h, weight in ((2e-3, -1 / 3), (1e-3, 4 / 3)):
        for side in (1, -1):
            (folder := tmp_path / f"{side * h}").mkdir()
            found = sensitivity(folder, **other(name, 1 + side * h))
            for number in slopes:
                slopes[number] += side * weight * found[number] / (2 * h)
    value = CONTACT[name][PLACES[name]] if name in CONTACT else 1.0
    for number, slope in slopes.items():
        own = nominal[f"{number}_by"][name][PLACES.get(name, ())] * value
        assert abs(own - slope) < 1e-6 * max(abs(slope), 1e-2 * nominal[number]), (number, own, slope)
        assert abs(slope) > 1e-5 * nominal[number], "the parameter matters"


def track(folder, parameter, end, at=(), ranks=None, order=2, peak="amplitude"):
    path = f'path = {{ parameter = "{parameter}", range = [1.0, {end}], peak = "{peak}", at = {list(at)} }}\n'
    case = scene(folder, order, FORCE, omega=SWEEP[order], more=f'continuation.watch = "{WATCHED}"\n' + path, **CONTACT)
    return launch.run(case, ranks=ranks)


def rows_at(results, values):
    rows = [int(np.flatnonzero(results.parameter == value)[0]) for value in values]
    return np.column_stack([results.omega[rows], results.tracked_amplitude[rows]])


@pytest.mark.parametrize("order, parameter, end", [(2, "friction", 0.9), pytest.param(1, "force", 1.3, marks=pytest.mark.slow),
                                                   pytest.param(2, "tangential_stiffness", 0.97, marks=pytest.mark.slow)])
def test_a_track_against_a_dense_sweep(tmp_path, order, parameter, end):
    """The maximum of the rms amplitude where the track ends, from a polynomial through points of an ordinary sweep close to it."""
    (folder := tmp_path / "track").mkdir()
    results = Results(track(folder, parameter, end, order=order).folder / "results.h5")
    begin, (omega, amplitude) = rows_at(results, [1.0, end])
    assert abs(amplitude / begin[1] - 1) > 1e-3 and results.points("slip")[-1] > 0
    force = FORCE * (end if parameter == "force" else 1)
    contact = CONTACT if parameter == "force" else {**CONTACT, parameter: end * CONTACT[parameter]}
    frequencies = omega * np.linspace(1 - 2e-4, 1 + 2e-4, 9)
    more = f'continuation.watch = "{WATCHED}"\ncontinuation.at = {frequencies[1:-1].tolist()}\n'
    (folder := tmp_path / "dense").mkdir()
    case = scene(folder, order, force, omega=(frequencies[0], frequencies[-1]), more=more, **contact)
    dense = Results(launch.run(case).folder / "results.h5")
    rows = [int(np.argmin(np.abs(dense.omega - one))) for one in frequencies]
    x = (dense.omega[rows] / omega - 1) / 2e-4
    squares = np.sum(dense.coefficients[rows, dense.dof_index(WATCHED), 1:]**2, axis=1)
    fit = np.polynomial.Polynomial.fit(x, squares, 6, domain=[-1, 1])
    assert np.abs(fit(x) / squares - 1).max() < 1e-11  # no corner in between
    tops = [root.real for root in fit.deriv().roots() if abs(root.imag) < 1e-9 and abs(root) < 1]
    assert len(tops) == 1
    assert abs(amplitude / np.sqrt(fit(tops[0])) - 1) < 1e-8 and abs(2e-4 * tops[0]) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [2, 3])
def test_ranks_do_not_change_the_track(tmp_path, ranks):
    found = []
    for count in (None, ranks):
        (folder := tmp_path / str(count)).mkdir()
        found.append(rows_at(Results(track(folder, "friction", 0.98, [0.99], count).folder / "results.h5"), [0.99, 0.98]))
    assert np.abs(found[1] / found[0] - 1).max() < 1e-8


def test_in_phase_the_load_works_a_quarter_period_ahead(tmp_path):
    """Of the harmonic that the load has: its work on the motion in phase with it is zero, that out of phase is what is dissipated."""
    done = track(tmp_path, "force", 1.05, peak="phase")
    results, case = Results(done.folder / "results.h5"), cyclic_sector.of_every_index("eo2_separation", 12)[2]
    force = FORCE * results.parameter[-1] * np.concatenate([case["Fa"][0], case["Fx"][0]])
    q = results.coefficients[-1]
    work = np.vdot(force, q[:, 1] - 1j * q[:, 2])
    assert abs(work.real) < 1e-8 * abs(work) and work.imag < 0
