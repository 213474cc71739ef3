"""Runs and studies from a script: what they give, what they say where it goes wrong, and what is kept."""

import pathlib
import subprocess
import sys
import types

import h5py
import numpy as np
import pytest

import cases
import dovetail
from dovetail import studies
from dovetail.running import GivenCase
from dovetail.study_runs import Program
from launch import BINARY, SURROUNDINGS, words_of

SMALL = {"harmonics": 2, "omega": [1.0, 1.05], "step": 0.1}


@pytest.fixture(autouse=True)
def surroundings(monkeypatch):
    for name, value in SURROUNDINGS.items():
        monkeypatch.setenv(name, value)


@pytest.fixture
def case(tmp_path):
    return cases.dof5(tmp_path, **SMALL)


def run(case, **more):
    return dovetail.run(case, binary=BINARY, **more)


@pytest.mark.parametrize("ranks", [None, pytest.param(2, marks=pytest.mark.slow)])
def test_a_case_gives_its_results(case, ranks, tmp_path, capfd):
    results = run(case.path, ranks=ranks, out=tmp_path / "out")
    assert results.omega[[0, -1]].tolist() == [1.0, 1.05] and results.path == tmp_path / "out/results.h5"
    assert not any(capfd.readouterr())


def test_what_the_program_says_is_shown_on_request(case, capsys):
    results = run(str(case.path), progress=True)
    assert results.path.parent == case.path.parent and "Newton iterations" in capsys.readouterr().out


def test_changes_are_of_a_copy(case, tmp_path, monkeypatch):
    before = case.path.read_text()
    some = run(case.path, out=tmp_path / "a/b", **{"contact.friction": np.array([0.5, 0.25]), "harmonic_balance.harmonics": 3})
    assert some.contact["friction"].tolist() == [[0.5, 0.25]] and some.harmonics == 3 and case.path.read_text() == before
    monkeypatch.chdir(tmp_path)  # where the files of a dict are named from
    given = cases_content(case)
    again = run(given, out="c", **{"contact.friction": [0.5, 0.25], "harmonic_balance.harmonics": 3})
    np.testing.assert_array_equal(again.coefficients, some.coefficients)
    assert given == cases_content(case)


def test_none_leaves_a_key_or_a_section_out(case, tmp_path):
    without = GivenCase(case.path, {"harmonic_balance.harmonics": None, "stability": None, "accuracy.tolerance": None}).content
    expected = cases_content(case)
    del expected["harmonic_balance"]["harmonics"]
    expected.pop("stability", None)
    assert {name: section for name, section in without.items() if section != {}} == expected
    assert "harmonics" in cases_content(case)["harmonic_balance"]
    few = dovetail.Study(case.path, {"continuation.max_points": [None, 2]}, out=tmp_path / "runs", binary=BINARY).run(progress=False)
    all_of_them, two = few.columns()["points"]
    assert two == 2 < all_of_them


def cases_content(case):
    import tomllib

    return tomllib.loads(case.path.read_text())


def test_failures_carry_message_and_status(case, tmp_path):
    with pytest.raises(dovetail.RunFailed, match="contact.friktion") as raised:
        run(case.path, out=tmp_path / "a", **{"contact.friktion": 1.0})
    assert raised.value.status == 2
    with pytest.raises(dovetail.RunFailed, match="first frequency.*first\\.$") as raised:
        run(case.path, out=tmp_path / "b", **{"recovery.strategies": [], "newton.max_iterations": 1, "newton.residual_tolerance": 1e-300})
    assert raised.value.status == 3


def test_what_cannot_be_started_is_said(case, tmp_path, monkeypatch):
    with pytest.raises(ValueError, match="out="):
        run(case.path, **{"contact.friction": 0.5})
    with pytest.raises(ValueError, match="was not written here"):
        run(case.path, out=tmp_path, **{"contact.friction": 0.5})
    with pytest.raises(ValueError, match="ranks"):
        run(case.path, ranks=0)
    with pytest.raises(ValueError, match="no program"):
        dovetail.run(case.path, binary=tmp_path / "nothing")
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "2")
    with pytest.raises(ValueError, match="ranks=4"):
        run(case.path)


