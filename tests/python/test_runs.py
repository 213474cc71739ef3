"""What a user counts on in any run: nothing computed is lost, every end is told, the case is obeyed, every limit is met.

Numbers are judged in tests/verification; wrong case and model files in test_wrong_input.py.
"""

import json
import os
import pty
import re
import shutil
import signal
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest

from launch import BINARY, SECONDS, SURROUNDINGS, finite, going, held, line, read_points, run, tables, wait_for, words_of
from on_terminal import Watched
from dovetail import Model, reference

import cases

cases.SECTION_OF |= {"start": "continuation"}
RANKS = [None, 2]  # without mpirun, and with two ranks
REUSED = "still fits the model"
SMALL = {"harmonics": 3, "samples": 32}
POINT = {**SMALL, "omega": [0.9, 0.9]}  # one point, where only the way there is of interest
PROGRESS = re.compile(r"^ *\d+ +[\d.]+ +\S+e[+-]\d\d ", re.MULTILINE)  # a line of the table that shows a run


def without_end(folder):
    return cases.dof5(folder, **cases.ENDLESS)


def close(actual, expected, relative=1e-9):
    np.testing.assert_allclose(actual, expected, rtol=0, atol=relative * np.abs(expected).max(initial=1e-300))


@pytest.fixture(scope="module")
def arrived(tmp_path_factory):
    """An ordinary run that ends well, once on one rank; not to be changed by a test."""
    case = cases.dof5(tmp_path_factory.mktemp("arrived"))
    return case, run(case, out="out")


# ------------------------------------------------------------------------------------------------- killed, or watched
def points_now(folder):
    """How many points a run has written so far; zero, too, when this look met it while writing."""
    try:
        return len(read_points(folder)["omega"])
    except (OSError, KeyError):
        return 0


def complete(tables):
    """How many points have all their numbers: as many as there are frequencies, which are written last, some points together."""
    assert min(map(len, tables.values())) == len(tables["omega"])
    return len(tables["omega"])


@pytest.mark.parametrize("ranks, kills", [(None, 3), (2, 1)])
@pytest.mark.slow
def test_killed_run_leaves_its_points(tmp_path, ranks, kills):
    case = without_end(tmp_path)
    left = []
    for i in range(kills):
        with going(case, ranks=ranks, out=f"killed{i}") as (_, folder):
            wait_for(lambda: points_now(folder) > 20, "points")
            time.sleep(0.01 * i)
        points = read_points(folder)
        assert len(points) == 25
        left.append((complete(points), points))
    case.edit("max_points = 1000000", f"max_points = {max(length for length, _ in left)}")
    whole = run(case, out="whole").points
    for length, points in left:
        for name in set(points) - {"seconds", "residual", "contact/dissipation", "error_between"}:  # round-off: all points stick
            close(points[name][:length], whole[name][:length])


@pytest.mark.slow
def test_results_are_whole_at_any_moment(tmp_path):
    with going(without_end(tmp_path)) as (process, folder):
        wait_for(lambda: points_now(folder) > 0, "points")
        last, grown, looks = 0, 0, 0
        while looks < 200 or grown <= 20:
            with held(process), h5py.File(folder / "results.h5", "r") as file:
                count = complete(tables(file))
            assert count >= last
            grown, last, looks = grown + (count > last), count, looks + 1
            time.sleep(0.003)
        with held(process):
            assert (read_points(folder)["omega"][:last] > 0).all()


@pytest.mark.slow
def test_results_open_while_the_run_goes_on(tmp_path):
    """From the moment they exist. HDF5 asks for the size of a file before it reads what it should be: a look that meets it growing,
    which is seldom (test_survival.py counts), says so, and the next one finds it whole."""
    def opens(path):
        try:
            with h5py.File(path, "r") as file:
                assert len(file["points"]) == 21 and len(file["points/contact"]) == 5 and len(file["events"]) == 5
        except OSError as error:
            assert "truncated" in str(error)
            return False
        return True

    case = without_end(tmp_path)
    for attempt in range(5):
        with going(case, out=f"out{attempt}") as (_, folder):
            end = time.monotonic() + SECONDS
            while not (folder / "results.h5").exists() and time.monotonic() < end:
                pass
            for look in range(20):
                assert any(opens(folder / "results.h5") for _ in range(3))


# ----------------------------------------------------------------------------------------------------------- giving up
def walking(folder, **overrides):
    """A mass that nothing but friction holds tangentially, under a mean force: one way slip in each cycle, and it walks.

    In stick the tangential force is T = 100 + 300 x_t, the limit 0.5 N, both in closed form; where T would exceed it, no
    periodic motion exists. Returns the case, from 8 to 16 rad/s unless `omega` is named, and the frequencies between those two
    at which such motions end and begin: 12.33, 13.64, 14.84.
    """
    settings = {"fourier": [4, 0, 1], "tangential_stiffness": 300.0, "friction": 0.5, "omega": [8, 16]}
    case = cases.single_mass(folder, 2, **{**settings, **overrides})
    with h5py.File(folder / "reduced.h5", "r+") as file:
        file["Kxx"][...] = np.diag([0.0, 40, 40])
        file["Fx"][...] = [50.0, 0, 50]
    omega = np.linspace(8, 16, 800001)
    swing = 300 * 50 / (300 - omega**2) - 0.5 * 120 * 50 / (160 - omega**2 + 1j * omega * 0.01 * 40)
    walks = 100 - 0.5 * 120 * (800 + 100) / 160 + np.abs(swing) > 0
    return case, omega[np.flatnonzero(np.diff(walks.astype(int)))]


