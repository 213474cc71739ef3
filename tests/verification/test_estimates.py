"""Estimated errors against the true ones, and runs that keep a tolerance; truth is the same case with many more harmonics."""

import re
import subprocess
import sys
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

import cases
from dovetail import Results
from dovetail.study_errors import distances
from launch import ROOT, SURROUNDINGS, run

OFFSET = 3e-6  # of the sweep, for tangents of the reference

# Kind of motion -> (maker, harmonics of the reference, keys). Slip; lift-off with folds; both, and three harmonics of the load.
SCENES = {"slip": (cases.dof5, 40, {"omega": [0.95, 1.1]}),
          "lift-off": (lambda folder, **keys: cases.single_mass(folder, 1, **keys), 40, {"omega": [14, 11]}),
          "both": (cases.several_points, 30, {"omega": [0.8, 1.2]})}


def settings(name, **keys):
    make, _, own = SCENES[name]
    begin, end = own["omega"]
    frequencies = np.linspace(begin, end, 22)[1:-1]
    return make, {**own, "samples": None, "adaptive": True, "step": 0.02, **cases.TIGHT, **keys}, frequencies, abs(end - begin)


@pytest.fixture(scope="module", params=["slip", "lift-off", pytest.param("both", marks=pytest.mark.slow)])
def scene(request, tmp_path_factory):
    """Name, and a function that gives the true errors of the points of a run at common frequencies, and these points."""
    name = request.param
    make, keys, frequencies, sweep = settings(name, harmonics=SCENES[name][1], estimates=False)
    at = sorted((f + shift * OFFSET * sweep for f in frequencies for shift in (-1, 0, 1)), reverse=keys["omega"][1] < keys["omega"][0])
    folder = tmp_path_factory.mktemp("reference")
    reference = Results(run(make(folder, **keys, at=at)).folder / "results.h5")

    def truth(folder, **where):
        results = Results(folder / "results.h5")
        with h5py.File(folder / "state.h5") as state:
            scales = state["scales"][()]
        points, true = distances(results, reference, scales, sweep, frequencies, OFFSET * sweep)
        assert len(points) >= len(frequencies)
        return results, points, true

    return name, truth


def make_folder(parent, name):
    (parent / name).mkdir()
    return parent / name


def of_balance(results):
    """Estimated errors by harmonics and samples: the references of the scenes have the same modes."""
    return results.points("error_harmonics") + results.points("error_sampling")


def run_of(name, folder, where=None, **keys):
    make, keys, frequencies, _ = settings(name, **keys)
    return run(make(folder, **{"at": list(frequencies), **keys}), **(where or {}))


@pytest.mark.parametrize("harmonics, samples", [(1, None), (3, None), (8, 32), *(pytest.param(*other, marks=pytest.mark.slow) for other in
                                                                                [(5, None), (8, None)])])
def test_estimates_are_near_the_true_errors(scene, tmp_path, harmonics, samples):
    """Within a factor of 5 at nine points of ten, where there is any error."""
    name, truth = scene
    if harmonics < 2 and name == "both":
        pytest.skip("the load has two harmonics")
    results, points, true = truth(run_of(name, tmp_path, harmonics=harmonics, samples=samples).folder)
    some = true > 1e-6
    assert np.all(of_balance(results)[points[~some]] < 1e-5)
    ratio = true[some] / of_balance(results)[points[some]]
    assert np.mean((ratio > 0.2) & (ratio < 5)) >= 0.9, ratio


@pytest.mark.parametrize("harmonics", [3, 5, 10])
@pytest.mark.slow
def test_sampling_is_told_from_harmonics(tmp_path, harmonics):
    """The share of the harmonics is that of the run without samples, also where samples do most of the damage."""
    with_few, exact = (run_of("slip", tmp_path, harmonics=harmonics, samples=N).points for N in (32, None))
    assert np.all(exact["error_sampling"] == 0)
    assert 3e-3 < with_few["error_sampling"].max() < 5e-3
    share, alone = (run["error_harmonics"][np.isin(run["omega"], settings("slip")[2])] for run in (with_few, exact))
    np.testing.assert_allclose(share, alone, rtol=0.03, atol=1e-7)


