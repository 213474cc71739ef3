"""Nonlinear modes ([mode]): closed forms, exact periods, energies, given backbones, ranks, forced motions, refusals.

dof5.npz and chain.npz hold modes found by a dense program of its own, with its own contact law, whose equations it fulfils to 1e-9;
liftoff.npz the exact period of a bilinear oscillator. Both are as they were given, units without names.
"""

import json
from pathlib import Path

import h5py
import numpy as np
import pytest

import cases
import launch
from dovetail import Results, reference
from dovetail.__main__ import main
from dovetail.modes import Backbone
from test_against_core import close

DATA = Path(__file__).parent / "data"


def mode_of(folder, reduced, mode, **settings):
    with h5py.File(folder / "reduced.h5", "w") as file:
        for name, values in (("Kaa", reduced.kaa), ("Max", reduced.max), ("Mxx", reduced.mxx), ("Kxx", reduced.kxx),
                             ("Fa", reduced.fa), ("Fx", reduced.fx), ("R", reduced.r)):
            file[name] = values
        file.attrs["format"], file.attrs["version"] = "dovetail-reduced", 1
    known = dict(stiffness=0.0, fourier=[0, 1], gap=0.0, initial=0.0, kind="auto", **cases.TIGHT) | settings
    case = cases.write(folder, "mode", "reduced.h5", None, reduced, {}, **known)
    with_mode(case, **mode)
    return case


def with_mode(case, **mode):
    text = "\n[mode]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in mode.items() if value is not None)
    case.path.write_text(case.path.read_text() + text)


def one_mass(stiffness, preload, force=(1.0, 0, 0)):
    return reference.Reduced(kaa=np.array([100.0]), max=np.zeros((1, 3)), mxx=np.eye(3), kxx=np.diag(stiffness), fa=np.zeros(1),
                             fx=np.array(force), r=-np.array(preload))


def scene(folder, name, solver=None, **mode):
    """The backbone of dof5.npz or chain.npz, as a case at the same harmonics, and the data."""
    data = np.load(DATA / f"{name}.npz")
    x, K, M = 3 * len(data["par"]), data["K"], data["M"]
    force = data["load"][:, 2] + data["load"][:, 1]
    course = [0, 0, 1] if np.any(data["load"][:, 2]) else [0, 1]
    reduced = reference.Reduced(kaa=np.diag(K)[:-x].copy(), max=M[:-x, -x:], mxx=M[-x:, -x:], kxx=K[-x:, -x:], fa=force[:-x],
                                fx=force[-x:], r=-data["static"][-x:])
    par = data["par"]
    damping = float(np.sum(data["C"] * K) / np.sum(K * K))
    np.testing.assert_allclose(data["C"], damping * K, atol=1e-14)
    wanted = {"number": 1, "amplitude": [0.1 * float(data["onset_alpha"]), 1.0001 * float(data["alpha"].max())],
              "at": sorted(data["alpha"].tolist())} | mode
    return mode_of(folder, reduced, wanted, stiffness=damping, fourier=course, harmonics=int(data["H"]),
                   normal_stiffness=par[:, 0].tolist(), tangential_stiffness=par[:, 1:3].tolist(), friction=par[:, 3:5].tolist(),
                   gap=par[:, 5].tolist(), solver=solver), data


def at(points, amplitudes):
    """Indices of the points at these amplitudes."""
    found = [int(np.argmin(abs(points["modal_amplitude"] - amplitude))) for amplitude in amplitudes]
    np.testing.assert_allclose(points["modal_amplitude"][found], amplitudes, rtol=1e-14)
    return found


