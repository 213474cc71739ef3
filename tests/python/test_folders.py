"""Folders that lose nothing: one run at a time, earlier results stay until a new run has a first point, and files that are not
Dovetail's are left alone."""

import fcntl
import json
import re
import shutil
import signal

import h5py
import numpy as np
import pytest

import cases
from dovetail import Results
from dovetail.__main__ import main
from launch import SECONDS, children, going, kill, line, read_points, run, wait_for
from on_terminal import Watched
from test_runs import walking

SMALL = {"harmonics": 3, "samples": 32}
RANKS = [None, 2]


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    """A run stopped at max_points; its folder is to be copied by a test that changes it."""
    case = cases.dof5(tmp_path_factory.mktemp("ended"), max_points=20, **SMALL)
    run(case, out="out")
    return case


@pytest.fixture
def copy(ended, tmp_path):
    return ended.copied(tmp_path / "copy")


def cut_off(case, points):
    """Kills a run after so many points; returns its folder and how many there are."""
    command, folder = line(case, out="out")
    with Watched(command) as watched:
        watched.wait_for_point(points)
        kill(watched.process)
    return folder, len(read_points(folder)["omega"])


# ------------------------------------------------------------------------------------------------------ one at a time
def test_runs_on_one_rank_need_no_folder_of_open_mpi(tmp_path):
    """All would share it, and the first to end takes it away from one that begins."""
    (tmp_path / "file").touch()
    case = cases.dof5(tmp_path, max_points=3, **SMALL)
    run(case, prefix=["env", f"OMPI_MCA_orte_tmpdir_base={tmp_path}/file/folder"], out="out")


@pytest.mark.parametrize("ranks", [None, pytest.param(2, marks=pytest.mark.slow)])
def test_second_run_is_told_who_holds_the_folder(tmp_path, ranks):
    case = cases.dof5(tmp_path, **cases.ENDLESS, **SMALL)
    with going(case, out="out", ranks=ranks) as (process, folder):
        wait_for((folder / "state.h5").exists, "the first points")
        holder = sorted(children(process.pid))[0] if ranks else process.pid
        for options in ([], ["--restart"]):
            done = run(case, *options, status=2, out="out", ranks=ranks)
            assert done.err.count("dovetail:") == 1 and f"{folder}: another run is writing there" in done.err
            told = re.search(r"\(process (\d+) on \S+, since 20\d\d-\d\d-\d\d \d\d:\d\d:\d\d\)", done.err)
            assert told and "--out" in done.err
            if not ranks:
                assert int(told[1]) == holder
    kept = len(read_points(folder)["omega"])  # it was killed: nobody holds the folder now
    case.edit("max_points = 1000000", f"max_points = {kept + 5}")
    assert len(run(case, "--restart", out="out", ranks=ranks).points["omega"]) == kept + 5
    assert not (folder / "dovetail.lock").exists()


def test_reduction_alone_waits_its_turn_too(tmp_path):
    case = cases.dof5(tmp_path, **cases.ENDLESS, **SMALL)
    with going(case, out="out") as (_, folder):
        wait_for((folder / "results.h5").exists, "the first point")
        assert "another run is writing there" in run(case, command="reduce", out="out", status=2).err
        assert run(case, "--dry-run", out="out").err == ""


