"""Peaks over a parameter: against searches for each of them, against dense sweeps, in a corner, on several ranks.

dof5.npz and chain.npz hold peaks found by a dense prototype with a contact law of its own, and by a bounded search without
derivatives; corner_peak.npz peaks of the five dofs that lie in a corner of the response, where a slider begins to slip.
"""

import re
import shutil
import subprocess
import sys
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

import cases
import launch
from dovetail import Results, info, plot
from test_sensitivity import DATA, SCENES, given

POSTS = """model = "model.h5"
reduction = {{ modes = 5 }}
damping = {{ stiffness = 1e-6 }}
excitation = {{ fourier = [0, 0, 5] }}
harmonic_balance = {{ harmonics = 5 }}
continuation = {{ omega = [4000, 4250], watch = "a1" }}
path = {{ parameter = "friction", range = [1.0, 0.3], at = {at}, peak = "amplitude" }}
stability = {{ enabled = false }}
accuracy = {{ estimates = false, between = {between} }}
"""
SEARCHED = slice(5, 7)  # columns of tracks: frequency and rms amplitude by the search; 1 and 2 by derivatives, 3 and 4 in phase


def track(folder, scene, parameter, start, end, at=(), peak="amplitude", omega=None, ranks=None, edits=(), status=0, more=""):
    """Runs a scene of the data along a path over peaks. Returns the run and its Results."""
    case, data = given(folder, scene)
    watched = SCENES[scene][0]
    text = case.path.read_text()
    head, _, _ = text.partition("[sensitivity]")
    lines = [line for line in head.splitlines() if not line.startswith("omega")]
    place = lines.index("[continuation]") + 1
    lines[place:place] = [f"omega = {list(omega or (0.97 * data['sens_peak'][0], 1.03 * data['sens_peak'][0]))}", f'watch = "{watched}"']
    text = "\n".join(lines) + f'\n[path]\nparameter = "{parameter}"\nrange = [{start}, {end}]\npeak = "{peak}"\n'
    if len(at):
        text += f"at = {list(at)}\n"
    for old, new in edits:
        assert old in text
        text = text.replace(old, new)
    case.path.write_text(text + more)
    done = launch.run(case, ranks=ranks, status=status)
    return done, None if status else Results(done.folder / "results.h5")


def at_values(results, values):
    """(omega, tracked amplitude) of the points exactly there, (len(values), 2)."""
    rows = [int(np.flatnonzero(results.parameter == value)[0]) for value in values]
    return np.column_stack([results.omega[rows], results.tracked_amplitude[rows]])


def both_ways(tmp_path, scene, parameter, values, nominal, peak="amplitude", **options):
    """Peaks at values to both sides of the nominal one, where the track begins, in the order of the values."""
    found = {}
    down, up = sorted((v for v in values if v < nominal), reverse=True), sorted(v for v in values if v > nominal)
    for name, side in (("down", down), ("up", up)):
        if not side:
            continue
        (folder := tmp_path / name).mkdir()
        _, results = track(folder, scene, parameter, nominal, side[-1], side[:-1], peak, **options)
        found.update(zip((nominal, *side), at_values(results, (nominal, *side))))
    return np.array([found[value] for value in values])


@pytest.mark.parametrize("scene, parameter, name, nominal", [
    ("dof5", "friction", "track_mu", 1), ("dof5", "preload", "track_static", 1),
    *(pytest.param(*other, marks=pytest.mark.slow) for other in
      [("dof5", "gap", "track_gap", 0), ("chain", "friction", "track_mu", 1), ("chain", "preload", "track_static", 1),
       ("chain", "normal_stiffness", "track_kn", 1)])])
def test_given_tracks(tmp_path, scene, parameter, name, nominal):
    data = np.load(DATA / f"{scene}.npz")[name]
    found = both_ways(tmp_path, scene, parameter, data[:, 0].tolist(), nominal)
    assert np.abs(found[:, 1] / data[:, SEARCHED][:, 1] - 1).max() < 1e-8
    assert np.abs(found[:, 0] / data[:, SEARCHED][:, 0] - 1).max() < 2e-8  # what a search for a maximum can tell
    assert np.abs(found / data[:, 1:3] - 1).max() < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("scene, harmonics", [("dof5", 9), ("chain", 5)])