@pytest.mark.slow
def test_signal_ends_the_search_for_a_first_point(tmp_path):
    """Where there is none: with so many samples the search takes several seconds."""
    case, _ = walking(tmp_path, omega=[15, 16], harmonics=20, samples=2**15)
    command, folder = line(case)
    with Watched(command) as watched:
        wait_for(lambda: "step   Omega" in watched.said, "the beginning")
        watched.process.send_signal(signal.SIGTERM)
        watched.process.wait(SECONDS)
    assert watched.process.returncode == 3 and "stopped by SIGTERM before a first point was found" in watched.said
    assert json.loads((folder / "summary.json").read_text())["end"] == "interrupted"


@pytest.mark.parametrize("ranks", RANKS)
@pytest.mark.slow
def test_gives_up_where_no_solution_is(tmp_path, ranks):
    case, (ends, begins, last) = walking(tmp_path)
    done = run(case, status=3, ranks=ranks)
    summary, points = done.summary, done.points
    omega = points["omega"]
    assert omega[-1] == pytest.approx(last, rel=1e-4)  # what lies between two gaps is found
    assert omega[omega < begins].max() == pytest.approx(ends, rel=1e-4) and summary["leaps"] + summary["integrations"] > 0
    assert "of the sweep ahead" in done.out
    assert summary["end"] == "stalled" and summary["failures"] == 1 and summary["points"] == len(points["omega"]) > 10
    assert float(re.search(r"beyond (\S+) rad/s", done.err)[1]) == pytest.approx(points["omega"][-1], rel=1e-7)
    assert str(done.folder / "results.h5") in done.err
    assert summary["why"] and summary["why"] in done.err and f"{summary['points']} points" in done.err
    assert done.err.count("dovetail:") == 1
    assert finite(points)


@pytest.mark.slow
def test_leaps_past_wanted_frequencies_without_solution(tmp_path):
    wanted = [12.0, 12.6, 12.8, 13.0, 13.2, 13.4, 14.0]
    case, (ends, begins, last) = walking(tmp_path, at=wanted)
    done = run(case, status=3)
    omega = done.points["omega"]
    assert [w for w in wanted if w in omega] == [12.0, 14.0] and omega[-1] == pytest.approx(last, rel=1e-4)
    assert done.out.count("this frequency of continuation.at is left out by a leap") == 5 == done.summary["missed"]


@pytest.mark.slow
def test_gives_up_at_the_first_frequency(tmp_path):
    case, ends = walking(tmp_path, omega=[15, 16])
    done = run(case, status=3)
    assert 15 > ends[-1] and done.summary["end"] == "no_start" and done.summary["points"] == 0
    assert done.summary["why"] in done.err and "15 rad/s" in done.err
    assert {len(values) for values in done.points.values()} == {0}


@pytest.mark.slow
def test_begins_between_the_ends_where_they_have_no_solution(tmp_path):
    case, (_, begin, end) = walking(tmp_path, omega=[12.5, 16])
    done = run(case, status=3)
    omega = done.points["omega"]
    assert begin < omega[0] == 12.5 + 0.35 * 3.5 < end and omega[-1] == pytest.approx(end, rel=1e-5)
    assert "no solution was found at the first frequency: begun at this one" in done.out


def test_gives_up_for_tolerances_out_of_reach(tmp_path):
    done = run(cases.dof5(tmp_path, max_iterations=2, step_tolerance=1e-18, residual_tolerance=1e-18), status=3)
    assert done.summary["end"] in ("no_start", "stalled") and "newton.max_iterations" in done.err and "rad/s" in done.err
    assert done.summary["points"] == len(done.points["omega"])


def test_an_earlier_success_is_not_left_beside_a_failure(tmp_path):
    """summary.json belongs to the results beside it, also when the run is killed or ends at once."""
    run(cases.dof5(tmp_path, **POINT))
    with going(without_end(tmp_path)) as (_, folder):
        wait_for(lambda: points_now(folder) > 20, "points")
    summary = folder / "summary.json"
    assert not summary.exists() or json.loads(summary.read_text()).get("end") != "arrived"


def limited(size):
    """A command prefix: files may grow to `size` bytes, beyond which writing fails as on a full disk (EFBIG for ENOSPC)."""
    return [sys.executable, "-c", "import os, resource, signal, sys; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
            f"resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size})); os.execv(sys.argv[1], sys.argv[1:])"]


# Largest file [bytes], the file that cannot be written then, and whether reduced.h5 is there already.
FULL = {"at once": (400, "reduced.h5", False), "reduced.h5 half written": (4000, "reduced.h5", False),
        "before the first point": (9000, "results.h5", True), "after 47 points": (700_000, "results.h5", True)}


@pytest.mark.parametrize("name, ranks", [("at once", 1), ("reduced.h5 half written", 2), ("before the first point", 1),
                                         ("after 47 points", 1), ("after 47 points", 2)])