def test_files_of_a_run_that_goes_on_are_not_judged(copy):
    """What it is writing may look like anybody's."""
    folder = copy.path.parent / "out"
    (folder / "state.h5.partial").write_text("half")
    with open(folder / "dovetail.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        for options in ([], ["--restart"]):
            assert f"{folder}: another run is writing there" in run(copy, *options, out="out", status=2).err
    assert "state.h5.partial there was not written by dovetail" in run(copy, out="out", status=2).err


def test_lock_file_of_another_program_is_left_alone(copy):
    lock = copy.path.parent / "out" / "dovetail.lock"
    lock.write_text("shopping list")
    assert "dovetail.lock: was not written by dovetail" in run(copy, out="out", status=2).err
    assert lock.read_text() == "shopping list"


# ----------------------------------------------------------------------------------- earlier results, until a first point
def without_mass(case):
    with h5py.File(case.path.parent / "model.h5", "r+") as file:
        file["M/data"][...] = -file["M/data"][...]


def without_force(case):
    with h5py.File(case.path.parent / "model.h5", "r+") as file:
        file["force"][...] = 0


def without_hold(case):  # nothing holds the body, and it is drawn away
    case.edit("gap = -3.5", "gap = 1e3\nlaw = \"coulomb\"")
    with h5py.File(case.path.parent / "model.h5", "r+") as file:
        file["K/data"][...] = file["K/data"][...] * -1


@pytest.mark.parametrize("spoil, ranks", [(without_mass, 2), (without_force, None), (without_hold, None),
                                          *(pytest.param(*other, marks=pytest.mark.slow) for other in
                                            ((without_mass, None), (without_force, 2), (without_hold, 2)))])
def test_run_that_is_refused_leaves_the_one_before(copy, spoil, ranks):
    folder = copy.path.parent / "out"
    before = contents(folder)
    spoil(copy)
    run(copy, out="out", status=2, ranks=ranks)
    assert contents(folder) == before


@pytest.mark.parametrize("ranks", RANKS)
def test_run_without_a_first_point_leaves_the_one_before(copy, ranks):
    """Newton is hindered, and nothing else may be tried."""
    folder = copy.path.parent / "out"
    before = contents(folder)
    copy.path.write_text("recovery.strategies = []\n" + copy.path.read_text())
    done = run(copy, "-hb_snes_max_it", 1, "-hb_snes_atol", 0, out="out", status=3, ranks=ranks)
    assert "the results of the run before stay in" in done.err
    after = contents(folder)
    assert {name: after[name] for name in before} == before and "results.h5.partial" not in after


def test_killed_before_its_first_point_a_run_has_touched_nothing(tmp_path):
    case, _ = walking(tmp_path, omega=[8, 8.1], harmonics=20, samples=64)
    folder = run(case, out="out").folder
    before = contents(folder)
    case.edit("omega = [8, 8.1]", "omega = [15, 16]")  # where there is none, as half a minute's search finds with so many samples
    case.edit("samples = 64", f"samples = {2**17}")
    with going(case, out="out"):
        wait_for((folder / "results.h5.partial").exists, "the new file")
    after = contents(folder)
    assert {name: after[name] for name in before} == before
    done = run(case, "--restart", out="out", status=2)  # of the one before, and so it says
    assert "samples = 131072" in done.err and "began with 64" in done.err


def test_first_point_takes_the_place_of_the_results_before(copy):
    folder = copy.path.parent / "out"
    old = Results(folder / "results.h5")
    copy.edit("max_points = 20", "max_points = 3")
    done = run(copy, out="out")
    assert "cut off" not in done.out and len(old) == 20 and len(done.points["omega"]) == 3 and done.summary["points"] == 3
    assert sorted(path.name for path in folder.iterdir()) == ["reduced.h5", "results.h5", "state.h5", "summary.json"]


# --------------------------------------------------------------------------------------------- runs that were cut off
def older(folder):
    with h5py.File(folder / "state.h5", "r+") as file:
        file.attrs["version"] = 13


def lost(folder):
    (folder / "state.h5").unlink()


def damaged(folder):
    path = folder / "state.h5"
    path.write_bytes(path.read_bytes()[:700])


@pytest.mark.parametrize("spoil", [older, lost, damaged])
def test_beginning_anew_keeps_what_was_cut_off(tmp_path, spoil):
    """The advice where --restart is refused."""
    case = cases.dof5(tmp_path, **cases.ENDLESS, **SMALL)
    folder, count = cut_off(case, 50)
    spoil(folder)
    case.edit("max_points = 1000000", "max_points = 5")
    assert f"{folder}/state.h5: " in run(case, "--restart", out="out", status=2).err
    out = run(case, out="out").out
    assert f"cut off after {count} points" in out and "results.old.h5" in out
    assert len(Results(folder / "results.old.h5")) == count and len(Results(folder / "results.h5")) == 5


def test_cut_off_runs_of_other_problems_are_all_kept(tmp_path):
    case, counts = cases.dof5(tmp_path, **cases.ENDLESS, **SMALL), []
    for harmonics in (3, 4, 5):
        case.edit(f"harmonics = {max(3, harmonics - 1)}", f"harmonics = {harmonics}")
        folder, count = cut_off(case, 60 - 10 * harmonics)
        counts.append(count)
    case.edit("max_points = 1000000", "max_points = 5")
    run(case, out="out")
    kept = [Results(folder / name) for name in ("results.old.h5", "results.old.2.h5", "results.old.3.h5")]
    assert [(len(results), results.harmonics) for results in kept] == list(zip(counts, (3, 4, 5)))
    for name in ("results", "state"):
        (folder / f"{name}.old.2.h5").rename(folder / f"{name}.h5")
    case.edit("harmonics = 5", "harmonics = 4")
    case.edit("max_points = 5", f"max_points = {counts[1] + 5}")
    assert len(run(case, "--restart", out="out").points["omega"]) == counts[1] + 5


# ------------------------------------------------------------------------------------------------ what belongs together
@pytest.mark.parametrize("ranks", RANKS)
def test_results_and_state_of_two_runs_are_not_mixed(copy, ended, ranks):
    """The same case, run twice: nothing else tells them apart."""
    folder = copy.path.parent / "out"
    run(copy, out="again")
    shutil.copy(copy.path.parent / "again" / "results.h5", folder)
    copy.edit("max_points = 20", "max_points = 25")
    before = contents(folder)
    err = run(copy, "--restart", out="out", status=2, ranks=ranks).err
    assert "results.h5: belongs to another run than" in err and "state.h5" in err and err.count("dovetail:") == 1
    assert contents(folder) == before
    shutil.copy(ended.path.parent / "out" / "results.h5", folder)
    assert len(run(copy, "--restart", out="out", ranks=ranks).points["omega"]) == 25
    with h5py.File(folder / "results.h5") as results, h5py.File(folder / "state.h5") as state:
        assert results.attrs["run"] == state.attrs["run"] != ""


def test_results_of_another_version_are_refused(copy):
    results = copy.path.parent / "out" / "results.h5"
    shutil.copy(results, copy.path.parent / "start.h5")
    for path in (results, copy.path.parent / "start.h5"):
        with h5py.File(path, "r+") as file:
            file.attrs["version"] = 2
    with pytest.raises(ValueError, match="results.h5: version 2 of the results format; this package reads version 1"):
        Results(results)
    copy.edit("max_points = 20", "max_points = 25")
    assert "results.h5: attribute version is 2; this program reads version 1" in run(copy, "--restart", out="out", status=2).err
    copy.edit("max_points = 25", "max_points = 25\nstart = \"start.h5\"")
    assert "start.h5: attribute version is 2" in run(copy, out="new", status=2).err


@pytest.mark.parametrize("ranks", [None, pytest.param(2, marks=pytest.mark.slow)])
def test_reduced_file_that_was_changed_is_made_anew(copy, ranks):
    folder = copy.path.parent / "out"
    with h5py.File(folder / "reduced.h5", "r+") as file:
        before = {name: file[name][()] for name in ("Kaa", "Kxx", "Max")}
        fingerprint = file.attrs["fingerprint"]
        file["Kxx"][1, 1] *= 1 + 1e-9
    points = read_points(folder)
    done = run(copy, out="out", ranks=ranks)
    assert "reduced.h5 is not as it was written" in done.out and "still fits" not in done.out
    np.testing.assert_allclose(done.points["coefficients"], points["coefficients"], rtol=0, atol=1e-9)
    with h5py.File(folder / "reduced.h5") as file:
        for name, values in before.items():
            np.testing.assert_allclose(file[name][()], values, rtol=1e-12, atol=1e-14)
        fresh = file.attrs["fingerprint"]
    assert ranks or fresh == fingerprint
    assert "still fits the model, reused" in run(copy, out="out", ranks=ranks or 2).out  # the same on any number of ranks


def test_reduced_file_that_is_given_may_be_changed_and_this_is_told(copy):
    with h5py.File(copy.path.parent / "out" / "reduced.h5", "r+") as file:
        file["Kxx"][1, 1] *= 1 + 1e-9
    copy.edit('model = "model.h5"', 'reduced = "out/reduced.h5"')
    copy.edit("modes = 2", "")
    assert "reduced.h5: its numbers are not those that dovetail wrote" in run(copy, out="new").out


def test_fields_come_from_the_reduced_file_of_the_results(copy):
    """Another model comes, and its run finds no first point: the results of the one before keep their fields."""
    folder = copy.path.parent / "out"
    field = Results(folder / "results.h5").elastic(3)
    with h5py.File(copy.path.parent / "model.h5", "r+") as file:
        file["preload"][0] = 1.5
    copy.path.write_text("recovery.strategies = []\n" + copy.path.read_text())
    run(copy, "-hb_snes_max_it", 1, "-hb_snes_atol", 0, out="out", status=3)
    assert (folder / "reduced.old.h5").exists()
    np.testing.assert_array_equal(Results(folder / "results.h5").elastic(3), field)
    (folder / "reduced.old.h5").unlink()
    with pytest.raises(ValueError, match="reduced.h5: is not the one that .*results.h5 was computed with"):
        Results(folder / "results.h5").elastic(3)
    run(copy, out="out")
    assert Results(folder / "results.h5").elastic(3).shape == field.shape
    assert sorted(path.name for path in folder.iterdir()) == ["reduced.h5", "results.h5", "state.h5", "summary.json"]


@pytest.mark.parametrize("replaced, ranks", [(True, None), *(pytest.param(*other, marks=pytest.mark.slow) for other in
                                                            [(False, 2), (False, None), (True, 2)])])
def test_results_that_vanish_are_noticed_at_the_end(tmp_path, ranks, replaced):
    """Which the test brings about: a curve that ends by itself may have done so before the file is gone."""
    command, folder = line(cases.dof5(tmp_path, **cases.ENDLESS, **SMALL), out="out", ranks=ranks)
    with Watched(command) as watched:
        wait_for((folder / "results.h5").exists, "the first point")
        (folder / "results.h5").unlink()
        if replaced:
            (folder / "results.h5").write_text("mine")
        watched.process.send_signal(signal.SIGUSR1)  # mpirun passes it on
        assert watched.process.wait(SECONDS) == 3
    assert watched.said.count("results.h5: is not the file of this run any more") == 1
    assert json.loads((folder / "summary.json").read_text())["end"] == "failed"
    assert not replaced or (folder / "results.h5").read_text() == "mine"


# -------------------------------------------------------------------------------------------------- files of others
OURS = ("results.h5", "state.h5", "reduced.h5", "summary.json", "results.h5.partial", "state.h5.partial", "reduced.h5.partial",
        "status.json", "status.json.partial")


@pytest.mark.parametrize("name, what", [  # every file in one way, and one file in every way, are quick
    pytest.param(name, what, marks=() if name == OURS[0] or what == "text" else pytest.mark.slow)
    for name in OURS for what in ("text", "link", "dangling", "folder")])
def test_files_of_others_are_left_alone(ended, tmp_path, name, what):
    case = ended.copied(tmp_path / "copy", without=["out"])
    folder, target = tmp_path / "copy" / "out", tmp_path / "elsewhere.h5"
    folder.mkdir()
    target.write_text("years of work")
    if what == "text":
        (folder / name).write_text("years of work")
    elif what == "folder":
        (folder / name).mkdir()
    else:
        (folder / name).symlink_to(target if what == "link" else tmp_path / "nowhere")
    for options in ([], ["--dry-run"]):
        err = run(case, *options, out="out", status=2, ranks=2 if what == "link" else None).err
        assert f"--out: output.directory = {folder}: {name} there" in err and "move it away" in err and err.count("dovetail:") == 1
    assert target.read_text() == "years of work" and [path.name for path in folder.iterdir()] == [name]
    assert what != "text" or (folder / name).read_text() == "years of work"


def test_models_under_the_names_of_results_are_left_alone(copy):
    folder, model = copy.path.parent / "out", (copy.path.parent / "model.h5").read_bytes()
    for name in ("results.h5", "state.h5"):
        kept = (folder / name).read_bytes()
        (folder / name).write_bytes(model)
        err = run(copy, out="out", status=2).err
        assert f"{name} there was not written by dovetail" in err and (folder / name).read_bytes() == model
        (folder / name).write_bytes(kept)


@pytest.mark.parametrize("key", ["model", "start"])
@pytest.mark.parametrize("name", ["state.h5", "stuck.h5", "results.h5.partial", "results.h5"])
def test_what_a_run_reads_it_does_not_write(copy, key, name):
    source = copy.path.parent / ("model.h5" if key == "model" else "out/results.h5")
    folder = copy.path.parent / "new"
    folder.mkdir()
    shutil.copy(source, folder / name)
    if key == "model":
        copy.edit('model = "model.h5"', f'model = "new/{name}"')
    else:
        copy.edit("max_points = 20", f'max_points = 20\nstart = "new/{name}"')
    err = run(copy, out="new", status=2).err
    assert "case.toml:" in err and f"would overwrite this file with its own {name}" in err
    assert (folder / name).read_bytes() == source.read_bytes()


def test_import_replaces_models_only(tmp_path, capsys):
    rows = {"omega_a2": "4", "Max": "0,0,0", "Mxx": "1,0,0\n0,1,0\n0,0,1", "Kxx": "2,0,0\n0,2,0\n0,0,2", "fa": "1", "fx": "0,0,0",
            "Rx": "0,0,-1"}
    source = tmp_path / "a.csv"
    source.write_text("".join(f"Name: {name}\n{values}\n\n" for name, values in rows.items()))
    command = ["import", "csv", str(source), "-o"]
    for _ in range(2):
        assert main([*command, str(tmp_path / "m.h5")]) == 0
    (tmp_path / "m.h5.part").write_bytes(b"")
    assert main([*command, str(tmp_path / "m.h5")]) == 0
    (tmp_path / "notes.txt").write_text("years of work")
    (tmp_path / "link.h5").symlink_to(tmp_path / "notes.txt")
    (tmp_path / "n.h5.part").symlink_to(tmp_path / "notes.txt")
    capsys.readouterr()
    for name, found in (("notes.txt", "no file that dovetail wrote"), ("link.h5", "a symbolic link"), ("n.h5", "a symbolic link"),
                        ("a.csv", "no file that dovetail wrote")):
        assert main([*command, str(tmp_path / name)]) == 2
        err = capsys.readouterr().err
        assert name in err and f"is {found}" in err and "move it away" in err
    assert (tmp_path / "notes.txt").read_text() == "years of work" and source.read_text().startswith("Name:")