def test_given_force_levels(tmp_path, scene, harmonics):
    data = np.load(DATA / f"{scene}.npz")
    edits = [("harmonics = 5", f"harmonics = {harmonics}")]
    found = both_ways(tmp_path, scene, "force", data["forces"].tolist(), 1, edits=edits)
    assert np.abs(found / data["peak"] - 1).max() < 1e-8
    (tmp_path / "phase").mkdir()
    found = both_ways(tmp_path / "phase", scene, "force", data["forces"].tolist(), 1, peak="phase", edits=edits)
    assert np.abs(found / data["phase_resonance"] - 1).max() < 1e-8


def dense_peak(folder, scene, edits, watched, around):
    """The maximum of the rms amplitude over the frequency, from a polynomial through points of an ordinary sweep close to it."""
    case, _ = given(folder, scene)
    text = case.path.read_text().partition("[sensitivity]")[0]
    lines = [line for line in text.splitlines() if not line.startswith("omega")]
    frequencies = around * np.linspace(1 - 2e-4, 1 + 2e-4, 9)
    place = lines.index("[continuation]") + 1
    lines[place:place] = [f"omega = [{frequencies[0]}, {frequencies[-1]}]", f"at = {frequencies[1:-1].tolist()}", f'watch = "{watched}"']
    text = "\n".join(lines)
    for old, new in edits(case.settings):
        assert old in text
        text = text.replace(old, new)
    case.path.write_text(text)
    results = Results(launch.run(case).folder / "results.h5")
    rows = [int(np.argmin(np.abs(results.omega - omega))) for omega in frequencies]
    x = (results.omega[rows] / around - 1) / 2e-4
    c = results.coefficients[rows, results.dof_index(watched), 1:]
    fit = np.polynomial.Polynomial.fit(x, np.sum(c**2, axis=1), 6, domain=[-1, 1])
    assert np.abs(fit(x) / np.sum(c**2, axis=1) - 1).max() < 1e-11  # no corner in between
    tops = [root.real for root in fit.deriv().roots() if abs(root.imag) < 1e-9 and abs(root) < 1]
    assert len(tops) == 1
    return around * (1 + 2e-4 * tops[0]), np.sqrt(fit(tops[0]))


@pytest.mark.parametrize("scene, value", [("dof5", 0.7), *(pytest.param(*other, marks=pytest.mark.slow) for other in
                                                           [("dof5", 1.6), ("chain", 0.7), ("chain", 1.6)])])
def test_tangential_stiffness_against_dense_sweeps(tmp_path, scene, value):
    found = both_ways(tmp_path, scene, "tangential_stiffness_1", [value], 1)[0]

    def edits(settings):
        old = settings["tangential_stiffness"]
        return [(f"tangential_stiffness = {old}", f"tangential_stiffness = {[[value * a, b] for a, b in old]}")]
    (folder := tmp_path / "dense").mkdir()
    omega, amplitude = dense_peak(folder, scene, edits, SCENES[scene][0], found[0])
    assert abs(found[1] / amplitude - 1) < 1e-8 and abs(found[0] / omega - 1) < 1e-6


def test_a_peak_in_a_corner(tmp_path):
    """There no slope is zero: it jumps from rising to falling, where a slider just begins to slip."""
    data = np.load(DATA / "corner_peak.npz")
    done, results = track(tmp_path, "dof5", "gap", 0, -0.75, data["gap_offset"])
    found = at_values(results, data["gap_offset"])
    assert np.abs(found[:, 1] / data["amplitude_search"] - 1).max() < 1e-8
    assert np.abs(found[:, 0] / data["omega_search"] - 1).max() < 2e-8
    assert np.abs(found / np.column_stack([data["omega"], data["rms_amplitude"]]) - 1).max() < 1e-8
    assert "the peak lies in a corner of the response, where x1.t" in done.out and "the peak has left the corner" in done.out
    assert done.summary["corners"] >= 2


