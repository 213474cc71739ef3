"""Runs that are cut off: nothing computed is lost, at whatever moment, and --restart gives what an uninterrupted run gives.

DOVETAIL_KILLS=50 kills that often instead of a few times.
"""

import io
import os
import random
import subprocess
import time

import h5py
import numpy as np
import pytest
import write_log

import cases
from launch import BINARY, SECONDS, SURROUNDINGS, kill, line, run, tables
from on_terminal import Watched

KILLS = int(os.environ.get("DOVETAIL_KILLS", 0))


def load(path):
    """Tables of points and of events, by name, as any user would read them."""
    with h5py.File(path, "r") as file:
        return ({name: values[()] for name, values in tables(file).items()},
                {name: values[()] for name, values in file["events"].items()}, int(file.attrs["harmonics"]))


def check_moment(path, final, events, complete, block):
    """Whatever is there is right, `block` points at most are on their way. Returns how many points there are."""
    found, found_events, harmonics = load(path)
    count = len(found["omega"])
    assert complete <= count <= complete + block and found.keys() == final.keys()
    for name, values in found.items():
        assert count <= len(values) <= count + block, name
        wanted = final[name][:count]
        if name == "coefficients":
            assert 2 * harmonics + 1 <= values.shape[2]
            wanted = wanted[:, :, :values.shape[2]]
        np.testing.assert_array_equal(values[:count], wanted, name)
    count_events = len(found_events["omega"])
    for name, values in found_events.items():
        np.testing.assert_array_equal(values[:count_events], events[name][:count_events])
    return count


@pytest.fixture(scope="module")
def shim(tmp_path_factory):
    return write_log.shim(tmp_path_factory.mktemp("shim"))


def noted(shim, log, command, tick=1e-4):
    """The command, run beneath a clock that goes on by `tick` [s] with every look."""
    log.unlink(missing_ok=True)
    surroundings = SURROUNDINGS | {"LD_PRELOAD": str(shim), "WRITE_LOG": str(log), "TICK": str(tick)}
    done = subprocess.run(command, env=surroundings, capture_output=True, text=True, timeout=SECONDS)
    assert done.returncode == 0, done.stdout + done.stderr
    return done


@pytest.mark.slow
@pytest.mark.parametrize("tick, block", [(0.1, 3), (1e-4, 12)], ids=["slow points", "quick points"])
def test_file_is_good_after_every_single_write(shim, tmp_path, tick, block):
    """And in the middle of it; both while a run goes on and while a restart takes over what was there.

    Points that take long are written at once, with those that were located on the way; quick ones some together."""
    case = cases.several_points(tmp_path, harmonics=3, samples=32, max_points=12, at=[0.81, 0.82, 0.83, 0.84])
    log, copy = tmp_path / "log", tmp_path / "played_back.h5"
    command, folder = line(case, out="out")
    complete, together = 0, []
    for options in ([], ["--restart"]):
        noted(shim, log, [*command, *options], tick)
        final, events, _ = load(folder / "results.h5")
        seen = 0
        for seen, _ in enumerate(write_log.moments(log, copy)):
            before, complete = complete, check_moment(copy, final, events, complete, block)
            together += [complete - before] * (complete > before)
        assert copy.read_bytes() == (folder / "results.h5").read_bytes()  # so no write went by unnoticed
        assert complete == len(final["omega"]) and seen > 30  # writes to some 30 tables, of all points but the first
        complete = 12  # those of the first part: the next one gives the file its name
        case.path.write_text(case.path.read_text().replace("max_points = 12", "max_points = 18"))
    assert sum(together) == 18 and (len(together) >= 9 if block == 3 else max(together) > 1)


