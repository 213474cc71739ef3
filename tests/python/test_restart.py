"""--restart and the signals that make it needed; what stops a run on purpose."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

import cases
import chain
from launch import BINARY, SECONDS, SURROUNDINGS, children, gone, held, kill, line, read_points, run, wait_for, words_of
from on_terminal import Watched

cases.SECTION_OF |= {"watch": "continuation", "stop_after_peaks": "continuation", "stop_at_amplitude": "continuation",
                     "start": "continuation", "enabled": "stability"}
SMALL = {"harmonics": 3, "samples": 32}
MANY = {"omega": [0.8, 1.1], "samples": "exact", "between": 1e-7}  # more than 500 points
# For minutes: under mpirun a run cannot be halted at a point. So small steps leave nothing of an error between points but round-off.
SLOWLY = {"omega": [0.8, 1.1], "samples": 2**14, "adaptive": False, "step": 1e-3}


def same(found, wanted, rows=slice(None), but=()):
    assert found.keys() == wanted.keys()
    for name in wanted.keys() - {"seconds", "residual", *but}:
        scale = np.nanmax(np.abs(wanted[name]), initial=1e-300)
        # Estimates come from linear solves in single precision; GMRES solves for tangents to 1e-6.
        accuracy = 1e-3 if name.startswith("error_") else 1e-6 if name.startswith("tangent") else 1e-8
        np.testing.assert_allclose(found[name], wanted[name][rows], rtol=0, atol=accuracy * scale, err_msg=name)


def stopped(case, points, out="out", ranks=None, number=signal.SIGTERM, whom=None):
    """Runs a case until it has shown so many points, and ends it by a signal; returns what it said. With `ranks` it must have many more.

    `whom`: picks from the process and those of its ranks the ones that get the signal; default: the process."""
    command, folder = line(case, out=out, ranks=ranks)
    with Watched(command, halt=None if ranks else points) as watched:  # mpirun would stand still without its ranks
        watched.wait_for_point(points)
        for pid in whom(watched.process.pid, children(watched.process.pid)) if whom else [watched.process.pid]:
            os.kill(pid, number)
        if not ranks:
            watched.go_on()
        watched.process.wait(SECONDS)
        assert watched.process.returncode == 3, watched.said
    return watched.said, folder


# ------------------------------------------------------------------------------------------------------------- signals
@contextmanager
def at_start(number, action):
    """What a program that is started meanwhile does on a signal, until it says otherwise."""
    before = signal.signal(number, action)
    try:
        yield
    finally:
        signal.signal(number, before)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGUSR1, signal.SIGINT, signal.SIGHUP])
@pytest.mark.slow
def test_signal_finishes_the_point_and_restart_goes_on(tmp_path, number):
    case = cases.several_points(tmp_path, **MANY)
    whole = run(case, out="whole")
    with at_start(number, signal.SIG_DFL):
        said, folder = stopped(case, 10, number=number)
    name = signal.Signals(number).name
    assert f"noted {name}" in said and f"stopped by {name} at" in said and "--restart goes on" in said
    first = run(case, "--dry-run", "--restart", out="out").out
    before = read_points(folder)
    count = len(before["omega"])
    assert 10 <= count < len(whole.points["omega"]) and f"after {count} points" in first
    assert len({len(values) for values in before.values()}) == 1
    done = run(case, "--restart", out="out")
    assert f"after {count} points" in done.out
    same(done.points, whole.points)
    np.testing.assert_array_equal(done.points["coefficients"][:count], before["coefficients"])
    assert done.summary["parts"] == 2 and done.summary["end"] == "arrived"
    assert done.summary["newton_iterations"] == whole.summary["newton_iterations"]


@pytest.mark.parametrize("number", [signal.SIGHUP, pytest.param(signal.SIGINT, marks=pytest.mark.slow)])
def test_signal_that_was_ignored_stays_so(tmp_path, number):
    """As behind nohup, or in the background of a script."""
    case = cases.dof5(tmp_path, adaptive=False, step=0.001, max_points=1000, **SMALL)
    command, _ = line(case, out="out")
    with at_start(number, signal.SIG_IGN):
        watched = Watched(command, halt=10)
    with watched:
        watched.wait_for_point(10)
        watched.process.send_signal(number)
        watched.go_on()
        assert watched.process.wait(SECONDS) == 0 and "noted" not in watched.said


def of_rank(which):
    return lambda mpirun, ranks: [sorted(ranks)[which]]


@pytest.mark.parametrize("whom, number", [(None, signal.SIGUSR1), (of_rank(0), signal.SIGTERM), (of_rank(1), signal.SIGTERM)],
                         ids=["mpirun", "rank 0", "rank 1"])
@pytest.mark.slow
def test_signal_to_any_rank_stops_all(tmp_path, whom, number):
    """mpirun passes SIGUSR1 on; a batch system may reach one rank alone. Afterwards on another number of ranks."""
    said, folder = stopped(cases.several_points(tmp_path, **SLOWLY), 10, ranks=2, number=number, whom=whom)
    assert said.count("dovetail: stopped by") == 1
    case = cases.several_points(tmp_path, **SLOWLY, max_points=len(read_points(folder)["omega"]) + 10)
    done = run(case, "--restart", out="out", ranks=3 if whom is None else None)
    assert len(done.points["omega"]) == case.settings["max_points"] and done.summary["parts"] == 2
    same(done.points, run(case, out="whole", ranks=2).points, but=["error_between", "linear_iterations"])  # one more after round-off


@pytest.mark.slow
def test_second_signal_ends_the_run_at_once(tmp_path):
    """The first one is noted, but the point does not end before the second one comes: meanwhile the process stands still."""
    case = cases.dof5(tmp_path, harmonics=40, samples=2**19)  # a point takes seconds
    command, folder = line(case, out="out")
    with Watched(command) as watched:
        watched.wait_for_point(1)
        watched.process.send_signal(signal.SIGTERM)
        wait_for(lambda: "noted SIGTERM" in watched.said or watched.process.poll() is not None, "the first signal")
        with held(watched.process):
            time.sleep(2.5)  # a launcher may pass one signal on twice
            watched.process.send_signal(signal.SIGTERM)
        assert watched.process.wait(SECONDS) == 3 and "the second signal" in watched.said
    assert len(read_points(folder)["omega"]) >= 1


def catches(pid):
    """Whether a process has set its handler for SIGUSR1."""
    mask = re.search(r"^SigCgt:\s*(\w+)", open(f"/proc/{pid}/status").read(), re.MULTILINE)
    return int(mask[1], 16) >> (signal.SIGUSR1 - 1) & 1


@pytest.mark.slow
def test_signal_before_the_first_point(tmp_path):
    case = cases.full(tmp_path, "large", cases.random_structure(elastic=900, points=30), {}, modes=300, stiffness=0.02, fourier=[0, 1],
                      normal_stiffness=3.0, tangential_stiffness=1.0, friction=0.3, gap=0.0, initial=0.0, harmonics=3, omega=[0.8, 1.6])
    command, folder = line(case, out="out")
    process = subprocess.Popen(command, env=SURROUNDINGS, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        wait_for(lambda: catches(process.pid), "the handler")
        process.send_signal(signal.SIGTERM)
        out, err = process.communicate(timeout=SECONDS)
    finally:
        process.kill()
    assert process.returncode == 3 and err == "dovetail: ended by SIGTERM before the first point was computed\n"
    assert not (folder / "results.h5").exists()


# ------------------------------------------------------------------------------------------------------------- restart
@pytest.fixture(scope="module")
def halted(tmp_path_factory):
    """A run stopped at max_points; its folder is to be copied by a test that changes it."""
    case = cases.dof5(tmp_path_factory.mktemp("halted"), max_points=20, **SMALL)
    run(case, out="out")
    return case


@pytest.fixture
def copy(halted, tmp_path):
    return halted.copied(tmp_path / "copy")


@pytest.mark.slow
def test_restart_with_more_points_and_a_farther_end(copy, tmp_path):
    whole = run(cases.dof5(tmp_path, **SMALL), out="whole").points
    copy.edit("max_points = 20", "max_points = 30")
    assert len(run(copy, "--restart", out="out").points["omega"]) == 30
    copy.edit("max_points = 30", "max_points = 2000")
    done = run(copy, "--restart", out="out")
    same(done.points, whole)
    assert done.summary["parts"] == 3
    done = run(copy, "--restart", out="out")
    assert "nothing to do" in done.out and "arrived" in done.out
    copy.edit("omega = [0.9, 1.3]", "omega = [0.9, 1.35]")
    done = run(copy, "--restart", out="out")
    before = whole["omega"] < 1.29
    np.testing.assert_array_equal(done.points["coefficients"][:before.sum()], whole["coefficients"][before])
    assert done.points["omega"][-1] == 1.35 and 1.3 not in done.points["omega"]


@pytest.mark.parametrize("ranks", [None, 2])
@pytest.mark.slow
def test_restart_after_any_point(tmp_path, ranks):
    """Stopped after every point, also after those located within a step, and there amid several frequencies that were named."""
    keys = {"harmonics": 3, "samples": "exact", "adaptive": True, "step": 0.02, "omega": [0.95, 1.2], "at": [0.9501, 0.9502, 1.05, 1.0501]}
    whole = run(cases.dof5(tmp_path, **keys), out="whole", ranks=ranks)
    for points in (*range(2, len(whole.points["omega"]), 3 if ranks else 1), 10**6):
        options = ["--restart"] if points > 2 else []
        done = run(cases.dof5(tmp_path, **keys, max_points=points), *options, out="out", ranks=ranks)
        assert len(done.points["omega"]) == min(points, len(whole.points["omega"]))
    for name in whole.points.keys() - {"seconds"}:  # to the last bit
        np.testing.assert_array_equal(done.points[name], whole.points[name], err_msg=name)
    for name in ("newton_iterations", "peaks", "folds"):
        assert done.summary[name] == whole.summary[name]
    with h5py.File(done.folder / "results.h5") as parts, h5py.File(whole.folder / "results.h5") as one:
        for name in ("kind", "omega", "point"):
            np.testing.assert_array_equal(parts["events"][name], one["events"][name])


@pytest.mark.slow
def test_restart_on_a_path_over_the_joint(tmp_path):
    """Every point has a preload of its own, in which more and more contact points slip: the same to the last bit."""
    points, path = 120, chain.write(tmp_path, 120, harmonics=1)
    model = chain.model(points)
    model.preload[0:-3:3] = 0.5 / points * (1 + np.cos(np.arange(points)))
    model.write(tmp_path / "model.h5")
    kept = "\n".join(row for row in path.read_text().splitlines() if not row.startswith("continuation"))

    def done(most, *options, out):
        path.write_text(f'{kept}\npath = {{ parameter = "friction", range = [1.0, 0.4], omega = 1.4 }}\n'
                        f"continuation = {{ max_points = {most} }}\n")
        return run(SimpleNamespace(path=path), *options, out=out)
    whole = done(1000, out="whole").points
    done(8, out="out")
    done(15, "--restart", out="out")
    again = done(1000, "--restart", out="out").points
    for name in whole.keys() - {"seconds"}:
        np.testing.assert_array_equal(again[name], whole[name], err_msg=name)


@pytest.mark.slow
def test_restart_while_harmonics_follow_a_tolerance(tmp_path):
    """Stopped before, amid and after the points that want more of them."""
    keys = {"harmonics": None, "samples": None, "tolerance": 1e-4, "adaptive": True, "step": 0.02, "omega": [0.9, 1.2]}
    whole = run(cases.dof5(tmp_path, **keys), out="whole")
    used = whole.points["harmonics"]
    assert used.max() > used.min() and whole.summary["adaptations"] > 3
    most = int(np.argmax(used))
    for points in (most // 2, most + 1, len(used) - 5, 10**6):
        case = cases.dof5(tmp_path, **keys, max_points=points)
        done = run(case, *(["--restart"] if points > most // 2 else []), out="out")
    same(done.points, whole.points)
    for name in ("adaptations", "newton_iterations"):
        assert done.summary[name] == whole.summary[name]
    assert done.summary["accuracy"] == pytest.approx(whole.summary["accuracy"], rel=1e-2)


def test_nothing_to_do(halted):
    """Said, with status 0, and nothing is touched."""
    folder = halted.path.parent / "out"
    before = {path.name: path.stat().st_mtime_ns for path in folder.iterdir()}
    done = run(halted, "--restart", out="out")
    assert "nothing to do" in done.out and "max_points" in done.out
    assert {path.name: path.stat().st_mtime_ns for path in folder.iterdir()} == before


@pytest.mark.slow
def test_run_whose_summary_is_missing_has_not_ended(tmp_path):
    """All points are there, but the summary could not be written: --restart gives it."""
    case = cases.dof5(tmp_path, adaptive=False, step=0.03, **SMALL)  # so many points that it cannot end before it is halted
    whole = run(case, out="whole")
    command, folder = line(case, out="out")
    with Watched(command, halt=1) as watched:
        watched.wait_for_point(1)
        (folder / "summary.json").symlink_to("/dev/full")
        watched.go_on()
        assert watched.process.wait(SECONDS) == 3
        assert "is the disk full" in watched.said
    (folder / "summary.json").unlink()
    done = run(case, "--restart", out="out")
    same(done.points, whole.points)
    for name in ("end", "points", "peaks", "newton_iterations"):
        assert done.summary[name] == whole.summary[name], name


OTHER = {
    "harmonics = 3": ("harmonics = 4", ["harmonic_balance.harmonics = 4", "this run began with 3"]),
    "friction = [1.0, 1.0]": ("friction = [1.0, 1.1]", ["[contact]"]),
    "fourier = [0, 0, 1, 0, 0]": ("fourier = [0, 0, 1.5]", ["excitation.fourier = [0, 0, 1.5]", "[0, 0, 1]"]),
    "omega = [0.9, 1.3]": ("omega = [0.8, 1.3]", ["continuation.omega, from = 0.8", "0.9"]),
    "max_points = 20": ("max_points = 20\nwatch = \"a1\"", ["continuation.watch = a1", "what moves most"]),
    "[continuation]": ("[stability]\nenabled = false\n[continuation]", ["stability.enabled = false", "true"]),
}


@pytest.mark.parametrize("old", OTHER)
def test_another_problem_is_refused(copy, old):
    new, words = OTHER[old]
    copy.edit(old, new)
    before = (copy.path.parent / "out" / "results.h5").read_bytes()
    err = run(copy, "--restart", out="out", status=2).err
    assert all(word in err for word in ["case.toml:", "without --restart", *words]) and err.count("\n") == 1
    assert (copy.path.parent / "out" / "results.h5").read_bytes() == before


def test_end_that_lies_behind_is_refused(copy):
    copy.edit("omega = [0.9, 1.3]", "omega = [0.9, 0.901]")
    err = run(copy, "--restart", out="out", status=2).err
    assert "case.toml:" in err and "ends at 0.901" in err and "stands at" in err


@pytest.mark.parametrize("ranks", [None, 2])
@pytest.mark.slow
def test_another_model_is_refused(copy, ranks):
    """By the equations themselves: where the run stood must be a solution."""
    with h5py.File(copy.path.parent / "model.h5", "r+") as file:
        file["force"][0] = 1.01
    copy.edit("max_points = 20", "max_points = 30")
    err = run(copy, "--restart", out="out", ranks=ranks, status=2).err
    assert "the model, or its reduction, is not what it was" in err and err.count("dovetail:") == 1
    assert len(read_points(copy.path.parent / "out")["omega"]) == 20


def without_state(folder):
    (folder / "state.h5").unlink()


def damaged_state(folder):
    path = folder / "state.h5"
    path.write_bytes(path.read_bytes()[:700])


def fewer_points(folder):
    with h5py.File(folder / "results.h5", "r+") as file:
        file["points/omega"].resize((5,))


def without_results(folder):
    (folder / "results.h5").unlink()


@pytest.mark.parametrize("damage, words", [(without_state, ["state.h5: no such file", "no run to continue"]),
                                           (damaged_state, ["state.h5"]), (fewer_points, ["results.h5", "fewer points"]),
                                           (without_results, ["results.h5", "no such file"])])
def test_nothing_to_go_on_from(copy, damage, words):
    damage(copy.path.parent / "out")
    copy.edit("max_points = 20", "max_points = 30")
    err = run(copy, "--restart", out="out", status=2).err
    assert all(word in err for word in words) and err.count("dovetail:") == 1


def test_restart_is_for_run_only(halted):
    assert "--restart is not an option here" in words_of([BINARY, "reduce", halted.path, "--restart"], 2)[1]


@pytest.mark.slow
def test_forgotten_flag_costs_nothing(tmp_path):
    """Results of a run that was cut off step aside, and the longer ones stay."""
    case = cases.dof5(tmp_path, **cases.ENDLESS, **SMALL)
    command, folder = line(case, out="out")
    counts = []
    for points in (2000, 10):
        with Watched(command, halt=points) as watched:
            watched.wait_for_point(points)
            kill(watched.process)
        counts.append(len(read_points(folder)["omega"]))
    assert counts[0] > counts[1]
    case.edit("max_points = 1000000", "max_points = 20")
    out = run(case, out="out").out
    assert "results.old.h5" not in out  # those of the second attempt are the shorter ones
    with h5py.File(folder / "results.old.h5") as file:
        assert len(file["points/omega"]) == counts[0]
    assert "was cut off" not in run(case, out="out").out  # a run that came to its end is replaced, as ever
    for name in ("results", "state"):
        (folder / f"{name}.old.h5").rename(folder / f"{name}.h5")
    case.edit("max_points = 20", f"max_points = {counts[0] + 5}")
    assert len(run(case, "--restart", out="out").points["omega"]) == counts[0] + 5


# --------------------------------------------------------------------------------------------------------------- stops
@pytest.mark.slow
def test_stop_after_peaks(tmp_path):
    whole = run(cases.several_points(tmp_path), out="whole")
    case = cases.several_points(tmp_path, stop_after_peaks=2)
    done = run(case, out="out")
    assert done.summary["end"] == "peaks" and done.summary["peaks"] == 2 and "stopped after peak 2" in done.out
    assert done.summary["located"]["peaks"] == whole.summary["located"]["peaks"][:2]
    assert done.points["omega"][-1] == done.summary["located"]["peaks"][1]["omega"]
    assert "nothing to do" in run(case, "--restart", out="out").out
    case.edit("stop_after_peaks = 2", "stop_after_peaks = 3")
    again = run(case, "--restart", out="out")
    assert again.summary["located"]["peaks"] == whole.summary["located"]["peaks"][:3]
    case.edit("stop_after_peaks = 3", "stop_after_peaks = 1")
    fewer = run(case, "--restart", out="out")
    assert fewer.summary["end"] == "peaks" and "stopped: peaks so far, 2, are those of continuation.stop_after_peaks" in fewer.out


def test_stop_at_amplitude_of_the_watched_unknown(tmp_path):
    """In user units, whatever the scales."""
    from dovetail import Results

    for kind in ("none", "auto"):
        case = cases.dof5(tmp_path, kind=kind, watch="x1.t2", stop_at_amplitude=2.0, **SMALL)
        done = run(case, out=kind)
        assert done.summary["end"] == "amplitude" and "stop_at_amplitude" in done.out
        amplitude = Results(done.folder / "results.h5").amplitude("x1.t2")
        assert amplitude[-1] == pytest.approx(2.0, rel=1e-6) and amplitude[:-1].max() < 2.0


@pytest.mark.parametrize("part", [0.9, 0.998, 1 - 1e-6])
def test_an_amplitude_that_is_passed_within_a_step_ends_the_run(tmp_path, part):
    """At both ends of the step round a peak it was below."""
    from dovetail import Results

    scene = {"kind": "auto", "watch": "x1.t1", "harmonics": 3, "samples": "exact"}
    most = run(cases.dof5(tmp_path, **scene), out="whole").summary["located"]["peaks"][0]["amplitude"]
    done = run(cases.dof5(tmp_path, stop_at_amplitude=part * most, **scene), out="out")
    assert done.summary["end"] == "amplitude"
    assert Results(done.folder / "results.h5").amplitude("x1.t1")[-1] == pytest.approx(part * most, rel=1e-6)


def test_amplitude_that_is_beyond_its_limit_at_once(tmp_path):
    """The sweep went all through."""
    done = run(cases.dof5(tmp_path, watch="x1.t2", stop_at_amplitude=1e-3, **SMALL), out="out")
    assert done.summary["end"] == "amplitude" and done.summary["points"] == 1
    assert "beyond continuation.stop_at_amplitude, at 0.9 rad/s" in done.out


def test_restart_of_a_run_over_something_else(halted, tmp_path):
    """It named a key that neither case has."""
    case = cases.dof5(tmp_path, **SMALL)
    text = re.sub(r"(?m)^omega = .*$", "", case.path.read_text())
    case.path.write_text(text + '\n[path]\nparameter = "friction"\nrange = [1.0, 2.0]\nomega = 1.0\n')
    shutil.copytree(halted.path.parent / "out", tmp_path / "out")
    assert "follows a curve over path.range, and this run began over something else" in run(case, "--restart", out="out", status=2).err


@pytest.mark.parametrize("before, limit, end", [(2.0, 1.0, "amplitude"), (1e3, 2.0, "amplitude"), (1e3, 1e2, "arrived")],
                         ids=["stands beyond it", "stands below it again", "was never there"])
def test_restart_below_an_amplitude_that_was_passed(tmp_path, before, limit, end):
    """It went on, to where a run in one go would never have come."""
    case = cases.dof5(tmp_path, watch="x1.t2", stop_at_amplitude=before, omega=[0.8, 1.3], **SMALL)
    run(case, out="out")
    case.edit(f"stop_at_amplitude = {before}", f"stop_at_amplitude = {limit}")
    done = run(case, "--restart", out="out")
    assert done.summary["end"] == end
    assert ("stopped: the amplitude has been beyond continuation.stop_at_amplitude, at " in done.out) == (end == "amplitude")
    assert "nothing to do" in run(case, "--restart", out="out").out
    case.edit(f"stop_at_amplitude = {limit}", "stop_at_amplitude = 1e4")
    assert run(case, "--restart", out="out").summary["end"] == "arrived"


@pytest.mark.parametrize("name, words", [("x2.n", ["the model has 1 contact points"]), ("a3", ["the model has 2 modes"]),
                                         ("x1.t3", ["the name of an unknown"])])
def test_watched_unknown_must_exist(tmp_path, name, words):
    err = run(cases.dof5(tmp_path, watch=name), status=2).err
    assert "case.toml:" in err and f'continuation.watch = "{name}"' in err and all(word in err for word in words)


# ------------------------------------------------------------------------------------------------- a rank or memory lost
@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.slow
def test_lost_rank_ends_the_run(tmp_path, which):
    """Its process is gone without a word: the others end soon, what was computed is there, and --restart goes on from it."""
    command, folder = line(cases.several_points(tmp_path, **SLOWLY), out="out", ranks=2)
    with Watched(command) as watched:
        watched.wait_for_point(10)
        ranks = sorted(children(watched.process.pid))
        os.kill(ranks[which], signal.SIGKILL)
        watched.process.wait(SECONDS / 2)
        wait_for(lambda: all(map(gone, ranks)), "the end of all ranks")
        assert watched.process.returncode not in (None, 0)
    before = read_points(folder)
    assert len(before["omega"]) >= max(10, watched.last_point())
    case = cases.several_points(tmp_path, **SLOWLY, max_points=len(before["omega"]) + 10)
    done = run(case, "--restart", out="out", ranks=2)
    same(done.points, run(case, out="whole", ranks=2).points)
    assert done.summary["parts"] == 2


@pytest.mark.slow
def test_out_of_memory(tmp_path):
    """Where the libraries start at all, the program says what it lacks, until it lacks nothing."""
    case = cases.several_points(tmp_path, harmonics=60, samples=256, omega=[0.8, 0.85])
    command, _ = line(case)
    statuses = []
    for mebibytes in range(150, 2000, 50):
        limit = (f"import os, resource, sys; resource.setrlimit(resource.RLIMIT_AS, 2 * ({mebibytes << 20},)); "
                 "os.execv(sys.argv[1], sys.argv[1:])")
        done = subprocess.run([sys.executable, "-c", limit, *command], env=SURROUNDINGS, capture_output=True, text=True, timeout=SECONDS)
        if done.returncode == 3:
            assert done.stderr.count("dovetail:") == 1 and "out of memory" in done.stderr and "fewer harmonics" in done.stderr
        statuses.append(done.returncode)
        if done.returncode == 0:
            break
    assert 3 in statuses and statuses[-1] == 0