@pytest.mark.parametrize("scene, parameter, end, omega", [
    ("dof5", "friction", 4, (0.8, 1.4)), ("dof5", "tangential_stiffness_1", 0.3, (0.8, 1.4)), ("chain", "force", 0.06, (1.3, 1.8))])
@pytest.mark.slow
def test_a_track_ends_on_the_highest_peak_of_a_sweep(tmp_path, scene, parameter, end, omega):
    """Through several corners of the response, far from where it began; the narrowest is 3e-5 of the range wide."""
    _, results = track(tmp_path, scene, parameter, 1, end, more="[accuracy]\nbetween = 1e-5\n")
    (folder := tmp_path / "anew").mkdir()
    _, anew = track(folder, scene, parameter, end, 1.001 * end, omega=omega)  # begins with what an ordinary sweep finds there
    assert abs(results.tracked_amplitude[-1] / anew.tracked_amplitude[0] - 1) < 1e-10
    assert abs(results.omega[-1] / anew.omega[0] - 1) < 1e-9 and len(results.events.of("corner")) >= 2


@pytest.mark.slow
@pytest.mark.parametrize("scene, parameter, end, at", [("chain", "friction", 0.5, 0.7), ("dof5", "gap", -0.71, -0.7)])
def test_ranks_do_not_change_the_track(tmp_path, scene, parameter, end, at):
    """The five dofs have one contact point: a second rank owns none."""
    found = []
    for ranks in (None, 2):
        (folder := tmp_path / str(ranks)).mkdir()
        _, results = track(folder, scene, parameter, 0 if parameter == "gap" else 1, end, [at], ranks=ranks)
        found.append(at_values(results, [at, end]))
    assert np.abs(found[1] / found[0] - 1).max() < 1e-8


def test_a_peak_vanishes_where_it_meets_a_minimum(tmp_path):
    """Ordinary sweeps show it just before, and no more just behind."""
    watched = [('watch = "a1"', 'watch = "x1.t1"')]
    done, results = track(tmp_path, "dof5", "tangential_stiffness_2", 1, 20, omega=(3.3, 5), edits=watched)
    assert done.summary["end"] == "vanished" and "the peak meets a minimum of the amplitude" in done.out
    assert results.events.of("fold").place.tolist() == [results.parameter[-1]] and results.parameter[-1] == results.parameter.max()
    last, omega = results.parameter[-1], (3.9, 4.4)
    for name in ("before", "behind"):
        (tmp_path / name).mkdir()
    track(tmp_path / "before", "dof5", "tangential_stiffness_2", 0.99 * last, 0.98 * last, omega=omega, edits=watched)
    done, _ = track(tmp_path / "behind", "dof5", "tangential_stiffness_2", 1.01 * last, 1.02 * last, omega=omega, edits=watched, status=3)
    assert "no peak lies within continuation.omega" in done.err


def test_the_frequency_between_points_is_on_the_cubic(tmp_path):
    (tmp_path / "dense").mkdir()
    values = np.linspace(1, 0.5, 21)
    _, results = track(tmp_path, "dof5", "friction", 1, 0.5, values[2:-1:2].tolist())
    wanted = at_values(track(tmp_path / "dense", "dof5", "friction", 1, 0.5, values[1::2].tolist())[1], values[1::2])[:, 0]
    drawn, straight = (np.abs(np.interp(values[1::2], along[::-1], omega[::-1]) - wanted).max() for along, omega in
                       (results.response("a1").omega_curve(64), (results.parameter, results.omega)))
    assert drawn < 0.05 * straight


def test_pictures_and_info_tell_of_the_peak(tmp_path):
    done, results = track(tmp_path, "dof5", "friction", 1, 0.9)
    assert np.all(np.diff(results.parameter) < 0) and results.tracked_amplitude.shape == results.omega.shape
    row = results.coefficients[:, 0, 1:]
    assert np.abs(np.linalg.norm(row, axis=1) / results.tracked_amplitude - 1).max() < 1e-14
    *_, frequency, states = plot.response(results, ["a1"]).axes
    assert frequency.get_ylabel().startswith("frequency") and states.get_xlabel().startswith("friction")
    np.testing.assert_array_equal(frequency.lines[0].get_xydata(), np.transpose(results.response("a1").omega_curve()))
    text = info.describe(done.folder / "results.h5")
    assert "last peak of a1" in text and f"at friction {results.parameter[-1]:.7g}, {results.omega[-1]:.7g} rad/s" in text