@pytest.mark.slow
def test_state_counts_no_point_that_results_lack(shim, tmp_path):
    """At the moment when it takes its name; states that are saved amid quick points, which are written some together. And the file, of
    some megabytes, is given its space in a few large steps: a reader that meets one finds the file cut off."""
    case = cases.dof5(tmp_path, harmonics=3, samples=32, adaptive=False, step=0.0001, max_points=20000)
    log, copy = tmp_path / "log", tmp_path / "played_back.h5"
    noted(shim, log, line(case, out="out")[0])
    counts = []
    for state in write_log.states(log, copy):
        with h5py.File(io.BytesIO(state)) as file:
            counts.append((int(file.attrs["count_points"]), int(file.attrs["events"])))
        points, events, _ = load(copy)
        assert len(points["omega"]) >= counts[-1][0] and len(events["omega"]) >= counts[-1][1]
    assert len(counts) >= 3 and counts[-1][0] == 20000
    assert 1 < sum(kind == "G" for kind, *_ in write_log.notes(log)) < 30


@pytest.mark.slow
def test_index_of_a_long_table_is_good_after_every_single_write(shim, tmp_path):
    """With a chunk to each row: nodes of the index are split. The rows are those of tests/unit/test_growing_file.cpp."""
    tests = BINARY.parent / "tests" / "unit" / "unit_tests"
    if not tests.exists():
        pytest.skip("the unit tests are not built")
    log, copy = tmp_path / "log", tmp_path / "played_back.h5"
    noted(shim, log, ["env", f"TMPDIR={tmp_path}", str(tests), "--gtest_filter=GrowingFile.IndexGrowsOverItsNodes"])
    complete = splits = 0
    for kind, offset, size, data in write_log.notes(log):
        splits += kind == "W" and data[:4] == b"TREE" and data[5] == 1
    assert splits >= 40  # so often an upper node of the index was written
    for _ in write_log.moments(log, copy):
        with h5py.File(copy, "r") as file:
            values, count = file["points/coefficients"][()], len(file["points/omega"])
        assert complete <= count <= len(values) <= count + 1
        complete = count
        np.testing.assert_array_equal(values[:count].reshape(count, 6), 1000.0 * np.arange(count)[:, None] + np.arange(1, 7))
    assert complete == 150


def same(found, wanted, rows=slice(None)):
    """To 1e-8 of the largest; the residual, which is round-off, is as small."""
    assert found.keys() == wanted.keys()
    for name in wanted.keys() - {"seconds", "residual"}:
        scale = np.nanmax(np.abs(wanted[name]), initial=1e-300)
        accuracy = 1e-3 if name.startswith("error_") else 1e-8  # estimates come from linear solves in single precision
        np.testing.assert_allclose(found[name][rows], wanted[name][rows], rtol=0, atol=accuracy * scale, err_msg=name)


@pytest.mark.slow
@pytest.mark.parametrize("ranks, kills", [(None, KILLS or 4), (2, KILLS // 5 or 2)])
def test_killed_again_and_again(tmp_path, ranks, kills):
    """Every point that was shown is in the file, and in the end there is the branch that was never cut off."""
    case = cases.several_points(tmp_path, at=[0.9, 1.1], omega=[0.8, 1.6 if KILLS else 1.15])
    whole = run(case, out="whole", ranks=ranks)
    points, events, _ = load(whole.folder / "results.h5")
    total, chance = len(points["omega"]), random.Random(kills)
    command, folder = line(case, out="cut", ranks=ranks)
    results, state = folder / "results.h5", folder / "state.h5"
    there, cut_off = 0, False
    for i in range(kills):
        going_on = ["--restart"] if state.exists() else []
        with Watched([*command, *going_on]) as watched:
            if i % 3 == 2:  # while it begins
                time.sleep(chance.uniform(0, 0.5))
            else:
                watched.wait_for_point(min(there + chance.randint(1, 1 + 2 * total // kills), total - 2))
                time.sleep(chance.uniform(0, 0.02))
            kill(watched.process)
        if results.exists():
            found = load(results)[0]
            there = len(found["omega"])
            assert there >= watched.last_point()
            same(found, points, slice(there))
            cut_off = cut_off or there < total and state.exists()  # not when the last points came before the signal
    done = run(case, "--restart", out="cut", ranks=ranks)
    same(done.points, points)
    same(load(results)[1], events)
    for name in ("end", "points", "peaks", "folds", "newton_iterations"):
        assert done.summary[name] == whole.summary[name], name
    assert len(done.summary["located"]["peaks"]) == done.summary["peaks"] > 0
    assert 1 + cut_off <= done.summary["parts"] <= kills + 1
