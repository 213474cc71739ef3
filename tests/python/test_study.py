"""The command study: its numbers against ones computed here from the results files, what it keeps, and what it refuses."""

import json
import tomllib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import cases
from dovetail import Results, study, study_errors
from dovetail.__main__ import main
from dovetail.ranges_mode import follows_mode
from dovetail.study_picture import frontier
from dovetail.study_report import TARGETS
from dovetail.study_runs import CaseFile, Setting, UserCase, toml
from dovetail.units import parse
from launch import BINARY, ROOT

GRID = ["--harmonics", "1", "5", "--samples", "32", "exact", "--tolerances", "1e-2", "1e-3", "--binary", str(BINARY)]
SHORT = {"omega": [1.0, 1.06], "kind": "auto", "harmonics": 3, "samples": 64, **cases.TIGHT}
FOLDERS = [f"{setting}_2modes_modal" for setting in ("H1_N32", "H1_exact", "H5_N32", "H5_exact", "tolerance0.01", "tolerance0.001")]
REFERENCE = "reference_H10_exact_2modes_modal"


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A finished study, not to be changed by a test: its folder and study.json."""
    folder = tmp_path_factory.mktemp("study")
    case = cases.dof5(folder, **SHORT, at=[1.0123])
    assert main(["study", str(case.path), *GRID]) == 0
    out = folder / "case_study"
    return out, json.loads((out / "study.json").read_text())


@pytest.fixture(autouse=True)
def undrawn(monkeypatch):
    """One drawn chart, that of `done`, is enough: drawing takes longer than the runs."""
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", lambda *_: None)


def times(out):
    """When each results file was written."""
    return {path.parent.name: path.stat().st_mtime_ns for path in out.glob("*/results.h5")}


def by_hand(out, folder, dof, frequencies):
    """Peak (omega, amplitude), and at the frequencies amplitude and dissipation, (m, 2); the branch passes each once."""
    results = Results(out / folder / "results.h5")
    theta = 2 * np.pi * np.arange(20000) / 20000
    c = results.coefficients[:, results.dof_index(dof)]
    k = np.arange(1, results.harmonics + 1)
    q = c[:, 1::2] @ np.cos(np.outer(k, theta)) + c[:, 2::2] @ np.sin(np.outer(k, theta))
    amplitude = np.ptp(q, axis=1) / 2
    at = [int(np.argmin(np.abs(results.omega - omega))) for omega in frequencies]
    np.testing.assert_allclose(results.omega[at], frequencies, rtol=1e-9)
    top = np.argmax(amplitude)
    return (results.omega[top], amplitude[top]), np.array([(amplitude[i], results.dissipated(i, 1)) for i in at])


# --------------------------------------------------------------------------------------------------------- what it finds
@pytest.mark.slow
def test_leaves_table_numbers_and_chart(done):
    out, found = done
    assert {path.name for path in out.iterdir()} == {*FOLDERS, REFERENCE, "study.json", "study.txt", "study.png"}
    assert (out / "study.png").read_bytes().startswith(b"\x89PNG")
    table = (out / "study.txt").read_text()
    assert f"half its harmonics are {study_errors.largest(found['runs'][3]['errors']):.1e} from it" in table
    assert all(str(label) in table for label in ("H 1, N 32, 2 modes, modal", "H 5, exact, 2 modes, modal", "reference: H 10, exact"))
    assert [run["folder"] for run in found["runs"]] == FOLDERS
    assert all(run["points"] > 40 and run["seconds_per_point"] > 0 and not run["reason"] for run in found["runs"])
    assert len(found["frequencies"]) == 41 and 1.0123 in found["frequencies"]


@pytest.mark.slow
def test_errors_are_those_of_the_results_files(done):
    out, found = done
    dof, frequencies = found["watched"], found["frequencies"]
    (omega, amplitude), wanted = by_hand(out, REFERENCE, dof, frequencies)
    assert found["reference"]["peak_amplitude"] == pytest.approx(amplitude, rel=1e-7)
    for run in found["runs"]:
        (at, top), points = by_hand(out, run["folder"], dof, frequencies)
        rms = np.sqrt(np.mean((points - wanted) ** 2, axis=0))
        expected = {"amplitude": abs(top / amplitude - 1), "frequency": abs(at / omega - 1), "curve": rms[0] / amplitude,
                    "dissipation": rms[1] / wanted[:, 1].max()}
        assert run["errors"] == pytest.approx(expected, rel=1e-3, abs=2e-7)  # amplitudes here are of samples


def test_errors_fall_with_harmonics_and_with_exact_forces(done):
    errors = {run["folder"]: run["errors"] for run in done[1]["runs"]}
    one, sampled, exact = (errors[folder] for folder in (FOLDERS[1], FOLDERS[2], FOLDERS[3]))
    assert all(exact[kind] < one[kind] / 5 for kind in study_errors.KINDS)
    assert all(exact[kind] < sampled[kind] for kind in study_errors.KINDS)


def test_names_the_cheapest_setting_for_an_error(done):
    out, found = done
    cost = {run["folder"]: (study_errors.largest(run["errors"]), run["seconds_per_point"]) for run in found["runs"]}
    for target in TARGETS:
        good = {folder: seconds for folder, (error, seconds) in cost.items() if error <= target}
        chosen = found["cheapest"][f"{target:g}"]
        assert (chosen is None) == (not good)
        if good and not min(good, key=good.get).startswith("tolerance"):
            best = next(run["setting"] for run in found["runs"] if run["folder"] == min(good, key=good.get))
            assert chosen == best
            assert f"[harmonic_balance]\nharmonics = {best['harmonics']}\nsamples = {json.dumps(best['samples'])}\n" in (
                out / "study.txt").read_text() + "\n"


def test_runs_by_tolerance(done):
    """They keep it, stand in the table beside the cheapest fixed setting that is as good, and have harmonics of their own choice."""
    out, found = done
    table, most = (out / "study.txt").read_text(), []
    for run, tolerance in zip(found["runs"][4:], (1e-2, 1e-3)):
        assert run["setting"]["tolerance"] == tolerance and run["setting"]["harmonics"] is None
        assert study_errors.largest(run["errors"]) < tolerance
        most.append(Results(out / run["folder"] / "results.h5").points("harmonics").max())
        assert f"# tolerance {tolerance:g}, 2 modes, modal: largest error" in table and "times H " in table
        copy = tomllib.loads((out / run["folder"] / "case.toml").read_text())
        assert copy["accuracy"] == {"tolerance": tolerance} and copy["harmonic_balance"] == {"solver": "modal"}
    assert 1 <= most[0] < most[1] <= 10


@pytest.mark.slow
def test_a_run_finer_than_the_reference_is_not_judged_by_it(tmp_path, capsys):
    case = cases.dof5(tmp_path, **SHORT)
    command = ["study", str(case.path), "--harmonics", "1", "--samples", "exact", "--tolerances", "1e-2", "1e-5", "--binary", str(BINARY)]
    assert main(command) == 0
    fixed, coarse, fine = json.loads((tmp_path / "case_study/study.json").read_text())["runs"]
    used = Results(tmp_path / "case_study" / fine["folder"] / "results.h5").points("harmonics").max()
    assert used > 10 and not fixed["finer"] and not coarse["finer"] and fine["finer"]
    said = capsys.readouterr().out
    assert f"up to {used} harmonics, more than the reference" in said
    judged = {line.split(",")[0]: line for line in said.splitlines() if line.startswith("# tolerance")}
    assert "times H 1" in judged["# tolerance 0.01"] and "not to be judged by a reference of 10" in judged["# tolerance 1e-05"]


def test_runs_are_lean_copies_of_the_case(done):
    out, found = done
    own = tomllib.loads((out.parent / "case.toml").read_text())
    copy = tomllib.loads((out / FOLDERS[0] / "case.toml").read_text())
    assert copy.pop("output") == {"motion": []} and copy.pop("stability") == {"enabled": False}
    assert copy.pop("accuracy") == {"estimates": False}
    assert copy["continuation"].pop("watch") == found["watched"]
    assert copy["continuation"].pop("at") == found["frequencies"]
    assert copy.pop("harmonic_balance") == {"harmonics": 1, "samples": 32, "solver": "modal"}
    assert (out / FOLDERS[0] / copy.pop("model")).resolve() == out.parent / "model.h5"
    del own["model"], own["harmonic_balance"], own["continuation"]["at"]
    assert copy == own


# ------------------------------------------------------------------------------------------------------- what it compares
def test_folds_are_compared_pass_by_pass():
    def curve(*passes):
        return study_errors.Curve((2.0, 10.0), [np.reshape(rows, (-1, 2)) for rows in passes])

    reference = curve([[2, 0.5], [9, 4], [5, 1]], [[3, 2]], [])
    assert set(study_errors.errors(reference, reference).values()) == {0.0}
    found = study_errors.errors(curve([[8, 3], [5, 1], [2, 0.5]], [], [[7, 7]]), reference)
    assert found["curve"] == pytest.approx(np.sqrt((1 + 9) / 4) / 10)  # 9 against 8; and a frequency without solution counts whole
    assert found["dissipation"] == pytest.approx(np.sqrt((1 + 4) / 4) / 4)
    assert study_errors.missed(curve([[8, 3]], [], [[7, 7]]), reference) == 1
    stuck = curve([[2, 0.0]])
    assert study_errors.errors(stuck, stuck) == {"amplitude": 0, "frequency": 0, "curve": 0, "dissipation": None}


@pytest.mark.parametrize("units, seconds", [("SI", 1.0), ("kg, m, ms", 1e-3)])
def test_frequencies_in_hertz_are_compared_as_results_have_them(tmp_path, units, seconds):
    case = UserCase(cases.dof5(tmp_path, omega=[0.2, 0.3], at=[0.25], unit="Hz").path)
    found = case.compared(SimpleNamespace(unit=parse(units)))
    np.testing.assert_allclose(found, 2 * np.pi * seconds * np.array(case.frequencies), rtol=1e-14)
    assert 'unit = "Hz"' in case.changed(Setting(3, "exact", 2, "modal"), tmp_path) and 0.25 in case.frequencies


def test_what_a_study_does_not_compare(tmp_path):
    case = cases.dof5(tmp_path)
    text = case.path.read_text()
    case.path.write_text(text + '\n[sensitivity]\nof = "a1"\n')
    assert "sensitivity" not in UserCase(case.path).changed(Setting(3, "exact", 2, "modal"), tmp_path)
    case.path.write_text(text + '\n[path]\nparameter = "friction"\n')
    with pytest.raises(ValueError, match="curves over the frequency are wanted"):
        UserCase(case.path)


def test_frequencies_follow_the_sweep(tmp_path):
    up = UserCase(cases.dof5(tmp_path, omega=[1.0, 1.5], at=[1.25]).path).frequencies
    down = UserCase(cases.dof5(tmp_path, omega=[1.5, 1.0], at=[1.25]).path).frequencies
    assert up == sorted(up) and len(up) == 41 and 1.25 in up and 1.0 < up[0] and up[-1] < 1.5
    np.testing.assert_allclose(down, up[::-1], rtol=1e-15)


def test_cases_survive_being_written():
    inputs = ("jenkins", "dof5", "damper", "two_solids", "blade_root", "blisk")
    for path in ["python/dovetail/template/case.toml", *(f"inputs/{name}/case.toml" for name in inputs)]:
        content = tomllib.loads((ROOT / path).read_text())
        assert tomllib.loads(toml(content)) == content
    odd = {"title": 'Träger "A"\\B 🙂', "contact": {"tangential_stiffness": [[1.0, 2e-30]], "law": ["cone"]},
           "continuation": {"adaptive": True},
           "excitation": {"load": [{"pattern": "up = {", "fourier": [0, 1]}, {"pattern": "down", "fourier": [0.5]}]}}
    assert tomllib.loads(toml(odd)) == odd


def test_frontier_is_what_nothing_beats():
    time, error = np.array([3.0, 1, 2, 2, 4]), np.array([0.1, 1, 0.5, 0.4, 0.2])
    assert frontier(time, error) == [1, 3, 0]


# ---------------------------------------------------------------------------------------------------- what it does again
@pytest.mark.slow
def test_nothing_is_computed_twice(done, capsys):
    out, found = done
    before = times(out)
    assert main(["study", str(out.parent / "case.toml"), *GRID]) == 0
    assert times(out) == before
    assert "6 of 6 runs are there" in capsys.readouterr().err
    assert json.loads((out / "study.json").read_text()) == found


@pytest.mark.slow
def test_broken_off_and_taken_up_again(tmp_path, capsys, monkeypatch):
    case = cases.dof5(tmp_path, **SHORT)
    out = tmp_path / "elsewhere"
    command = ["study", str(case.path), *GRID, "--out", str(out), "--jobs", "2"]
    with monkeypatch.context() as patched:
        patched.setattr(study.Progress, "tell", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        assert main(command) == 3
    assert "the same command goes on" in capsys.readouterr().err
    kept = [path.parent.name for path in out.glob("*/run.json")]
    before = times(out)
    assert REFERENCE in kept and 2 <= len(kept) < 7
    assert main(command) == 0
    assert f"{len(kept) - 1} of 6 runs are there" in capsys.readouterr().err
    after = times(out)
    assert all(after[name] == before[name] for name in kept) and len(after) == 7

    case.path.write_text(case.path.read_text().replace("stiffness = 0.05", "stiffness = 0.06"))  # another problem
    assert main([*command, "--harmonics", "5", "--samples", "exact"]) == 0
    assert all(times(out)[name] > after[name] for name in (REFERENCE, FOLDERS[3]))


@pytest.mark.slow
def test_a_setting_that_fails_is_told(tmp_path, capsys):
    case = cases.dof5(tmp_path, **SHORT)
    program = tmp_path / "program"
    program.write_text(f"""#!/bin/sh