@pytest.mark.parametrize("samples", [None, 64])
def test_samples_of_a_cone_are_in_the_estimate(tmp_path, samples):
    """Also where their number is left to the program. At one frequency: against the same harmonics with 4096 samples."""
    case = {"law": "cone", "friction": [0.2, 0.2], "fourier": [0, 0, 3], "omega": [0.95, 0.95], "harmonics": 5, **cases.TIGHT}
    points, fine = (run(cases.dof5(tmp_path, [1.0, 1, 1, 0.6, 0], samples=N, **case), out=str(N)).points for N in (samples, 4096))
    q, exact = points["coefficients"][0][:, 1:], fine["coefficients"][0][:, 1:]
    true = np.linalg.norm(q - exact) / np.linalg.norm(exact)
    assert points["stick"][0] == 0 and true > 1e-5
    assert 0.3 * true < points["error_sampling"][0] < 3 * true


# Kind of motion -> (maker, all modes, harmonics, sweep).
WITH_MODES = {"slip": (cases.dof5, 2, 9, [0.95, 1.1]), "stick": (cases.always_stuck, 12, 3, [0.8, 1.6]),
              "both": (cases.several_points, 12, 9, [0.8, 1.2])}


@pytest.mark.parametrize("name, modes", [("slip", 1), ("stick", 5), ("stick", 8), ("both", 4), ("both", 7), ("both", 10)])
@pytest.mark.slow
def test_modes_left_out_are_estimated(tmp_path, name, modes):
    """Against the same case with all modes."""
    make, most, harmonics, omega = WITH_MODES[name]
    frequencies, sweep = np.linspace(*omega, 17)[1:-1], omega[1] - omega[0]
    at = sorted(f + shift * OFFSET * sweep for f in frequencies for shift in (-1, 0, 1))
    keys = {"harmonics": harmonics, "samples": None, "omega": omega, "adaptive": True, "step": 0.02, "kind": "auto", **cases.TIGHT}
    few, every = (run(make(tmp_path, modes=count, at=at, **keys), out=f"{count}") for count in (modes, most))
    results, reference = (Results(done.folder / "results.h5") for done in (few, every))
    assert "error_modes" not in every.points  # nothing is left out
    with h5py.File(few.folder / "state.h5") as state:
        points, true = distances(results, reference, state["scales"][()], sweep, frequencies, OFFSET * sweep)
    assert len(points) >= len(frequencies)
    ratio = true / few.points["error_modes"][points]
    assert np.mean((ratio > 0.2) & (ratio < 5)) >= 0.9, ratio
    assert few.summary["accuracy"]["modes"] == pytest.approx(few.points["error_modes"].max(), rel=1e-2)


def template(folder, harmonics, modes, at):
    """The lap joint of `dovetail new`, with so many harmonics and modes: the sweep's width, and the run."""
    command = [sys.executable, "-m", "dovetail", "new", folder / "joint"]
    subprocess.run(command, check=True, capture_output=True, env=SURROUNDINGS)
    subprocess.run([sys.executable, "model.py"], check=True, capture_output=True, env=SURROUNDINGS, cwd=folder / "joint")
    path = folder / "joint/case.toml"
    text = path.read_text()
    for line, instead in (("# modes = 10", f"modes = {modes}"), ("tolerance = 1e-2", ""), ("# harmonics = 5", f"harmonics = {harmonics}"),
                          ("# at = [11500.0, 12000.0]", f"at = {at}"), ("# enabled = true", "enabled = false")):
        assert text.count(f"\n{line} ") == 1, line
        text = text.replace(f"\n{line} ", f"\n{instead} ")
    path.write_text(text)
    begin, end = map(float, re.search(r"\nomega = \[([\d.]+), ([\d.]+)\]", text).groups())
    return end - begin, run(SimpleNamespace(path=path), out="out")