@pytest.mark.parametrize("old, new, words", [
    ('peak = "amplitude"', 'peak = "highest"', ["path.peak", '"amplitude" or "phase"']),
    ('peak = "amplitude"', 'peak = "amplitude"\nomega = 1.0', ["path.omega", "continuation.omega", "Delete one of the two"]),
    ('watch = "a1"\n', "", ["continuation.watch is missing"]),
    ("[path]", "[path]\nat = [3]", ["path.at = 3", "outside path.range"]),
    ("harmonics = 5", 'harmonics = 5\nsolver = "modal"', []),
    ('samples = "exact"', "samples = 64", ["harmonic_balance.samples", "exact"]),
    ("[contact]", '[contact]\nlaw = "cone"', ["path.peak", "cone"]),
    ("[path]", "[stability]\nenabled = true\n[path]", ["stability.enabled"]),
    ("[path]", "[accuracy]\nestimates = true\n[path]", ["accuracy.estimates"]),
    ("step = 0.02", "step = 0.02\nadaptive = false", ["continuation.adaptive"]),
    ("step = 0.02", "step = 0.02\nat = [1.0]", ["continuation.at", "path.at"]),
])
def test_wrong_input(tmp_path, old, new, words):
    done, _ = track(tmp_path, "dof5", "friction", 1, 0.99, edits=[(old, new)], status=2 if words else 0)
    for word in words:
        assert word in done.err


def test_what_cannot_be_followed(tmp_path):
    done, _ = track(tmp_path, "dof5", "friction", 1, 0.9, omega=[1.2, 1.3], status=3)
    assert "no peak lies within continuation.omega at the first friction" in done.err and "Widen continuation.omega" in done.err


def whole_and_case(folder, *arguments, **options):
    """Points and summary of a track, and its case, whose first line of [continuation] becomes a limit to its points."""
    done, _ = track(folder, *arguments, **options)
    case = cases.Case(folder / "case.toml", None, None, {})
    case.edit("[continuation]", "[continuation]\nmax_points = 1000")
    return done, case


def limited(case, points):
    case.path.write_text(re.sub("max_points = .*", f"max_points = {points}", case.path.read_text()))
    return case


def same_bits(done, whole):
    for name in whole.points.keys() - {"seconds"}:
        np.testing.assert_array_equal(done.points[name], whole.points[name], err_msg=name)
    with h5py.File(done.folder / "results.h5") as found, h5py.File(whole.folder / "results.h5") as wanted:
        for name, values in wanted["events"].items():
            np.testing.assert_array_equal(found["events"][name][()], values[()], err_msg=name)
    for name in ("end", "points", "newton_iterations", "linear_iterations", "corners"):
        assert done.summary[name] == whole.summary[name], name


@pytest.mark.parametrize("scene, parameter, end, at, solver, ranks", [
    ("dof5", "gap", -0.75, [-0.71, -0.72, -0.722], "assembled", None),  # into a corner and out of it
    ("dof5", "gap", -0.75, [-0.71], "modal", 2), ("chain", "friction", 0.5, [0.7], "assembled", 2),
    ("chain", "friction", 0.5, [0.7], "modal", None)])
