"""The command `watch` and status.json: a run seen from outside, and what is left of it when it ends."""

import json

import numpy as np
import pytest

import cases
import synthetic_results
from dovetail.__main__ import main
from dovetail.text_plot import text_plot
from launch import BINARY, going, held, line, run, wait_for
from on_terminal import Watched
from test_runs import walking


def once(folder, capsys, *options, status=0):
    assert main(["watch", folder, "--once", *options]) == status
    return capsys.readouterr()


@pytest.mark.parametrize("ranks", [None, pytest.param(2, marks=pytest.mark.slow)])
def test_a_run_says_how_far_it_is(tmp_path, capsys, ranks):
    with going(cases.dof5(tmp_path, harmonics=3, samples=32, **cases.ENDLESS), out="out", ranks=ranks) as (_, folder):
        status = folder / "status.json"
        wait_for(lambda: status.exists() and "points" in json.loads(status.read_text()), "a point")
        found = json.loads(status.read_text())
        assert found["state"] == "following" and found["over"] == "frequency" and (found["from"], found["to"]) == (0.9, 1.3)
        assert 0.9 <= found["omega"] == found["value"] <= 1.3 and 0 <= found["done"] < 1 and found["seconds"] >= 0
        wait_for(lambda: json.loads(status.read_text())["points"] > found["points"], "another second")
        said = once(folder, capsys).out
        assert "following" in said and "*" in said and "stick" in said and "[" in said
    assert "ended (broken off)" in once(folder, capsys).out  # killed: status.json is old
    case = cases.dof5(tmp_path, harmonics=3, samples=32)
    run(case, out="out", ranks=ranks)  # and in nobody's way
    assert not list(folder.glob("status.json*"))
    assert "ended (arrived)" in once(folder / "results.h5", capsys).out


def test_states_before_the_first_point(tmp_path, capsys):
    case, _ = walking(tmp_path, omega=[15, 16], harmonics=20, samples=2**17)  # there is none, as half a minute's search finds
    with going(case, out="out") as (process, folder):
        wait_for((folder / "status.json").exists, "a state")
        wait_for(lambda: json.loads((folder / "status.json").read_text())["state"] == "following", "the last of them")
        with held(process):
            assert "no point yet" in once(folder, capsys).out


def test_a_status_file_of_others_is_left_alone(tmp_path):
    case = cases.dof5(tmp_path, harmonics=3, samples=32)
    (tmp_path / "out").mkdir()
    (tmp_path / "out/status.json").write_text('{"mine": 1}')
    assert "status.json there was not written by dovetail" in run(case, out="out", status=2).err
    assert (tmp_path / "out/status.json").read_text() == '{"mine": 1}'


def test_watching_ends_with_the_run(tmp_path):
    import sys

    command, folder = line(cases.dof5(tmp_path, harmonics=3, samples=32), out="out")
    assert str(BINARY) in command
    run(cases.dof5(tmp_path, harmonics=3, samples=32), out="out")
    with Watched([sys.executable, "-m", "dovetail", "watch", str(folder)]) as watched:
        wait_for(lambda: watched.process.poll() is not None, "the end")
        assert watched.process.returncode == 0 and "ended (arrived)" in watched.said and watched.said.count("\x1b[J") == 1


def test_folders_without_a_run_are_refused(tmp_path, capsys):
    assert "no run goes on" in once(tmp_path, capsys, status=2).err
    contact = {"normal_stiffness": np.ones(1), "tangential_stiffness": np.ones((1, 2)), "friction": np.ones((1, 2)), "gap": np.zeros(1)}
    synthetic_results.write(tmp_path / "results.h5", [1.0, 2.0], np.ones((2, 4, 3)), 1, contact)
    assert "ended (broken off), 2 points" in once(tmp_path, capsys).out
    assert main(["watch", str(tmp_path)]) == 2 and "no terminal" in capsys.readouterr().err


def test_a_text_plot_is_the_curve():
    x = np.linspace(0, 10, 11)
    lines = text_plot(x, x, width=34, height=13, labels=("over", "what"))
    rows = [line.split("|")[1] for line in lines if "|" in line]
    assert len(rows) == 10 and rows[0].rstrip()[-1] == "@" and "10 |" in lines[1]
    columns = [row.find("*") for row in rows[1:]]
    assert columns == sorted(columns, reverse=True) and columns[-1] == 0  # a straight line upwards
    broken = text_plot(x, x, width=34, height=13, jumps=[4])
    assert sum(line.count("*") for line in broken) < sum(line.count("*") for line in lines)
    assert max(map(len, lines)) <= 34 and text_plot(np.ones(1), np.zeros(1))


def test_a_text_plot_leaves_out_what_is_not_finite():
    x = np.linspace(0, 10, 11)
    y = np.where(x == 4, np.nan, np.where(x == 10, np.inf, x))
    lines = text_plot(x, y, width=34, height=13)
    assert "9 |" in lines[1] and "*" in "".join(lines) and "@" not in "".join(lines)
    assert text_plot(x, np.full(11, np.nan)) == ["  no finite number to draw"]