@pytest.mark.slow
def test_disk_full(tmp_path, name, ranks):
    """By tcp: the limit would meet the shared-memory files of Open MPI, too."""
    size, blamed, is_reduced = FULL[name]
    case = cases.several_points(tmp_path, harmonics=20, samples=128, adaptive=False, step=0.001)
    if is_reduced:
        run(case, command="reduce")
    command, folder = line(case)
    out, err = words_of(["mpirun", "-n", str(ranks), "--mca", "btl", "self,tcp", *limited(size), *command], 3)
    assert str(folder / blamed) in err and "disk full" in err and err.count("dovetail:") == 1
    assert is_reduced or not (folder / "reduced.h5").exists()
    if name == "after 47 points":  # rows of 17 x 41 numbers in chunks of 47, of which the first fits
        points = read_points(folder)
        assert len(points["omega"]) >= 40 and (points["coefficients"][:40] != 0).any(axis=(1, 2)).all()


# ------------------------------------------------------------------------------------------------------------- summary
@pytest.mark.parametrize("ranks", [1, 3])
def test_summary(tmp_path, ranks):
    done = run(cases.dof5(tmp_path, **SMALL), ranks=ranks)
    summary, points = done.summary, done.points
    assert summary["ranks"] == ranks and summary["end"] == "arrived" and summary["failures"] == 0
    assert summary["points"] == len(points["omega"]) and summary["last_omega"] == 1.3
    assert summary["newton_iterations"] >= points["newton_iterations"].sum() > 0
    assert summary["linear_iterations"] >= points["linear_iterations"].sum() > 0
    assert summary["step_cuts"] >= 0 and summary["program"].startswith("dovetail ")
    assert len(summary["stages"]) >= 4
    for stage in summary["stages"]:
        assert stage["name"] and len(stage["seconds"]) == len(stage["peak_mib"]) == ranks
        assert min(stage["seconds"]) >= 0 and 1 < min(stage["peak_mib"]) <= max(stage["peak_mib"]) < 4096
    assert max(sum(stage["seconds"][rank] for stage in summary["stages"]) for rank in range(ranks)) < SECONDS


# --------------------------------------------------------------------------------------------------------------- sweep
def test_max_points(tmp_path):
    done = run(cases.dof5(tmp_path, max_points=7, **SMALL))
    assert len(done.points["omega"]) == 7 and done.points["omega"][-1] < 1.3
    assert done.summary["end"] == "max_points" and "max_points = 7" in done.out


def test_max_points_counts_the_exact_frequencies(tmp_path):
    wanted = list(np.linspace(0.90001, 0.90009, 9))
    done = run(cases.dof5(tmp_path, max_points=4, at=wanted, **SMALL))
    assert list(done.points["omega"]) == [0.9, *wanted[:3]]


def test_equal_frequencies_give_one_point(tmp_path):
    done = run(cases.dof5(tmp_path, **POINT))
    assert list(done.points["omega"]) == [0.9] and done.summary["end"] == "arrived"


@pytest.mark.parametrize("kind", ["none", "auto"])
@pytest.mark.parametrize("omega, at", [([0.9, 1.1], [0.9, 0.95, 1.0123456789012345, 1.1]),
                                       ([1.1 + 3e-16, 1 / 1.3], [1.1, 1.0123456789012345, 0.8])])
def test_the_users_frequencies_come_out_to_the_last_bit(tmp_path, kind, omega, at):
    found = run(cases.dof5(tmp_path, omega=omega, at=at, kind=kind, **SMALL)).points["omega"]
    assert [found[0], found[-1]] == omega
    assert [w for w in found if w in at] == at
    assert (np.diff(found) * np.sign(omega[1] - omega[0]) > 0).all()


def test_both_directions_meet_where_slip_is_unique(tmp_path):
    """In 1.004..1.064 both directions slip, so that the response does not depend on the way there."""
    up = run(cases.dof5(tmp_path, at=[1.03], **cases.TIGHT), out="up").points
    down = run(cases.dof5(tmp_path, at=[1.03], omega=[1.3, 0.9], **cases.TIGHT), out="down").points
    assert (down["omega"][0], down["omega"][-1]) == (1.3, 0.9)
    close(up["coefficients"][up["omega"] == 1.03], down["coefficients"][down["omega"] == 1.03], 1e-8)


@pytest.mark.slow
def test_starts_from_other_results(tmp_path, arrived):
    """The nearest of their points, so that one or two iterations confirm it; the answer does not change."""
    where = {"omega": [1.05, 1.05], **cases.TIGHT}
    first = run(cases.dof5(tmp_path, **where, at=[1.05]), out="first")
    started = cases.dof5(tmp_path, start="first/results.h5", **where)
    again = run(started, out="again")
    assert again.summary["newton_iterations"] <= 2 < first.summary["newton_iterations"]
    close(again.points["coefficients"], first.points["coefficients"])
    started.edit("first/results.h5", str(arrived[1].folder / "results.h5"))
    nearby = run(started, out="nearby")
    assert nearby.summary["newton_iterations"] < first.summary["newton_iterations"]
    close(nearby.points["coefficients"], again.points["coefficients"], 1e-8)


@pytest.mark.parametrize("harmonics, ranks", [(3, 2), (15, None)])
@pytest.mark.slow
def test_starts_from_results_with_other_harmonics(tmp_path, arrived, harmonics, ranks):
    where = {"omega": [1.05, 1.05], "harmonics": harmonics, **cases.TIGHT}
    cold = run(cases.dof5(tmp_path, **where), out="cold")
    done = run(cases.dof5(tmp_path, start=str(arrived[1].folder / "results.h5"), **where), out="warm", ranks=ranks)
    assert done.points["coefficients"].shape == (1, 5, 2 * harmonics + 1)
    assert done.summary["newton_iterations"] < cold.summary["newton_iterations"]
    close(done.points["coefficients"], cold.points["coefficients"], 1e-8)