@pytest.mark.slow
def test_a_script_under_mpirun_is_told(case, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(f"import dovetail\ntry:\n    dovetail.run({str(case.path)!r})\nexcept ValueError as error:\n    print(error)\n")
    out, _ = words_of(["mpirun", "-n", "2", sys.executable, str(script)])
    assert out.count("itself started by mpirun") == 2 and not (tmp_path / "results.h5").exists()


# ------------------------------------------------------------------------------------------------------------- studies
GRID = {"contact.friction": [0.5, 1.0], "harmonic_balance.harmonics": [1, 2]}


def test_runs_on_several_ranks_do_not_share_a_folder_of_mpi(case, tmp_path, monkeypatch):
    monkeypatch.delenv("OMPI_MCA_orte_tmpdir_base")  # that of the tests
    binary = tmp_path / "tell"
    binary.write_text("#!/bin/sh\nls -d $OMPI_MCA_orte_tmpdir_base\n")
    binary.chmod(0o755)
    program = Program(binary, ranks=1)
    started = [program.start(case, subprocess.PIPE) for _ in range(2)]
    said = {process.communicate()[0].decode().strip() for process in started}
    assert len(said) == 2 and all(pathlib.Path(folder).is_dir() for folder in said)
    del program, started
    assert not any(pathlib.Path(folder).exists() for folder in said)


def test_a_study_has_a_row_per_setting_and_keeps_its_runs(case, monkeypatch, capsys):
    study = dovetail.Study(case.path, GRID, binary=BINARY)
    assert study.columns()["status"] == [None] * 4
    table = study.run(jobs=2).columns()
    assert table["contact.friction"] == [0.5, 0.5, 1.0, 1.0] and table["harmonic_balance.harmonics"] == [1, 2, 1, 2]
    assert table["status"] == [0] * 4 and "4 of 4" in capsys.readouterr().err
    for setting, results, peak in zip(study.settings, study.results, table["peak"]):
        assert results.contact["friction"][0, 0] == setting["contact.friction"]
        assert results.harmonics == setting["harmonic_balance.harmonics"] and peak == results.amplitude(results.watched).max()
    wider = dovetail.Study(case.path, {**GRID, "harmonic_balance.harmonics": [2, 1]}, binary=BINARY)
    monkeypatch.setattr(wider._program, "start", lambda *_: pytest.fail("was computed already"))
    assert wider.run().columns()["peak"] == [table["peak"][i] for i in (1, 0, 3, 2)]
    assert "4 of 4 runs are there" in capsys.readouterr().err


def test_another_case_is_another_run(case):
    first = dovetail.Study(case.path, {"contact.friction": [0.5]}, binary=BINARY)
    case.edit("harmonics = 2", "harmonics = 3")
    second = dovetail.Study(case.path, {"contact.friction": [0.5]}, binary=BINARY)
    assert first._runs[0].folder != second._runs[0].folder


def test_wrong_values_of_a_study_are_refused(case):
    with pytest.raises(ValueError, match="contact.friction = -1.*friction"):
        dovetail.Study(case.path, {"contact.friction": [-1.0]}, binary=BINARY).run(progress=False)
    with pytest.raises(ValueError, match="a list of values"):
        dovetail.Study(case.path, {"contact.friction": 0.5}, binary=BINARY)
    with pytest.raises(ValueError, match=r"values must be a dict with a list of values by key, found \[0.5\]"):
        dovetail.Study(case.path, [0.5], binary=BINARY)
    with pytest.raises(ValueError, match="makes 1000000 runs, more than 100000"):
        dovetail.Study(case.path, {"contact.friction": range(1000), "contact.gap": range(1000)}, binary=BINARY)
    for wrong in (0, 1.5, "2"):
        with pytest.raises(ValueError, match=f"jobs must be a whole number from 1 on, found {wrong!r}"):
            dovetail.Study(case.path, {"contact.friction": [0.5]}, binary=BINARY).run(jobs=wrong)
        with pytest.raises(ValueError, match=f"ranks must be a whole number from 1 on, found {wrong!r}"):
            dovetail.Study(case.path, {"contact.friction": [0.5]}, ranks=wrong, binary=BINARY)
        with pytest.raises(ValueError, match=f"ranks must be a whole number from 1 on, found {wrong!r}"):
            dovetail.run(case.path, ranks=wrong, binary=BINARY)
    with pytest.raises(ValueError, match="no key"):
        dovetail.Study(case.path, {"contact.friction.static": [0.5]}, binary=BINARY)


def test_files_among_the_values_are_named_from_the_case_and_read_anew(case, monkeypatch):
    name, = cases_content(case).keys() & {"model", "reduced"}
    stored = case.path.parent / cases_content(case)[name]
    other = case.path.with_name("other.h5")
    other.write_bytes(stored.read_bytes())
    monkeypatch.chdir(case.path.parents[1])  # no file of the case lies there
    for value in ("other.h5", pathlib.Path("other.h5"), other):
        study = dovetail.Study(case.path, {name: [value]}, binary=BINARY)
        assert study._runs[0].folder.parent == case.path.with_name("case_runs")
        assert study.run(progress=False).columns()["status"] == [0]
    before = study._runs[0].fingerprint
    with h5py.File(other, "r+") as file:
        file.attrs["note"] = "another file under the same name"
    assert dovetail.Study(case.path, {name: ["other.h5"]}, binary=BINARY)._runs[0].fingerprint != before


def test_values_that_no_case_holds_are_refused_by_key(case, tmp_path):
    for key, value, words in (("contact.friction", [None], "contact.friction: .*None"),
                              ("newton.step_tolerance", np.inf, "newton.step.*inf"), ("contact.gap", [0.0, np.nan], "contact.gap: .*nan"),
                              ("contact", {"friction": 0.5}, "such as contact.friction"), ("title.a", 1, "title.a: no key")):
        with pytest.raises(ValueError, match=words):
            run(case.path, out=tmp_path / "a", **{key: value})
    assert not (tmp_path / "a").exists()
    text = GivenCase(case.path, {"contact.friction": [np.float64(0.5), np.int64(1)], "contact.gap": np.zeros(2)}).text(tmp_path)
    assert "friction = [0.5, 1]" in text and "gap = [0.0, 0.0]" in text


def test_a_run_that_could_not_go_on_is_a_row(case):
    study = dovetail.Study(case.path, {"newton.max_iterations": [1, 50]}, binary=BINARY)
    for run_, status in zip(study._runs, (3, 0)):
        run_.status, run_.reason = status, "Newton gave up" if status else ""
    study._runs[1].status = None  # not done
    table = study.columns()
    assert table["status"] == [3, None] and table["reason"][0] == "Newton gave up" and table["peak"] == [None, None]


# -------------------------------------------------------------------------------------------------------------- tables
def test_tables_have_a_row_per_point(case, monkeypatch):
    results = run(case.path)
    table = results.columns(["x1.t1", "x1.n"])
    assert {"omega", "frequency", "x1.t1", "x1.n", "stick", "slip", "open", "friction_energy"} <= set(table)
    assert {len(values) for values in table.values()} == {len(results)}
    np.testing.assert_array_equal(table["x1.n"], results.amplitude("x1.n"))
    np.testing.assert_array_equal(results.columns("x1.n")["x1.n"], table["x1.n"])
    activity = results.contact_activity()
    assert activity.slip.shape == (len(results), 1) and activity.slip[3] == results.contact_activity(3).slip
    np.testing.assert_array_equal(results.amplitude(), results.amplitude(results.watched))
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="python3-pandas"):
        results.to_frame()
    monkeypatch.setitem(sys.modules, "pandas", types.SimpleNamespace(DataFrame=lambda columns: ("frame", columns)))
    assert results.to_frame()[0] == "frame" and studies.frame({"a": [1]}) == ("frame", {"a": [1]})