if grep -q '^samples = 32' "$2"; then echo "dovetail: the sweep could not go on beyond 1.01 rad/s" >&2; exit 3; fi
exec "{BINARY}" "$@"
""")
    program.chmod(0o755)
    command = ["study", str(case.path), "--harmonics", "2", "--samples", "32", "exact", "--tolerances", "--binary", str(program)]
    for progress in ("1 of 2  H 2, N 32", "2 of 2 runs are there"):  # a failure is not tried again either
        assert main(command) == 0
        failed, good = json.loads((tmp_path / "case_study/study.json").read_text())["runs"]
        assert failed["errors"] is None and failed["reason"] == "the sweep could not go on beyond 1.01 rad/s" and good["errors"]
        said = capsys.readouterr()
        assert progress in said.err and "H 2, N 32, 2 modes, modal failed: the sweep could not go on" in " ".join(said.out.split())
    assert not list(tmp_path.glob("case_study/H2_N32*/results.h5"))


@pytest.mark.slow
def test_nothing_to_compare_with(tmp_path, capsys):
    case = cases.dof5(tmp_path, **{**SHORT, "step_tolerance": 1e-15, "residual_tolerance": 1e-15, "max_iterations": 2})
    assert main(["study", str(case.path), *GRID]) == 3
    assert "the reference, H 10, exact, 2 modes, modal, could not be computed" in capsys.readouterr().err


def test_a_case_without_modes(tmp_path, capsys):
    """As the Jenkins element, all of whose masses are contact points."""
    case = cases.dof5(tmp_path, **SHORT | {"modes": 0})
    assert main(["study", str(case.path), "--harmonics", "1", "--samples", "exact", "--tolerances", "--binary", str(BINARY)]) == 0
    assert "H 1, exact, 0 modes, modal" in capsys.readouterr().out


# -------------------------------------------------------------------------------------------------------- what it refuses
@pytest.mark.parametrize("options, overrides, words", [
    (["--harmonics", "0"], {}, "--harmonics 0: must be at least 1"),
    (["--harmonics", "9", "--samples", "8", "16"], {}, "--samples 16: 9 harmonics need at least 19"),
    (["--jobs", "0"], {}, "--jobs 0: must be at least 1"),
    (["--modes", "-1"], {}, "--modes -1: must be at least 0"),
    (["--modes", "3"], {}, "modes = 3"),  # of 2; by the program, before anything is computed
    (["--binary", "nowhere/dovetail"], {}, "nowhere/dovetail: is no program"),
    (["--tolerances", "2"], {}, "--tolerances 2.0: must lie between 0 and 1"),
    ([], {"omega": [1.0, 1.0]}, "needs a range"),
    ([], {"samples": 5}, "harmonic_balance.samples = 5 is too small"),
], ids=lambda value: " ".join(value) if isinstance(value, list) else "")
def test_wrong_input_is_refused(tmp_path, capsys, options, overrides, words):
    case = cases.dof5(tmp_path, **{**SHORT, **overrides})
    assert main(["study", str(case.path), *options]) == 2
    assert words in capsys.readouterr().err
    assert not list(tmp_path.glob("**/results.h5"))


@pytest.mark.slow
def test_modes_of_a_reduced_model_are_not_varied(tmp_path, capsys):
    case = cases.single_mass(tmp_path, 1, omega=[5, 5.3])
    assert main(["study", str(case.path), "--modes", "1"]) == 2
    assert "names a reduced model" in capsys.readouterr().err
    assert main(["study", str(case.path), "--harmonics", "2", "--samples", "exact"]) == 0
    assert "H 2, exact, modal" in capsys.readouterr().out


def test_words_that_are_no_options(tmp_path):
    for options in (["--samples", "some"], ["--solvers", "fast"], ["--harmonics", "1.5"]):
        with pytest.raises(SystemExit) as ended:
            main(["study", str(Path(tmp_path) / "case.toml"), *options])
        assert ended.value.code == 2


def test_a_mark_of_the_encoding_is_no_part_of_a_case(tmp_path):
    (tmp_path / "case.toml").write_bytes(b"\xef\xbb\xbf[mode]\nnumber = 1\n")
    assert CaseFile(tmp_path / "case.toml").content == {"mode": {"number": 1}}
    assert follows_mode(tmp_path / "case.toml")