@pytest.mark.parametrize("ranks", RANKS)
@pytest.mark.slow
def test_starts_from_no_other_model(tmp_path, arrived, ranks):
    case = cases.several_points(tmp_path, start=str(arrived[1].folder / "results.h5"))
    err = run(case, status=2, ranks=ranks, out="out").err
    assert "results.h5" in err and "does not belong to this model" in err and err.count("dovetail:") == 1


@pytest.mark.parametrize("name", ["model.h5", "case.toml"])
def test_starts_from_results_only(tmp_path, name):
    case = cases.dof5(tmp_path, start=name)
    assert name in run(case, status=2, out="out").err


# ------------------------------------------------------------------------------------------------------------- reduced
def changed(folder, **changes):
    """The five-degree-of-freedom model with other arrays, as case and as files."""
    case = cases.dof5(folder, **POINT)
    structure = case.structure
    for name, values in changes.items():
        setattr(structure, name, values)
    return cases.full(folder, "changed", structure, {}, **{"modes": 2, **case.settings})


def stored(path):
    with h5py.File(path, "r") as file:
        return {name: file[name][()] for name in ("Kaa", "Max", "Mxx", "Kxx", "Fa", "Fx", "R")}


def check_reduced(path, case):
    for name, values in stored(path).items():
        close(values, getattr(case.reduced, name.lower()))


STIFFER = 20 * np.eye(5) - 10 * np.eye(5, k=1) - 10 * np.eye(5, k=-1)
NEW_MODELS = {
    "K": dict(K=STIFFER),
    "M": dict(M=np.diag([1, 2, 1, 1, 1.0])),
    "F": dict(force=np.array([1.0, 1, 0, 0, 1e-3])),
    "P": dict(preload=np.array([1, 0.1, 0.1, 0.1, 0.2])),
    "F and P exchanged": dict(force=np.array([1, 0.1, 0.1, 0.1, 0.1]), preload=np.array([1.0, 1, 0, 0, 0])),
    "order of the contact dofs": dict(contact_dofs=np.array([[3, 2, 4]])),
    "contact dofs": dict(contact_dofs=np.array([[1, 3, 4]])),
}


@pytest.fixture(scope="module")
def reduced_once(tmp_path_factory):
    done = run(cases.dof5(tmp_path_factory.mktemp("reduced"), **POINT), command="reduce")
    assert REUSED not in done.out
    return done.folder


@pytest.fixture
def reduced(reduced_once, tmp_path):
    """The reduced file of the model of POINT, in a folder of the test's own."""
    shutil.copytree(reduced_once, tmp_path, dirs_exist_ok=True)
    return tmp_path / "reduced.h5"


def test_reduce_stops_after_the_reduction(tmp_path, reduced):
    check_reduced(reduced, cases.dof5(tmp_path, **POINT))
    assert not (tmp_path / "results.h5").exists() and not list(tmp_path.glob("*.partial"))
    assert "branch" not in {stage["name"].split()[-1] for stage in json.loads((tmp_path / "summary.json").read_text())["stages"]}


@pytest.mark.parametrize("ranks", RANKS)
@pytest.mark.slow
def test_reduced_file_is_reused_while_the_model_stays(tmp_path, reduced, ranks):
    """Contact, excitation, sweep and numerics are no part of it."""
    before = reduced.stat()
    case = cases.dof5(tmp_path, harmonics=4, samples=64, fourier=[0, 1], normal_stiffness=2.0, friction=[0.5, 0.5], gap=-3.0,
                      stiffness=0.1, omega=[1.2, 1.2], kind="auto", initial=0.0)
    done = run(case, ranks=ranks)
    assert REUSED in done.out and str(reduced) in done.out
    after = reduced.stat()
    assert (after.st_mtime_ns, after.st_ino, after.st_size) == (before.st_mtime_ns, before.st_ino, before.st_size)
    fresh = run(case, out="fresh")
    assert REUSED not in fresh.out
    close(done.points["coefficients"], fresh.points["coefficients"])


@pytest.mark.parametrize("name", NEW_MODELS)
def test_reduced_file_is_made_anew_for_another_model(tmp_path, reduced, name):
    case = changed(tmp_path, **NEW_MODELS[name])
    assert REUSED not in run(case, command="reduce").out
    check_reduced(reduced, case)


@pytest.mark.parametrize("modes", [0, 1])
def test_reduced_file_is_made_anew_for_other_modes(tmp_path, reduced, modes):
    case = cases.dof5(tmp_path, modes=modes, **POINT)
    assert REUSED not in run(case, command="reduce").out
    check_reduced(reduced, case)


def cut(share):
    return lambda path: path.write_bytes(path.read_bytes()[:int(share * path.stat().st_size)])


def without_dataset(path):
    with h5py.File(path, "r+") as file:
        del file["Fx"]


DAMAGE = {"empty": cut(0), "half": cut(0.5), "last bytes": cut(0.99), "dataset missing": without_dataset}


@pytest.mark.parametrize("name, ranks", [(name, None) for name in DAMAGE] + [("half", 2)])
def test_damaged_reduced_file_is_made_anew(tmp_path, reduced, name, ranks):
    DAMAGE[name](reduced)
    case = cases.dof5(tmp_path, **POINT)
    assert REUSED not in run(case, ranks=ranks).out
    check_reduced(reduced, case)