@pytest.mark.slow
def test_modes_left_out_that_harmonics_meet(tmp_path):
    """Ten harmonics of the lap joint lie beyond the modes that are kept, and near a resonance that those left out move: what they would do
    must not be taken for what the kept ones would do if these stood still."""
    frequencies = np.linspace(11350, 11500, 7)
    at = sorted(float(f + shift * OFFSET * 1600) for f in frequencies for shift in (-1, 0, 1))
    sweep, few = template(make_folder(tmp_path, "few"), 10, 10, at)
    assert sweep == 1600
    _, every = template(make_folder(tmp_path, "every"), 10, 120, at)
    with h5py.File(few.folder / "state.h5") as state:
        scales = state["scales"][()]
    results, reference = (Results(done.folder / "results.h5") for done in (few, every))
    points, true = distances(results, reference, scales, sweep, frequencies, OFFSET * sweep)
    ratio = results.points("error_modes")[points] / true
    assert len(points) >= len(frequencies) and true.max() > 1e-3
    assert np.all((ratio > 0.3) & (ratio < 3)), ratio


@pytest.mark.slow
def test_modes_left_out_of_a_place_do_not_hang_on_its_neighbours(tmp_path):
    """Several frequencies within one step: each has the estimate that it has by itself, though the factors at hand are the last one's.
    Assembled, since iterations solve for estimates to a fifth only."""
    keys = {"modes": 4, "harmonics": 9, "samples": None, "omega": [0.8, 1.2], "adaptive": True, "step": 0.02, "kind": "auto",
            "solver": "assembled", **cases.TIGHT}
    one, three = (run(cases.several_points(tmp_path, at=at, **keys), out=str(len(at))).points for at in ([1.0005], [1.0, 1.0005, 1.001]))
    error, another = (points["error_modes"][points["omega"] == 1.0005] for points in (one, three))
    assert len(error) == len(another) >= 1 and np.all(error > 1e-5)
    np.testing.assert_allclose(error, another, rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("solver, ranks", [("modal", 2), ("assembled", 1), ("assembled", 2)])
def test_modes_left_out_are_the_same_by_any_solver(tmp_path, solver, ranks):
    keys = {"modes": 4, "harmonics": 5, "samples": None, "omega": [0.8, 1.2], "at": [0.9, 1.0, 1.1], "adaptive": True, "step": 0.02,
            "kind": "auto", **cases.TIGHT}
    one = run(cases.several_points(make_folder(tmp_path, "one"), **keys)).points
    other = run(cases.several_points(make_folder(tmp_path, "other"), solver=solver, **keys), ranks=ranks).points
    errors = [points["error_modes"][np.isin(points["omega"], keys["at"])] for points in (one, other)]
    assert len(errors[0]) == len(errors[1]) >= 3 and np.all(errors[0] > 1e-5)
    np.testing.assert_allclose(*errors, rtol=0.2)  # to which iterations solve


@pytest.mark.slow
def test_residuals_leave_out_less(tmp_path):
    """As many modes, some of them residuals: nearer to all modes, and the estimate knows."""
    keys = {"elastic": 60, "harmonics": 5, "samples": None, "omega": [0.3, 0.5], "step": 0.02, "adaptive": True, "at": [0.35, 0.4, 0.45],
            "kind": "none", **cases.TIGHT}
    every, plain, residual = (cases.several_points(make_folder(tmp_path, name), modes=modes, **keys)
                              for name, modes in (("every", 60), ("plain", 30), ("residual", 30)))
    residual.path.write_text(residual.path.read_text().replace("[reduction]", '[reduction]\nkind = "residual"'))
    every, plain, residual = (run(case) for case in (every, plain, residual))
    motion = [np.array([done.points["coefficients"][np.flatnonzero(done.points["omega"] == omega)[0]][-12:, 1:]
                        for omega in keys["at"]]) for done in (every, plain, residual)]
    errors = [np.abs(found - motion[0]).max() for found in motion[1:]]
    assert errors[1] < 0.1 * errors[0]
    assert residual.points["error_modes"].max() < 0.1 * plain.points["error_modes"].max()


@pytest.mark.slow
@pytest.mark.parametrize("tolerance, wanted", [(5e-2, 40), (1e-3, 80)])
def test_modes_are_chosen_by_a_tolerance(tmp_path, tolerance, wanted):
    """Of 80, whose frequencies lie as near to each other as no structure's."""
    keys = {"elastic": 80, "harmonics": None, "samples": None, "omega": [0.3, 0.5], "step": 0.02, "adaptive": True,
            "at": [0.35, 0.4, 0.45], **cases.TIGHT}
    every = run(cases.several_points(make_folder(tmp_path, "every"), modes=80, **{**keys, "harmonics": 30}))
    case = cases.several_points(make_folder(tmp_path, "chosen"), modes=None, tolerance=tolerance, **keys)
    done = run(case)
    with h5py.File(done.folder / "reduced.h5") as file:
        kept = len(file["Kaa"])
    assert kept == wanted and "modes: 20 leave out" in done.out
    assert done.summary["accuracy"]["modes"] < 0.5 * tolerance
    for omega in keys["at"]:
        here, there = (run_of_it.points["coefficients"][np.flatnonzero(run_of_it.points["omega"] == omega)[0]][-12:, 1:]
                       for run_of_it in (done, every))
        width = min(here.shape[1], there.shape[1])
        assert np.linalg.norm(here[:, :width] - there[:, :width]) < 3 * tolerance * np.linalg.norm(there)
    again = run(case)
    assert "reused" in again.out and "modes: 20" not in again.out


def test_a_start_comes_with_its_modes(tmp_path):
    case = cases.several_points(tmp_path, modes=None, tolerance=1e-2, harmonics=None, samples=None)
    case.path.write_text(case.path.read_text().replace("[continuation]", '[continuation]\nstart = "results.h5"'))
    assert "give reduction.modes" in run(case, status=2).err


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
@pytest.mark.slow
def test_tolerance_is_kept(scene, tmp_path, tolerance):
    name, truth = scene
    done = run_of(name, tmp_path, harmonics=None, tolerance=tolerance)
    results, points, true = truth(done.folder)
    assert np.mean(true <= tolerance) >= 0.95, true
    assert not np.any(np.isnan(results.error[points])) and np.mean(np.isnan(results.error)) <= 0.5
    assert done.summary["accuracy"]["tolerance"] == tolerance
    assert done.summary["accuracy"]["above"] == np.sum(results.error > tolerance)
    assert done.summary["accuracy"]["largest"] == pytest.approx(np.nanmax(results.error), rel=1e-2)


@pytest.mark.slow
def test_harmonics_come_and_go(tmp_path):
    """Few where the contact sticks or is always open, more around the resonance; fewer for a wider tolerance."""
    most = []
    for tolerance in (1e-2, 1e-4):
        done = run_of("slip", tmp_path, harmonics=None, tolerance=tolerance, omega=[0.9, 1.3])
        used = done.points["harmonics"]
        assert used[-1] == used.min() == 1 and done.summary["adaptations"] >= 2
        assert done.out.count("from here on (estimated error") == done.summary["adaptations"]
        most.append(used.max())
    assert most[0] < most[1]


@pytest.mark.slow
def test_harmonics_beyond_a_plateau(tmp_path):
    """Stiff contacts that slip: from 5 to 20 harmonics the error stays where it is, above the tolerance, and then falls."""
    model, error = tmp_path / "model.h5", {}
    subprocess.run([sys.executable, ROOT / "inputs/two_solids/model.py", "-o", model], check=True, capture_output=True, env=SURROUNDINGS)
    for name, how in (("15", "harmonics = 15"), ("tolerance", "solver = \"modal\"\n[accuracy]\ntolerance = 1e-4")):
        path = make_folder(tmp_path, name) / "case.toml"
        path.write_text(f"""
model = "{model}"
[reduction]
modes = 5
[damping]
stiffness = 1e-6
[excitation]
fourier = [0, 0, 5]
[continuation]
omega = [4095, 4105]
[stability]
enabled = false
[harmonic_balance]
{how}
""")
        error[name] = np.nanmax(of_balance(Results(run(SimpleNamespace(path=path)).folder / "results.h5")))
    assert error["15"] > 3e-4 and error["tolerance"] <= 1e-4


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.slow
def test_a_curve_that_means_nothing_is_called_so(tmp_path, ranks):
    """A stiff contact hit once a period: with 5 harmonics another curve altogether; the rule wants 1.5 times (40 + 4000)^(1/2)."""
    keys = {"samples": None, "omega": [14, 13], "normal_stiffness": 4000.0, "fourier": [0, 0, 9], "adaptive": True, "step": 0.02,
            "kind": "auto", **cases.TIGHT}
    coarse, fine = (run(cases.single_mass(make_folder(tmp_path, f"{H}"), 1, harmonics=H, **keys), ranks=ranks) for H in (5, 15))
    accuracy = coarse.summary["accuracy"]
    assert accuracy["meaningless"] == np.sum(coarse.points["error_harmonics"] > 0.1) > 0
    assert accuracy["harmonics_wanted"] == pytest.approx(1.5 * np.sqrt(4040) / 13.5, abs=1.0)
    assert "mean nothing: contacts that open and close want some" in coarse.out
    assert fine.summary["accuracy"]["meaningless"] == 0 and "mean nothing" not in fine.out


@pytest.mark.parametrize("omega", [1.0, 1.02, 1.04])
def test_error_at_one_frequency(tmp_path, omega):
    """Of a single point, which has no neighbours to make a curve, it is the error at its frequency."""
    few, many = (run_of("slip", tmp_path, harmonics=H, omega=[omega, omega], at=None).points for H in (3, 40))
    q, exact = few["coefficients"][0], many["coefficients"][0][:, :7]
    rest = many["coefficients"][0][:, 7:]
    true = np.hypot(np.linalg.norm(q[:, 1:] - exact[:, 1:]), np.linalg.norm(rest)) / np.linalg.norm(q[:, 1:])
    assert few["error_harmonics"][0] == pytest.approx(true, rel=0.15)


def test_tolerance_at_one_frequency(tmp_path):
    done = run_of("slip", tmp_path, harmonics=None, tolerance=1e-4, omega=[1.02, 1.02], at=None)
    assert list(done.points["omega"]) == [1.02] and done.points["error_harmonics"][0] < 1e-4 and done.points["harmonics"][0] > 3


@pytest.mark.slow
def test_any_number_of_ranks(tmp_path):
    one, three = (run_of("both", tmp_path, where, harmonics=None, tolerance=1e-3, solver="modal")
                  for where in ({"out": "1"}, {"out": "3", "ranks": 3}))
    wanted = [np.isin(done.points["omega"], settings("both")[2]) for done in (one, three)]
    at_one, at_three = ({name: values[w] for name, values in done.points.items() if name != "contact"}
                        for done, w in zip((one, three), wanted))
    np.testing.assert_array_equal(at_one["omega"], at_three["omega"])
    alike = at_one["harmonics"] == at_three["harmonics"]  # estimates in single precision may drop some a point sooner
    assert np.count_nonzero(~alike) <= 2
    scale = np.abs(one.points["coefficients"]).max()
    difference = np.abs(at_one["coefficients"][:, :, :7] - at_three["coefficients"][:, :, :7]).max(axis=(1, 2)) / scale
    assert difference[alike].max() < 1e-7 and difference.max() < 1e-3  # the tolerance
    np.testing.assert_allclose(at_one["error_harmonics"][alike], at_three["error_harmonics"][alike], rtol=0.05, atol=1e-6)


@pytest.mark.parametrize("keys, words", [
    ({"harmonics": 5, "tolerance": 1e-3}, "accuracy.tolerance chooses the harmonics"),
    ({"harmonics": None, "tolerance": 1e-3, "samples": 64}, "takes exact contact forces"),
    ({"harmonics": None, "tolerance": 1e-3, "estimates": False}, "a tolerance cannot do without"),
    ({"harmonics": None, "tolerance": 2.0}, "less than 1"),
    ({"harmonics": None}, "[accuracy] tolerance = 1e-3")])
def test_what_does_not_go_together_is_refused(tmp_path, keys, words):
    make, keys, _, _ = settings("slip", **keys)
    assert words in run(make(tmp_path, **keys), status=2).err


def test_a_curve_without_error_says_so(tmp_path):
    """One mass that sticks: all of it is in one harmonic. It had been "at most 0.0e+00 (at 0 rad/s)"."""
    done = run(cases.stuck_mass(tmp_path))
    assert "estimated errors: 0 at every point" in done.out