@pytest.mark.slow
def test_restart_after_any_point(tmp_path, scene, parameter, end, at, solver, ranks):
    """Also of those within a step, and in a corner: the same to the last bit; MUMPS on several ranks may round otherwise."""
    edits = [("harmonics = 5", f'harmonics = 5\nsolver = "{solver}"')]
    whole, case = whole_and_case(tmp_path, scene, parameter, 0 if parameter == "gap" else 1, end, at, ranks=ranks, edits=edits)
    count = len(whole.points["omega"])
    for points in (*range(1, count, 1 if ranks is None else max(1, count // 6)), 1000):
        done = launch.run(limited(case, points), *(["--restart"] if points > 1 else []), out="cut", ranks=ranks)
        assert min(points, count) <= len(done.points["omega"]) <= count
    assert done.summary["parts"] > 5
    if ranks and solver == "assembled":
        for name in ("parameter", "omega", "tracked_amplitude", "coefficients"):
            assert np.abs(done.points[name] - whole.points[name]).max() <= 1e-8 * np.abs(whole.points[name]).max()
    else:
        same_bits(done, whole)


def test_restart(tmp_path):
    """Within a corner, and once more; with no more to do; farther than it was asked for; on other ranks. Another problem is refused."""
    whole, case = whole_and_case(tmp_path, "dof5", "gap", 0, -0.75)
    corners = Results(tmp_path / "results.h5").events.of("corner").point
    entered, left = corners[0] + 1, corners[-1] + 1
    launch.run(limited(case, entered), out="out")
    assert "nothing to do" in launch.run(case, "--restart", out="out").out
    launch.run(limited(case, (entered + left) // 2), "--restart", out="out")
    for old, new, words in (('peak = "amplitude"', 'peak = "phase"', "path.peak = phase: this run began with amplitude"),
                            ("[continuation]", "[continuation]\nstop_after_peaks = 1", "continuation.stop_after_peaks = 1")):
        case.edit(old, new)
        assert words in launch.run(case, "--restart", out="out", status=2).err
        case.edit(new, old)
    limited(case, 1000)
    there = cases.Case(tmp_path / "case.toml", None, None, {})
    for folder in ("far", "two"):
        shutil.copytree(tmp_path / "out", tmp_path / folder)
    done = launch.run(case, "--restart", out="out")
    assert "restart: goes on at gap" in done.out and done.summary["parts"] == 3
    same_bits(done, whole)
    two = launch.run(case, "--restart", out="two", ranks=2)
    for name in ("parameter", "omega", "tracked_amplitude"):
        assert np.abs(two.points[name] - whole.points[name]).max() <= 1e-8 * np.abs(whole.points[name]).max()
    there.edit("-0.75", "-0.76")
    assert launch.run(there, "--restart", out="far").points["parameter"][-1] == -0.76
    with h5py.File(tmp_path / "reduced.h5", "r+") as file:
        file["Kaa"][0] *= 1.01
    there.edit("-0.76", "-0.77")
    assert "the model, or its reduction, is not what it was" in launch.run(there, "--restart", out="far", status=2).err


@pytest.mark.slow
def test_restart_of_a_killed_run(tmp_path):
    """What a kill leaves: results that are farther than the state, which stands in a corner."""
    whole, case = whole_and_case(tmp_path, "dof5", "gap", 0, -0.75, [-0.71])
    corners = Results(tmp_path / "results.h5").events.of("corner").point
    folder = launch.run(limited(case, int(np.mean(corners))), out="out").folder
    shutil.copy(folder / "state.h5", tmp_path / "state.h5")
    launch.run(limited(case, len(whole.points["omega"]) - 2), "--restart", out="out")
    shutil.copy(tmp_path / "state.h5", folder / "state.h5")
    same_bits(launch.run(limited(case, 1000), "--restart", out="out"), whole)
    assert "cut off" not in launch.run(case, out="out").out  # it had ended


def test_a_state_of_another_kind_or_version_is_refused(tmp_path):
    _, case = whole_and_case(tmp_path, "dof5", "friction", 1, 0.99)
    launch.run(limited(case, 2), out="out")
    track_text = case.path.read_text()
    case.path.write_text(track_text.partition("[path]")[0])
    assert "this run began" in (err := launch.run(case, "--restart", out="out", status=2).err) and "without --restart" in err
    launch.run(case, out="sweep")
    case.path.write_text(track_text)
    assert "this run began" in (err := launch.run(case, "--restart", out="sweep", status=2).err) and "without --restart" in err
    with h5py.File(tmp_path / "out" / "state.h5", "r+") as file:
        file.attrs["version"] -= 1
    assert "not the state of a run of this version" in launch.run(limited(case, 3), "--restart", out="out", status=2).err


@pytest.mark.slow
def test_restart_where_points_begin_to_slip_in_the_peak(tmp_path):
    """Two posts, whose top moves aside there: within one step."""
    subprocess.run([sys.executable, launch.ROOT / "inputs/two_solids/model.py", "-o", tmp_path / "model.h5"], check=True,
                   capture_output=True, env=launch.SURROUNDINGS)
    case = cases.Case(tmp_path / "case.toml", None, None, {})
    case.path.write_text(POSTS.format(at=[0.7], between=1e-3).replace("continuation = {", "continuation = { max_points = 1000,"))
    whole = launch.run(case, out="whole")
    count = len(whole.points["omega"])
    for points in (3, *range(4, count, 4), 1000):
        case.path.write_text(re.sub("max_points = [0-9]+", f"max_points = {points}", case.path.read_text()))
        done = launch.run(case, *(["--restart"] if points > 3 else []), out="out")
    same_bits(done, whole)


@pytest.mark.parametrize("parameter, key, words", [
    ("damping", "stiffness", ['path.parameter = "damping"', "the case has no damping"]),
    ("friction", "friction", ['path.parameter = "friction"', "friction of 0"]),
])
def test_a_factor_on_nothing(tmp_path, parameter, key, words):
    case, _ = given(tmp_path, "dof5")
    text, count = re.subn(rf"(?m)^{key} = .*$", f"{key} = 0.0", case.path.read_text().partition("[sensitivity]")[0])
    assert count == 1
    case.path.write_text(text + f'\n[path]\nparameter = "{parameter}"\nrange = [1, 2]\nomega = 1.0\n')
    case.path.write_text(re.sub(r"(?m)^omega = \[.*\n", "", case.path.read_text()))
    done = launch.run(case, status=2)
    for word in words:
        assert word in done.err


@pytest.mark.slow
def test_corners_within_the_curves_accuracy_cost_no_steps(tmp_path):
    """Nine points of two posts: where one begins to slip in the peak, the top moves aside. At given values of the friction the track that
    goes by meets the peaks of the one that resolves every such corner."""
    at, found, cuts = [0.9, 0.7, 0.5, 0.4], [], []
    subprocess.run([sys.executable, launch.ROOT / "inputs/two_solids/model.py", "-o", tmp_path / "model.h5"], check=True,
                   capture_output=True, env=launch.SURROUNDINGS)
    for between in (1e-3, 1e-7):
        path = tmp_path / f"{between}.toml"
        path.write_text(POSTS.format(at=at, between=between))
        results = Results(launch.run(SimpleNamespace(path=path), out=f"{between}").folder / "results.h5")
        found.append(at_values(results, [*at, 0.3]))
        cuts.append(len(results.events.of("cut")))
    assert np.abs(found[0] / found[1] - 1).max() < 1e-8
    assert cuts[0] < 10 < cuts[1]


def test_a_track_is_drawn_by_its_tangents(tmp_path):
    """Between points far apart it is nearer to where a track with points there has them than straight lines are."""
    places = np.linspace(0.98, 0.32, 23)
    subprocess.run([sys.executable, launch.ROOT / "inputs/two_solids/model.py", "-o", tmp_path / "model.h5"], check=True,
                   capture_output=True, env=launch.SURROUNDINGS)
    found = []
    for name, at in (("few", []), ("many", list(places))):
        path = tmp_path / f"{name}.toml"
        path.write_text(POSTS.format(at=at, between=1e-3))
        found.append(Results(launch.run(SimpleNamespace(path=path), out=name).folder / "results.h5"))
    few, many = found
    there = np.array([many.amplitude("a1")[np.flatnonzero(many.parameter == place)[0]] for place in places])
    along, drawn = few.curve("a1")
    off, off_by_lines = (np.abs(np.interp(places, at[::-1], amplitude[::-1]) - there).max() / there.max()
                         for at, amplitude in ((along, drawn), (few.parameter, few.amplitude("a1"))))
    assert 2 * off < off_by_lines