@pytest.mark.slow
def test_reduced_file_named_in_the_case_gives_the_same_branch(tmp_path):
    case = cases.several_points(tmp_path, omega=[0.8, 1.2])
    whole = run(case, out="out").points
    case.edit('model = "model.h5"', 'reduced = "out/reduced.h5"')
    case.edit("[reduction]\nmodes = 5\n", "")
    done = run(case, out="again")
    assert not (done.folder / "reduced.h5").exists()
    for name in set(whole) - {"seconds"}:
        np.testing.assert_array_equal(done.points[name], whole[name])


# ------------------------------------------------------------------------------------------------ models at their edge
def all_in_contact(folder):
    """Two contact points and nothing else."""
    n = 6
    K = 20 * np.eye(n) - 5 * np.eye(n, k=1) - 5 * np.eye(n, k=-1)
    force, preload = np.array([1.0, 0.5, 0, 0, 0.2, 0]), np.array([0, 0, 4.0, 0, 0, 5])
    Model(K, np.eye(n), np.arange(n).reshape(2, 3), force, preload).write(folder / "model.h5")
    none = np.zeros(0)
    reduced = reference.Reduced(none, np.zeros((0, n)), np.eye(n), K, none, force, -preload)
    return cases.write(folder, "no elastic dof", "model.h5", None, reduced, {}, modes=0, stiffness=0.05, fourier=[0, 0, 1],
                       normal_stiffness=3.0, tangential_stiffness=2.0, friction=0.2, gap=0.0, initial=0.0, harmonics=4, samples=64,
                       omega=[3, 3.2], step=0.1, **cases.TIGHT)


EDGES = {
    "no elastic dof": all_in_contact,
    "no modes": lambda folder: cases.dof5(folder, modes=0, omega=[0.8, 0.9], **SMALL, **cases.TIGHT),
    "every mode": lambda folder: cases.dof5(folder, modes=2, omega=[0.8, 0.9], **SMALL, **cases.TIGHT),
}


@pytest.mark.parametrize("ranks", [None, 3])
@pytest.mark.parametrize("name", EDGES)
def test_fewest_and_most_modes(tmp_path, name, ranks):
    """On three ranks, one or two contact points leave ranks without any."""
    case = EDGES[name](tmp_path)
    done = run(case, ranks=ranks)
    check_reduced(tmp_path / "reduced.h5", case)
    points, system = done.points, case.system()
    assert done.summary["end"] == "arrived" and points["coefficients"].shape[1:] == system.shape
    for i in (0, len(points["omega"]) - 1):
        close(points["coefficients"][i], system.solve(points["omega"][i], points["coefficients"][i]), 1e-7)
    with h5py.File(tmp_path / "results.h5", "r") as file:
        close(file["preload/xp"][()].ravel(), case.preload.xp.ravel())


def test_one_mode_too_many(tmp_path):
    case = cases.dof5(tmp_path, **POINT)
    case.edit("modes = 2", "modes = 3")
    err = run(case, status=2).err
    assert "model.h5" in err and "modes = 3" in err and "2 elastic dofs" in err


def chain(springs, ground=0.0):
    """Stiffness of masses in a row, the first held by a spring `ground`."""
    K = np.zeros((len(springs) + 1,) * 2)
    K[0, 0] = ground
    for i, k in enumerate(springs):
        K[i:i + 2, i:i + 2] += k * np.array([[1, -1], [-1, 1]])
    return K


def joined(*blocks):
    """Block diagonal of elastic parts and, last, one contact point on three springs to ground."""
    sizes = [len(block) for block in blocks] + [3]
    K = np.zeros((sum(sizes),) * 2)
    for block, at in zip((*blocks, 2 * np.eye(3)), np.cumsum([0, *sizes])):
        K[at:at + len(block), at:at + len(block)] = block
    return K


def free_in_space(n, rigid, seed=1):
    """Positive semi-definite to round-off, with so many motions that cost nothing."""
    shapes = np.random.default_rng(seed).normal(size=(n - rigid, n))
    K = shapes.T @ shapes
    return (K + K.T) / 2


RIGID = ["either constraints are missing", "rigid-body motion is left"]  # found in the factors, or by the lowest mode
# Stiffness of the elastic dofs, and of which words the message must hold one.
LOOSE = {
    "free": (chain([1]), RIGID),
    "free to round-off": (chain([0.1, 0.3, 1 / 3, 0.7, 1e4 / 7]), RIGID),
    "free in space": (free_in_space(30, 6), RIGID),
    "second part free": (joined(chain([1.1, 2.3], ground=5.0), chain([1 / 3, 0.7]))[:-3, :-3], RIGID),
    "dof without stiffness": (np.diag([1.0, 0, 1]), RIGID),
    "indefinite": (chain([1, -3, 2], ground=1.0), ["not positive definite", "w^2 = -"]),
    "indefinite, positive diagonal": (np.array([[1.0, 2], [2, 1]]), ["not positive definite", "w^2 = -"]),
}


def loose(folder, K, M=None, modes=1):
    n = len(K) + 3
    mass = np.eye(n)
    if M is not None:
        mass[:-3, :-3] = M
    force = np.zeros(n)
    force[0] = 1
    Model(joined(K), mass, [[n - 3, n - 2, n - 1]], force, np.eye(n)[-1]).write(folder / "model.h5")
    return cases.write(folder, "loose", "model.h5", None, None, {}, modes=modes, stiffness=0.05, fourier=[0, 0, 1],
                       normal_stiffness=1.0, tangential_stiffness=1.0, friction=0.3, gap=0.0, **POINT)