def in_phase(q, other, M):
    """q at the instant at which its first harmonic is in phase with that of `other`; (dofs, 2H+1) coefficients."""
    first, wanted = (c[:, 1] - 1j * c[:, 2] for c in (q, other))
    angle = np.angle(first.conj() @ M @ wanted)
    out = q.copy()
    for k in range(1, (q.shape[1] + 1) // 2):
        z = (q[:, 2 * k - 1] - 1j * q[:, 2 * k]) * np.exp(1j * k * angle)
        out[:, 2 * k - 1], out[:, 2 * k] = z.real, -z.imag
    return out


def balanced(points):
    """Energies balance to 1e-10 of what is fed, or to rounding errors where nothing is."""
    assert np.all(np.abs(points["energy_error"]) <= 1e-10 * points["damping_ratio"] + 1e-15)


def test_a_jenkins_element_in_closed_form(tmp_path):
    k, kt, limit = 1.0, 0.25, 0.2
    slip = limit / kt
    amplitudes = slip * np.geomspace(0.2, 50, 15)
    case = mode_of(tmp_path, one_mass([k, 4.0, 9.0], [0, 0, 10.0]),
                   {"near": 1.1, "amplitude": [amplitudes[0], amplitudes[-1]], "at": amplitudes[1:-1].tolist()}, harmonics=1,
                   normal_stiffness=1.0, tangential_stiffness=[kt, kt], friction=[limit, limit])
    done = launch.run(case)
    points = done.points
    found = at(points, amplitudes)
    a = amplitudes[amplitudes > slip]
    turn = np.arccos(1 - 2 * slip / a)
    omega = np.r_[np.full(len(amplitudes) - len(a), np.sqrt(k + kt)), np.sqrt(k + kt / np.pi * (turn - np.sin(2 * turn) / 2))]
    zeta = np.r_[np.zeros(len(amplitudes) - len(a)), 2 * limit * (a - slip) / (np.pi * omega[-len(a):] ** 2 * a ** 2)]
    np.testing.assert_allclose(points["omega"][found], omega, rtol=1e-10)
    np.testing.assert_allclose(points["damping_ratio"][found], zeta, rtol=1e-10, atol=1e-13)
    np.testing.assert_allclose(points["friction_energy"][found][-len(a):], 4 * limit * (a - slip), rtol=1e-10)
    force = 2 * zeta * omega ** 2 * amplitudes  # of a mass of 1 that is pushed with 1
    np.testing.assert_allclose(points["force_level"][found], force, rtol=1e-9, atol=1e-13)
    balanced(points)
    mode = done.summary["mode"]
    assert abs(mode["onset"] - slip) < 1e-12 and mode["onset_kind"] == "slips" and mode["onset_point"] == 1
    assert abs(mode["omega"] - np.sqrt(k + kt)) < 1e-12


def test_a_mass_that_lifts_off_has_the_exact_period(tmp_path):
    data = np.load(DATA / "liftoff.npz")
    k, kn, push, c = (float(data[name]) for name in ("k", "kn", "push", "c"))
    amplitudes = data["alpha_exact"]
    onset = push / (k + kn)  # the point is pressed with kn times this
    assert amplitudes.max() > 2 * onset
    case = mode_of(tmp_path, one_mass([1.5, 2.5, k], [0, 0, push], force=(0.0, 0, 1)),
                   {"near": float(np.sqrt(k + kn)), "amplitude": [0.1 * onset, float(amplitudes.max())],
                    "at": [a for a in amplitudes if a < amplitudes.max()]}, mass=c, harmonics=41, normal_stiffness=kn, law="unilateral")
    done = launch.run(case)
    points = done.points
    found = at(points, amplitudes)
    np.testing.assert_allclose(points["omega"][found], data["omega_exact"], rtol=1e-8)
    np.testing.assert_allclose(points["damping_ratio"][found], c / (2 * data["omega_exact"]), rtol=1e-8)
    np.testing.assert_allclose(points["friction_energy"], 0, atol=1e-10)
    balanced(points)
    assert abs(done.summary["mode"]["onset"] - onset) < 1e-12 and done.summary["mode"]["onset_kind"] == "lifts off"
    assert Backbone.read(done.folder / "results.h5").linear_below


def test_a_mode_that_begins_with_lift_off_is_not_linear_below(tmp_path):
    """Nothing slips, and the point is closed or open all the time, as beneath the onset."""
    mode = {"near": float(np.sqrt(1.5)), "amplitude": [2.0, 3.0]}
    case = mode_of(tmp_path, one_mass([3.7, 5.1, 1.0], [0, 0, 1.0], force=(0.0, 0, 1)), mode, mass=0.01, harmonics=9,
                   normal_stiffness=0.5, law="unilateral")
    path = launch.run(case).folder / "results.h5"
    with h5py.File(path, "r+") as file:  # as if it began there
        begin = int(np.flatnonzero(file["points/open"][()] > 0.1)[0])
        for name in list(file["points"]) + [f"contact/{name}" for name in file["points/contact"]]:
            if isinstance(file[f"points/{name}"], h5py.Dataset):
                values = file[f"points/{name}"][begin:]
                del file[f"points/{name}"]
                file[f"points/{name}"] = values
    results = Results(path)
    assert results.points("slip")[0] == 0 and results.points("stick")[0] + results.points("open")[0] == 1
    assert results.points("open")[0] > 0 and not Backbone.read(results).linear_below


@pytest.mark.parametrize("solver", ["assembled", "modal"])
@pytest.mark.parametrize("name", ["dof5", "chain"])
def test_given_backbones(tmp_path, name, solver):
    case, data = scene(tmp_path, name, solver)
    done = launch.run(case)
    points = done.points
    order = np.argsort(data["alpha"])
    found = at(points, data["alpha"][order])
    for ours, theirs in (("omega", "omega"), ("damping_ratio", "zeta"), ("friction_energy", "friction_energy")):
        np.testing.assert_allclose(points[ours][found], data[theirs][order], rtol=1e-7, atol=1e-12, err_msg=ours)
    for i, j in zip(found, order):
        theirs = data["Y"][j].copy()
        theirs[:, 0] -= 2 * data["xp"]
        close(in_phase(points["coefficients"][i], theirs, data["M"]), theirs, 1e-7)
    balanced(points)
    assert abs(done.summary["mode"]["onset"] / float(data["onset_alpha"]) - 1) < 1e-5
    assert abs(done.summary["mode"]["omega"] / data["stuck_omega"][0] - 1) < 1e-9
    shape = h5py.File(done.folder / "results.h5")["mode/shape"][()]
    np.testing.assert_allclose(np.abs(shape), np.abs(data["stuck_mode"]), atol=1e-9)
    assert len(points["omega"]) < 150


def test_onset_is_where_the_first_point_slips(tmp_path):
    """Of the chain: at a millionth below it every point sticks all round, above it one slips."""
    onset = float(np.load(DATA / "chain.npz")["onset_alpha"])
    case, _ = scene(tmp_path, "chain", amplitude=[0.9 * onset, 1.1 * onset], at=[onset * (1 - 1e-5), onset * (1 + 1e-5)])
    points = launch.run(case).points
    below, above = at(points, [onset * (1 - 1e-5), onset * (1 + 1e-5)])
    assert np.all(points["contact/stick"][below] == 1) and np.count_nonzero(points["contact/stick"][above] < 1) == 1


@pytest.mark.parametrize("solver, ranks", [("assembled", 3), ("modal", 2)])
def test_ranks_do_not_change_the_mode(tmp_path, solver, ranks):
    case, data = scene(tmp_path, "chain", solver, at=[0.3, 1.0])
    alone = launch.run(case).points
    together = launch.run(case, ranks=ranks).points
    for name in ("omega", "damping_ratio", "force_level", "modal_amplitude"):
        close(together[name], alone[name], 1e-8)
    for q, other in zip(together["coefficients"], alone["coefficients"]):
        close(in_phase(q, other, data["M"]), other, 1e-8)


def test_the_force_level_is_where_the_forced_motion_resonates(tmp_path):
    """Under that load, at the frequency of the mode, the first harmonic is a quarter period behind and of that size, as far as one
    mode tells."""
    (tmp_path / "mode").mkdir()
    (tmp_path / "forced").mkdir()
    case, data = scene(tmp_path / "mode", "dof5", to_force=0.7)
    done = launch.run(case)
    points = done.points
    assert done.summary["end"] == "arrived" and abs(points["force_level"][-1] - 0.7) < 1e-7
    forced, _ = scene(tmp_path / "forced", "dof5")
    text = forced.path.read_text().replace("fourier = [0, 0, 1]", "fourier = [0, 0, 0.7]")
    omega = float(points["omega"][-1])
    text = text[:text.index("[mode]")] + f"[continuation]\nomega = [{0.8 * omega!r}, {omega!r}]\n"
    forced.path.write_text(text)
    response = launch.run(forced).points["coefficients"][-1]
    mode = in_phase(points["coefficients"][-1], response, data["M"])
    first = response[:, 1:3].ravel()
    assert np.linalg.norm(mode[:, 1:3].ravel() - first) < 0.05 * np.linalg.norm(first)


def test_a_force_level_below_the_onset(tmp_path):
    """There the load is in proportion to the amplitude; a level below the first one is told."""
    onset = float(np.load(DATA / "dof5.npz")["onset_alpha"])
    for name in ("whole", "below"):
        (tmp_path / name).mkdir()
    case, _ = scene(tmp_path / "whole", "dof5", amplitude=[0.1 * onset, 0.5 * onset], at=None)
    first = float(launch.run(case).points["force_level"][0])
    for from_, at_ in ((0.1, [0.2 * onset]), (0.9, None)):  # also before the range begins
        case, _ = scene(tmp_path / "below", "dof5", amplitude=[from_ * onset, 2 * onset], at=at_, to_force=6 * first)
        done = launch.run(case)
        assert done.summary["end"] == "arrived" and abs(done.points["force_level"][-1] / (6 * first) - 1) < 1e-9
        assert abs(done.points["modal_amplitude"][-1] / (0.6 * onset) - 1) < 1e-9
        assert len(done.points["omega"]) == (3 if at_ else 1)
    case.edit(f"to_force = {6 * first!r}", f"to_force = {0.5 * first!r}")
    done = launch.run(case)
    assert len(done.points["omega"]) == 1 and "mode.to_force is reached at the first amplitude already" in done.out


def test_every_kind_of_damping_balances(tmp_path):
    data = np.load(DATA / "dof5.npz")
    ratio = 0.01
    for i, (damping, zeta) in enumerate(((dict(structural=0.02), None), (dict(mass=0.03), None),
                                         (dict(ratios=[[1, ratio]], of="stuck"), ratio))):
        (folder := tmp_path / str(i)).mkdir()
        case, _ = scene(folder, "dof5")
        text = case.path.read_text()
        start = text.index("[damping]")
        end = text.index("[", start + 1)
        lines = "".join(f"{key} = {json.dumps(value)}\n" for key, value in damping.items())
        case.path.write_text(text[:start] + "[damping]\n" + lines + "\n" + text[end:])
        points = launch.run(case).points
        balanced(points)
        first = points["damping_ratio"][0]
        omega = data["stuck_omega"][0]
        if zeta is not None:
            assert abs(first - zeta) < 1e-10
        if "mass" in damping:
            assert abs(first - damping["mass"] / (2 * omega)) < 1e-10
        assert points["damping_ratio"].max() > 1.5 * first


def test_a_mode_that_bends_back_in_its_amplitude(tmp_path):
    """With little damping mode 1 of the five dofs meets a multiple of itself in a higher mode: two folds, and an amplitude that is
    passed three times."""
    case, _ = scene(tmp_path, "dof5", amplitude=[1.0, 30.0], at=[10.0])
    text = case.path.read_text()
    start, end = text.index("[damping]"), text.index("[excitation]")
    case.path.write_text(text[:start] + "[damping]\nstiffness = 0.002\n\n" + text[end:])
    done = launch.run(case)
    points = done.points
    folds = done.summary["located"]["folds"]
    assert done.summary["folds"] == 2 and [points["located"][fold["point"]] for fold in folds] == [1, 1]
    first, second = (fold["parameter"] for fold in folds)
    assert first > 10 > second
    assert first == points["modal_amplitude"][:folds[1]["point"]].max()
    assert second == points["modal_amplitude"][folds[0]["point"]:].min()
    assert np.count_nonzero(points["modal_amplitude"] == 10) == 3
    balanced(points)
    with pytest.warns(UserWarning, match=f"turns back in its amplitude at {first:.6g}; "):
        Backbone.read(done.folder / "results.h5")


def test_peaks_made_of_a_mode(tmp_path):
    """`dovetail.modes` on a run, against peaks of the given forced motions: as near as one mode comes to them."""
    case, data = scene(tmp_path, "dof5")
    done = launch.run(case)
    backbone = Backbone.read(done.folder / "results.h5")
    row = int(data["watch"])
    for force, (omega, amplitude) in zip(data["forces"][:4], data["peak"]):
        best = max(backbone.peaks(force=float(force)), key=lambda motion: motion.amplitude(row))
        rms = np.linalg.norm(best.coefficients[row, 1:])
        assert abs(best.omega / omega - 1) < 5e-3 and abs(rms / amplitude - 1) < 1.5e-2


def test_two_modes_of_one_frequency_are_told(tmp_path):
    """A mass alike in both directions, without friction: any direction is a mode, and Newton's method has no reason for one."""
    case = mode_of(tmp_path, one_mass([4.0, 4.0, 9.0], [0, 0, 1.0]), {"number": 1, "amplitude": [0.5, 1.0]}, normal_stiffness=16.0,
                   tangential_stiffness=1.0, friction=0.0, harmonics=1)
    said = launch.run(case, status=3)
    assert "mode 2 of the stuck structure has the same frequency" in said.err and "0 times the load" not in said.out


def test_a_range_below_the_onset_is_told(tmp_path):
    onset = float(np.load(DATA / "dof5.npz")["onset_alpha"])
    case, data = scene(tmp_path, "dof5", amplitude=[0.1 * onset, 0.8 * onset], at=[0.5 * onset])
    done = launch.run(case)
    assert "below the onset" in done.out and [w["kind"] for w in done.summary["warnings"]] == ["no_slip"]
    assert len(done.points["omega"]) == 3
    np.testing.assert_allclose(done.points["omega"], data["omega"][0], rtol=1e-7)  # of the stuck structure with its damping
    np.testing.assert_allclose(done.points["omega"], done.points["omega"][0], rtol=1e-12)


def test_a_range_above_the_onset_begins_there(tmp_path):
    onset = float(np.load(DATA / "dof5.npz")["onset_alpha"])
    (tmp_path / "whole").mkdir()
    case, _ = scene(tmp_path / "whole", "dof5", amplitude=[0.1 * onset, 4 * onset], at=[2 * onset])
    whole = launch.run(case).points
    case, _ = scene(tmp_path, "dof5", amplitude=[2 * onset, 4 * onset], at=None)
    points = launch.run(case).points
    assert points["modal_amplitude"][0] == 2 * onset and points["modal_amplitude"][-1] == 4 * onset
    i = at(whole, [2 * onset])[0]
    close(points["omega"][[0, -1]], whole["omega"][[i, -1]], 1e-9)


def test_a_load_that_does_no_work_on_the_mode(tmp_path, capsys):
    """It has no force level, which is told; the mode is there all the same."""
    wish = {"near": 1.1, "amplitude": [0.1, 3.0]}
    settings = dict(harmonics=1, normal_stiffness=1.0, tangential_stiffness=[0.25, 0.25], friction=[0.2, 0.2])
    case = mode_of(tmp_path, one_mass([1.0, 4.0, 9.0], [0, 0, 10.0], force=(0.0, 1, 0)), wish, **settings)
    done = launch.run(case)
    assert "does no work on this mode" in done.out and np.all(np.isinf(done.points["force_level"]))
    assert done.summary["mode"]["force_level"] is None
    assert main(["plot", str(done.folder / "results.h5"), "--kind", "mode"]) == 0
    assert "frequency and damping alone" in capsys.readouterr().err and (done.folder / "results_mode.png").stat().st_size > 1000
    case.edit("amplitude = [0.1, 3.0]", "amplitude = [0.1, 3.0]\nto_force = 2")
    assert "does no work on mode" in launch.run(case, status=2).err


def test_python_reads_and_draws_the_mode(tmp_path, capsys):
    case, _ = scene(tmp_path, "dof5")
    done = launch.run(case)
    results = Results(done.folder / "results.h5")
    points = done.points
    for name in ("modal_amplitude", "damping_ratio", "friction_energy", "force_level", "energy_error"):
        np.testing.assert_array_equal(getattr(results, name), points[name])
    np.testing.assert_array_equal(results.along, points["modal_amplitude"])
    assert main(["info", str(done.folder / "results.h5")]) == 0 and "damping ratio" in capsys.readouterr().out
    assert main(["plot", str(done.folder / "results.h5"), "-o", str(tmp_path / "mode.png")]) == 0
    assert (tmp_path / "mode.png").stat().st_size > 1000


def test_a_frequency_that_no_mode_is_near_is_told(tmp_path):
    """As of one in Hz that was taken in rad/s. Of five modes, up to 10 rad/s."""
    for near, far in ((1e3, True), (1e-3, True), (2.0, False)):
        case, _ = scene(tmp_path, "dof5", number=None, near=near, at=None)
        case.path.write_text(case.path.read_text() + "\n[continuation]\nmax_points = 1\n")
        assert (f"no mode is nearer to mode.near = {near:g} rad/s" in launch.run(case).out) == far


@pytest.mark.parametrize("mode, more, words", [
    (dict(number=9), "", ["mode.number = 9", "has 5 modes", "1: "]),
    (dict(number=1, near=2.0), "", ["mode.near", "mode.number is given as well"]),
    (dict(number=None), "", ["which mode is not said"]),
    (dict(number=1, amplitude=None), "", ["mode.amplitude is missing"]),
    (dict(number=1, amplitude=[2.0, 1.0], at=None), "", ["mode.amplitude", "must rise"]),
    (dict(number=1, amplitude=[0.0, 1.0], at=None), "", ["mode.amplitude", "greater than 0"]),
    (dict(number=1, at=[1e6]), "", ["mode.at", "outside mode.amplitude"]),
    (dict(number=1, to_force=-1.0), "", ["mode.to_force", "greater than 0"]),
    (dict(number=1), "[continuation]\nomega = [1, 2]", ["continuation.omega", "[mode] is given as well"]),
    (dict(number=1), '[path]\nparameter = "force"\nrange = [1, 2]\nomega = 1', ["path.parameter", "[mode] is given as well"]),
    (dict(number=1), "[path]\nrange = [1, 2]", ["path.range", "[mode] is given as well"]),
    (dict(number=1), '[path]\nparameter = "force"', ["path.parameter", "[mode] is given as well"]),
    (dict(number=1), "[path]\nat = [1.5]", ["path.at", "[mode] is given as well"]),
    (dict(number=1), '[sensitivity]\nof = "x1.t1"', ["sensitivity.of", "[mode] is given"]),
    (dict(number=1), "[stability]\nenabled = true", ["stability.enabled", "[mode] is given"]),
    (dict(number=1), "[accuracy]\nestimates = true", ["accuracy.estimates", "[mode] is given"]),
])
def test_refusals(tmp_path, mode, more, words):
    case, _ = scene(tmp_path, "dof5", **mode)
    case.path.write_text(case.path.read_text() + "\n" + more + "\n")
    done = launch.run(case, status=2)
    for word in words:
        assert word in done.err, done.err


@pytest.mark.parametrize("solver, ranks", [("assembled", None), ("modal", 2)])
@pytest.mark.slow
def test_restart_after_any_point(tmp_path, solver, ranks):
    """Where the mode is a straight line, at the onset, and beyond it, also after amplitudes that were named: the same to the last bit."""
    case, data = scene(tmp_path, "dof5", solver, at=[0.11 * float(np.load(DATA / "dof5.npz")["onset_alpha"])])
    whole = launch.run(case, out="whole", ranks=ranks)
    count = len(whole.points["omega"])
    case.path.write_text(case.path.read_text() + "\n[continuation]\nmax_points = 1\n")
    before = 1
    for points in (*range(1, count, 3), 10**6):
        case.edit(f"max_points = {before}\n", f"max_points = {points}\n")
        done = launch.run(case, *(["--restart"] if points > 1 else []), out="out", ranks=ranks)
        assert min(points, count) <= len(done.points["omega"]) <= count
        before = points
    assert done.summary["parts"] > 3 and done.summary["end"] == "arrived"
    for name in whole.points.keys() - {"seconds"}:
        np.testing.assert_array_equal(done.points[name], whole.points[name], err_msg=name)
    assert done.summary["mode"] == whole.summary["mode"]
    assert done.summary["newton_iterations"] == whole.summary["newton_iterations"]


def test_restart(tmp_path):
    """A mode that is stopped on the way, and taken farther than it was asked for; another mode, and another model, are refused."""
    case, data = scene(tmp_path, "dof5", at=None)
    most = 1.0001 * float(data["alpha"].max())
    whole = launch.run(case, out="whole").points
    case.path.write_text(case.path.read_text() + "\n[continuation]\nmax_points = 6\n")
    assert len(launch.run(case, out="out").points["omega"]) == 6
    assert "nothing to do" in launch.run(case, "--restart", out="out").out
    case.edit("max_points = 6", "max_points = 1000")
    case.edit("number = 1", "number = 2")
    assert "mode.number = 2: this run began with 1" in launch.run(case, "--restart", out="out", status=2).err
    case.edit("number = 2", "number = 1")
    case.edit(json.dumps(most), json.dumps(1.5 * most))
    done = launch.run(case, "--restart", out="out")
    assert "restart: goes on at modal amplitude" in done.out and "after 6 points" in done.out
    assert done.points["modal_amplitude"][-1] == 1.5 * most
    np.testing.assert_array_equal(done.points["coefficients"][:6], whole["coefficients"][:6])
    with h5py.File(tmp_path / "reduced.h5", "r+") as file:
        file["Kaa"][0] *= 1.01
    case.edit(json.dumps(1.5 * most), json.dumps(2 * most))
    assert "the model, or its reduction, is not what it was" in launch.run(case, "--restart", out="out", status=2).err


def test_a_finished_run_is_replaced(tmp_path):
    case, _ = scene(tmp_path, "dof5")
    launch.run(case)
    assert "cut off" not in launch.run(case).out  # nothing of the finished run is put aside
    assert not (tmp_path / "results.old.h5").exists()