@pytest.mark.parametrize("name, modes, ranks", [
    *[(name, 1, None) for name in LOOSE], ("free to round-off", 0, None), ("indefinite", 0, None), ("free in space", 0, 2),
    ("second part free", 1, 2), ("indefinite", 1, 2)])
def test_structure_that_cannot_stand(tmp_path, name, modes, ranks):
    K, words = LOOSE[name]
    err = run(loose(tmp_path, K, modes=modes), status=2, ranks=ranks).err
    assert "model.h5" in err and any(word in err for word in words) and err.count("dovetail:") == 1
    assert not list(tmp_path.glob("reduced.h5*"))


MASSES = {"one negative": np.diag([1, 1, -1, 1.0]), "all negative": -np.eye(4),
          "indefinite": np.eye(4) + 2 * (np.eye(4, k=1) + np.eye(4, k=-1))}


@pytest.mark.parametrize("name, modes, ranks", [("one negative", 1, None), ("one negative", 1, 2), ("all negative", 0, None),
                                                ("indefinite", 4, None)])
def test_mass_that_is_not_positive(tmp_path, name, modes, ranks):
    case = loose(tmp_path, chain([1.5, 2.5, 3.5], ground=4.0), MASSES[name], modes=modes)
    err = run(case, status=2, ranks=ranks).err
    assert "model.h5" in err and "/M" in err and "positive definite" in err and err.count("dovetail:") == 1


def test_massless_elastic_dof(tmp_path):
    """Nothing in the equations forbids it while a mode is left out; its modes at infinity must not come in."""
    K = chain([1.5, 2.5, 3.5], ground=4.0)
    case = loose(tmp_path, K, np.diag([1, 0, 1, 1.0]), modes=2)
    run(case)
    with h5py.File(tmp_path / "reduced.h5", "r") as file:
        squares = file["Kaa"][()]
    condensed = K - np.outer(K[:, 1], K[1]) / K[1, 1]
    keep = [0, 2, 3]
    close(squares, np.linalg.eigvalsh(condensed[np.ix_(keep, keep)])[:2])


# ---------------------------------------------------------------------------------------------------------- parameters
def in_force(done):
    with h5py.File(done.folder / "results.h5", "r") as file:
        return {name: values[()] for name, values in file["contact"].items()}


SPELLINGS = {
    "numbers": (dict(normal_stiffness=3.0, tangential_stiffness=2.0, friction=0.3, gap=-0.1),
                ([3] * 4, [[2, 2]] * 4, [[0.3, 0.3]] * 4, [-0.1] * 4)),
    "integers": (dict(normal_stiffness=3, tangential_stiffness=2, friction=[1, 0], gap=0),
                 ([3] * 4, [[2, 2]] * 4, [[1, 0]] * 4, [0] * 4)),
    "per direction": (dict(normal_stiffness=3.0, tangential_stiffness=[2.0, 1.0], friction=[0.3, 0.4], gap=-0.1),
                      ([3] * 4, [[2, 1]] * 4, [[0.3, 0.4]] * 4, [-0.1] * 4)),
    "per point": (dict(normal_stiffness=[3.0, 4.0, 5.0, 6.0], tangential_stiffness=[1.0, 2.0, 3.0, 4.0],
                       friction=[0.1, 0.2, 0.3, 0.4], gap=[-0.1, -0.2, -0.3, 0.1]),
                  ([3, 4, 5, 6], [[1, 1], [2, 2], [3, 3], [4, 4]], [[0.1, 0.1], [0.2, 0.2], [0.3, 0.3], [0.4, 0.4]],
                   [-0.1, -0.2, -0.3, 0.1])),
    "per direction and point": (dict(normal_stiffness=3.0, tangential_stiffness=[[1.0, 2.0], [2.0, 3.0], [3.0, 4.0], [4.0, 5.0]],
                                     friction=[[0.1, 0.2], [0.2, 0.3], [0.3, 0.4], [0.4, 0.5]], gap=-0.1),
                                ([3] * 4, [[1, 2], [2, 3], [3, 4], [4, 5]], [[0.1, 0.2], [0.2, 0.3], [0.3, 0.4], [0.4, 0.5]], [-0.1] * 4)),
}
NAMES = ("normal_stiffness", "tangential_stiffness", "friction", "gap")


@pytest.mark.parametrize("name", SPELLINGS)
def test_contact_parameters_from_the_case(tmp_path, name):
    settings, expected = SPELLINGS[name]
    found = in_force(run(cases.several_points(tmp_path, **settings, **POINT)))
    for key, values in zip(NAMES, expected):
        np.testing.assert_array_equal(found[key], values)


@pytest.mark.parametrize("name, ranks", [(name, None) for name in SPELLINGS if name != "integers"] + [("per direction and point", 2)])
def test_contact_parameters_from_the_model(tmp_path, name, ranks):
    """Those that the case does not name; what it names counts."""
    settings, expected = SPELLINGS[name]
    case = cases.several_points(tmp_path, friction=0.25, **POINT)
    with h5py.File(tmp_path / "model.h5", "r+") as file:
        for key, values in settings.items():
            file[f"contact/{key}"] = values
    text = re.sub(r"^(normal_stiffness|tangential_stiffness|gap) = .*\n", "", case.path.read_text(), flags=re.MULTILINE)
    case.path.write_text(text)
    found = in_force(run(case, ranks=ranks))
    for key, values in zip(NAMES, expected):
        np.testing.assert_array_equal(found[key], np.full((4, 2), 0.25) if key == "friction" else values)


@pytest.mark.parametrize("ranks", RANKS)
@pytest.mark.parametrize("omega", [[1.0, 1.0], [1.0, 1.5]])
def test_resonance_that_nothing_damps_is_told(tmp_path, omega, ranks):
    """The first of two modes, alone at 1 rad/s: the motion there is what rounding makes of it."""
    structure = cases.Structure(K=np.diag([1.0, 4, 9, 16, 25]), M=np.eye(5), contact_dofs=np.array([[2, 3, 4]]),
                                force=np.array([1.0, 0, 0, 0, 0]), preload=np.array([0, 0, 0, 0, 1.0]))
    keys = dict(modes=2, stiffness=0.0, fourier=[0, 1], normal_stiffness=1.0, tangential_stiffness=1.0, friction=0.3, gap=0.0,
                initial=0.0, harmonics=1, omega=omega)
    done = run(cases.full(tmp_path, "without damping", structure, {}, **keys), status=3, out="out", ranks=ranks)
    assert done.err.count("dovetail:") == 1 and "rad/s an eigenfrequency is excited and nothing damps it" in done.err
    assert done.summary["end"] == "failed" and not list(done.folder.glob("results.h5*"))
    if omega == [1.0, 1.0]:  # F / (xi omega k)
        done = run(cases.full(tmp_path, "damped", structure, {"stiffness": 1e-9}, **keys), out="damped", ranks=ranks)
        np.testing.assert_allclose(np.hypot(*done.points["coefficients"][0, 0, 1:3]), 1e9, rtol=1e-6)


# ------------------------------------------------------------------------------------------------------------- command
@pytest.mark.parametrize("arguments, words", [
    ([], ["no command", "dovetail run"]),
    (["rnu", "case.toml"], ["\"rnu\" is not a command", "run", "reduce"]),
    (["run"], ["wants a case file"]),
    (["reduce"], ["wants a case file"]),
    (["run", "nowhere.toml"], ["nowhere.toml", "no such case file"]),
    (["run", "case.toml", "--dry"], ["--dry is not an option", "--dry-run"]),
    (["run", "case.toml", "-restart"], ["-restart: ", "write --restart"]),
    (["run", "case.toml", "-out", "there"], ["-out: ", "write --out"]),
    (["run", "case.toml", "-o", "there"], ["-o: ", "write --out"]),
    (["run", "case.toml", "-hb_ksp_type", "gmres", "-dry_run"], ["-dry_run: ", "write --dry-run"]),
    (["run", "case.toml", "--out", ""], ["--out \"\"", "name of a folder"]),
    (["-version"], ["-version: ", "write --version"]),
    (["run", "case.toml", "--out"], ["--out wants a folder"]),
    (["run", "case.toml", "second.toml"], ["second.toml"]),
])
def test_wrong_command_line(arguments, words):
    out, err = words_of([BINARY, *arguments], 2)
    assert out == "" and all(word in err for word in words)


@pytest.mark.parametrize("arguments", [["--help"], ["run", "-h"]])
def test_help(arguments):
    out, err = words_of([BINARY, *arguments])
    assert err == "" and all(word in out for word in ("run", "reduce", "--out", "--dry-run", "--version", "mpirun", "Exit status"))


def test_version():
    out, err = words_of([BINARY, "--version"])
    assert re.fullmatch(r"dovetail \d+\.\d+\.\d+ \(\S+\)\n", out) and err == ""


def test_dry_run_writes_nothing(tmp_path):
    case = cases.dof5(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    run(case, "--dry-run", out="out")
    assert sorted(tmp_path.rglob("*")) == before


def test_petsc_options_reach_the_solvers(tmp_path):
    case = cases.dof5(tmp_path, **POINT)
    signs = {"-hb_snes_monitor": "SNES Function norm", "-log_view": "5 branch", "-kee_mat_mumps_icntl_4": "Entering DMUMPS"}
    done = run(case, *signs, 2)
    assert all(sign in done.out for sign in signs.values()) and len(done.points["omega"]) == 1
    plain = run(case, out="plain").out
    assert not any(sign in plain for sign in signs.values() if sign != "5 branch")


def test_petsc_options_act(tmp_path):
    case = cases.dof5(tmp_path, **POINT)
    hindered, plain = run(case, "-hb_snes_max_it", 1, out="hindered"), run(case, out="plain")
    assert hindered.summary["newton_iterations"] > plain.summary["newton_iterations"]  # loads in small steps, of one harmonic
    close(hindered.points["coefficients"], plain.points["coefficients"], 1e-6)


def test_first_point_comes_from_one_harmonic(tmp_path):
    """Where the contact closes once a period Newton's method finds nothing from rest with all of them."""
    case = cases.dof5(tmp_path, **POINT | {"harmonics": 10}, normal_stiffness=100.0, tangential_stiffness=[50.0, 50.0],
                      friction=[0.3, 0.3], gap=0.2)
    found = run(case, out="found")
    assert "Newton does not converge" not in found.out and found.summary["points"] == 1
    with case.path.open("a") as file:
        file.write("\n[recovery]\nstrategies = []\n")
    run(case, out="rest", status=3)


def test_options_that_lie_in_the_folder_are_told_and_not_obeyed(tmp_path):
    case = cases.dof5(tmp_path, **POINT)
    (tmp_path / ".petscrc").write_text("-hb_snes_max_it 1\n-hb_snes_monitor\n")
    for ranks in RANKS:
        command, _ = line(case, ranks=ranks, out="out")
        done = subprocess.run(command, cwd=tmp_path, env=SURROUNDINGS, capture_output=True, text=True, timeout=SECONDS)
        assert done.returncode == 0 and "SNES Function norm" not in done.stdout
        assert done.stderr == "dovetail: note: options in .petscrc are not read; -options_file .petscrc reads them\n"
    done = subprocess.run([*line(case, out="out")[0], "-options_file", ".petscrc"], cwd=tmp_path, env=SURROUNDINGS, capture_output=True,
                          text=True, timeout=SECONDS)
    assert "SNES Function norm" in done.stdout


@pytest.mark.parametrize("option", ["--dry-run", "--out"])
def test_own_option_behind_those_of_petsc_is_not_overlooked(tmp_path, option):
    """Obeyed or refused, but no run in the folder that the user meant to spare."""
    case = cases.dof5(tmp_path, **POINT)
    behind = [option, tmp_path / "other"] if option == "--out" else [option]
    subprocess.run([BINARY, "run", case.path, "-hb_snes_max_it", "40", *behind], env=SURROUNDINGS, capture_output=True, timeout=SECONDS)
    assert not (tmp_path / "results.h5").exists()


@pytest.mark.parametrize("ranks", [None, 1, pytest.param(2, marks=pytest.mark.slow)])
def test_log_file_gets_a_line_now_and_then(tmp_path, arrived, ranks):
    """Under mpirun as well, which gives its ranks a pseudo-terminal of its own whatever stands behind it."""
    done = arrived[1] if ranks is None else run(arrived[0], ranks=ranks, out=f"out{ranks}")
    assert done.summary["points"] > 50
    assert 2 <= len(PROGRESS.findall(done.out)) <= 2 + done.summary["stages"][-1]["seconds"][0] / 5


def test_terminal_gets_a_line_for_each_point(tmp_path):
    command, folder = line(cases.dof5(tmp_path))
    ours, theirs = pty.openpty()
    process = subprocess.Popen(command, env=SURROUNDINGS, stdout=theirs, stderr=theirs, stdin=theirs)
    os.close(theirs)
    text = b""
    try:
        while block := os.read(ours, 65536):
            text += block
    except OSError:  # the far end is closed: the run is over
        pass
    assert process.wait(SECONDS) == 0
    lines = PROGRESS.findall(text.decode().replace("\r", ""))
    assert len(lines) == len(read_points(folder)["omega"]) > 50
    assert [int(one.split()[0]) for one in lines] == list(range(1, len(lines) + 1))


# ------------------------------------------------------------------------------------------------- numbers out of range
EXTREMES = {
    "load 1e6": dict(fourier=[0, 0, 1e6]),
    "load 1e200, scaled": dict(fourier=[0, 0, 1e200], kind="auto"),
    "load 1e-300, scaled": dict(fourier=[0, 0, 1e-300], kind="auto"),
    "load 1e-300": dict(fourier=[0, 0, 1e-300]),
    "gap -1e200": dict(gap=-1e200),
    "normal stiffness 1e300": dict(normal_stiffness=1e300),
    "damping 1e300": dict(stiffness=1e300),
    "preload 1e200": dict(initial=1e200),
    "omega 1e200": dict(omega=[1e200, 2e200]),
    "omega 1e-300": dict(omega=[1e-300, 1e-3]),
    "step 1e300": dict(step=1e300),
    "step 1e-300": dict(step=1e-300, max_points=50),
    "scales": dict(kind="manual", frequency=1e-200, modal=1e200, contact=1e-200),
}


@pytest.mark.parametrize("name", EXTREMES)
def test_numbers_out_of_range(tmp_path, name):
    """Solved, refused, or given up with a reason; never NaN in a file, never endless."""
    case = cases.dof5(tmp_path, **{**SMALL, "max_points": 300, **EXTREMES[name]})
    command, folder = line(case)
    done = subprocess.run(command, env=SURROUNDINGS, capture_output=True, text=True, timeout=SECONDS)
    assert done.returncode in (0, 2, 3), done.stderr
    assert done.returncode == 0 or re.search(r"dovetail: .{20}", done.stderr)
    if (folder / "summary.json").exists():
        summary = json.loads((folder / "summary.json").read_text(), parse_constant=pytest.fail)
        assert summary["end"] == "arrived" or summary["why"], "no reason given"
    if (folder / "results.h5").exists():
        assert finite(read_points(folder))


@pytest.mark.parametrize("ranks", RANKS)
@pytest.mark.slow
def test_load_of_1e200_in_the_model(tmp_path, ranks):
    case = cases.dof5(tmp_path, **SMALL)
    structure = case.structure
    Model(structure.K, structure.M, structure.contact_dofs, 1e200 * structure.force, structure.preload).write(tmp_path / "model.h5")
    done = run(case, status=3, ranks=ranks)
    assert re.search("NaN|infinite|finite", done.err) and not re.search(r"\bnan\b", done.out)
    assert all(np.isfinite(values).all() for values in done.points.values())
