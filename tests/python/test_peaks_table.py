"""The command peaks: a table from one nonlinear mode, against sweeps of the program and against itself refined."""

import csv
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import cases
import launch
from dovetail import Results, reference
from dovetail.__main__ import main
from dovetail.modes import Backbone, Motion
from dovetail.peaks_table import activity, in_words, solved_peak, table
from dovetail.units import parse
from test_one_mode import made_up

FORCES = (0.1, 0.6)  # stuck; slipping
SETTINGS = {"harmonics": 3, "samples": "exact", "kind": "auto", **cases.TIGHT}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A run with [mode] of the example of five degrees of freedom."""
    folder = tmp_path_factory.mktemp("mode")
    case = cases.dof5(folder, omega=None, step=None, **SETTINGS)
    case.path.write_text(case.path.read_text() + '\n[continuation]\nwatch = "a1"\n[mode]\nnumber = 1\namplitude = [0.5, 25]\n')
    return launch.run(case).folder


def read(path):
    """Rows of a csv table, numbers by header."""
    with open(path) as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


@pytest.fixture(scope="module")
def sweeps(tmp_path_factory):
    """(amplitude, omega, slip, open, friction energy) at the peak of a sweep under each force."""
    found = []
    for force in FORCES:
        case = cases.dof5(tmp_path_factory.mktemp("sweep"), fourier=[0, 0, force], omega=[1.0, 1.1], **SETTINGS)
        case.edit("[continuation]", '[continuation]\nwatch = "a1"')
        results = Results(launch.run(case).folder / "results.h5")
        i = results.peak_point("a1")
        omega, amplitude = results.peak("a1")
        found.append((amplitude, omega, results.points("slip")[i], results.points("open")[i], results.dissipated(i, 1)))
    return found


@pytest.fixture(scope="module")
def tables(folder):
    """Rows as the mode gives them, and solved."""
    found = []
    for name, refine in (("plain", []), ("solved", ["--refine"])):
        out = folder / f"{name}.csv"
        assert main(["peaks", str(folder / "results.h5"), "--force", *map(str, FORCES), "-o", str(out), *refine]) == 0
        found.append(read(out))
    return found


@pytest.mark.parametrize("kind, close", [(0, 1.3e-2), (1, 1e-3)])
def test_peaks_are_those_of_sweeps(tables, sweeps, kind, close):
    """The frequency of a flat top is less sharp than its amplitude; samples move both."""
    for row, force, (amplitude, omega, slip, opened, energy) in zip(tables[kind], FORCES, sweeps, strict=True):
        assert row["force"] == force and row["separate"] == 0
        assert row["amplitude [m √kg]"] == pytest.approx(amplitude, rel=close)
        assert row["frequency [rad/s]"] == pytest.approx(omega, rel=3e-3)
        assert (row["slipping"], row["open"]) == (slip, opened)
        assert row["friction energy [J]"] == pytest.approx(energy, rel=3 * close, abs=1e-9)
    assert [slip for _, _, slip, _, _ in sweeps] == [0, 1]


def test_the_estimate_is_what_solving_changes(tables):
    for plain, solved in list(zip(*tables))[1:]:
        change = abs(plain["amplitude [m √kg]"] / solved["amplitude [m √kg]"] - 1)
        assert solved["error"] == pytest.approx(change, rel=1e-3) and 1e-4 < change < 1.3e-2
        assert plain["error"] == pytest.approx(change, rel=0.5, abs=1e-3)


def test_energies_balance_at_the_peak(folder):
    """What friction and structure dissipate in a period is what the load feeds."""
    backbone = Backbone.read(folder / "results.h5", 64)
    [(_, top)] = backbone.tops(0, 0.6)
    motion, system = solved_peak(backbone, top, 0), backbone.system
    k, q = np.arange(1, system.H + 1), motion.coefficients
    E = 0.6 * system.excitation
    fed = np.pi * np.sum(k * (E[:, 1::2] * q[:, 2::2] - E[:, 2::2] * q[:, 1::2]))
    damped = np.pi * motion.omega * sum(k[i] ** 2 * (q[:, c] @ system.C @ q[:, c]) for i in range(system.H) for c in (2 * i + 1, 2 * i + 2))
    friction = activity(backbone, motion)[2]
    assert fed == pytest.approx(damped + friction, rel=1e-6) and 0.1 * fed < friction < fed


def test_forces_where_none_are_given(folder, capsys):
    assert main(["peaks", str(folder / "results.h5"), "--hz"]) == 0
    rows = read(folder / "results_peaks.csv")
    forces = [row["force"] for row in rows]
    assert set(forces) >= {0.1, 0.2, 0.5, 1.0} and forces == sorted(forces)
    assert rows[0]["friction energy [J]"] < 1e-12 * rows[-1]["friction energy [J]"] and "frequency [Hz]" in rows[0]
    assert capsys.readouterr().out.startswith((folder / "results_peaks.txt").read_text())


def test_a_force_beyond_the_mode_is_named(folder, capsys):
    command = ["peaks", str(folder / "results.h5"), "-o", str(folder / "beyond.csv")]
    assert main([*command, "--force", "0.1", "50"]) == 0
    assert "under 50 times the load" in capsys.readouterr().out and len(read(folder / "beyond.csv")) == 1
    assert main([*command, "--force", "50"]) == 2
    assert "none of these forces has a peak on the mode" in capsys.readouterr().err
    assert len(read(folder / "beyond.csv")) == 1, "the table of before has gone"


def test_a_peak_that_cannot_be_solved_is_the_modes(folder, capsys, monkeypatch):
    solve = reference.HarmonicBalance.solve

    def fails(system, omega, q0):
        if np.abs(system.excitation[:, 1:]).max() > 0.3:
            raise RuntimeError("Newton's method did not converge in 60 iterations")
        return solve(system, omega, q0)
    monkeypatch.setattr(reference.HarmonicBalance, "solve", fails)
    command = ["peaks", str(folder / "results.h5"), "--dof", "a1", "--refine", "-o", str(folder / "unsolved.csv"), "--force"]
    assert main([*command, "0.1", "0.6"]) == 0
    out = capsys.readouterr().out
    assert "not solved, and as the mode has it" in out and "found near it under 0.6 times the load" in out
    first, second = read(folder / "unsolved.csv")
    [motion] = Backbone.read(folder / "results.h5").peaks(0.6)
    assert first["error"] < 0.1 and np.isnan(second["error"])
    assert second["amplitude [m √kg]"] == pytest.approx(motion.amplitude(0), rel=0.02)


def test_a_point_that_rests_at_its_bound_does_not_slip():
    """Its slider goes to where the motion no longer drags it, so that friction is at the bound once a period, but for round-off."""
    backbone, shares, limit, kt, far = made_up(), [], 0.31, 0.7, 7.3  # far from zero, for the sake of round-off
    system = backbone.system
    system.contact = reference.Contact.uniform(1, 1.0, kt, limit)
    system.preload = reference.Preload(np.array([[far + limit / kt, 0.0, 1.0]]), np.array([[limit, 0.0, 1.0]]), np.array([[far, 0.0]]))

    def of(amplitude, phase=0.0):
        q = np.zeros(system.shape)
        q[1, 1:] = amplitude * np.cos(phase), amplitude * np.sin(phase)
        return activity(backbone, Motion(1.0, 1.0, 1.0, q))

    for amplitude in np.linspace(0.1, 0.9, 60) * limit / kt:
        shares.append(of(amplitude, amplitude))
    assert np.max(shares) < 1e-12
    slip, opened, energy = of(1.1 * limit / kt)
    assert (slip, opened) == (1, 0) and energy == pytest.approx(4 * limit * 0.1 * limit / kt, rel=0.02)


def test_separate_curves_have_rows_of_their_own():
    backbone = made_up()
    levels = backbone.levels()[1]
    force = 0.5 * (levels[backbone.grid > 1.5].min() + levels[backbone.grid < 1.5].max())
    (main_peak, island), missing = table(backbone, 1, [force])
    assert (main_peak.separate, island.separate, missing) == (False, True, [])
    low, middle, high = (motion.alpha for motion in backbone.peaks(force, others=False))
    assert main_peak.amplitude == pytest.approx(low, rel=0.05) and island.amplitude == pytest.approx(high, rel=0.05)
    shorter = part(backbone, backbone.alpha < 0.5 * (middle + high))
    [row], missing = table(shorter, 1, [force])
    assert row.amplitude == pytest.approx(main_peak.amplitude, rel=1e-6) and missing == [force]
    results = SimpleNamespace(path="r.h5", title="", unit=parse("SI"), unit_of=lambda _: "m")
    said = in_words([row], [force, 1e6], results, "a1")
    assert said[-2:] == ["no peak on what the mode reaches under 1e+06 times the load",
                         f"further peaks beyond what the mode reaches under {force:g} times the load"]


def test_without_its_beginning_all_that_is_left_is_separate():
    backbone = made_up()
    levels = backbone.levels()[1]
    force = 0.5 * (levels[backbone.grid > 1.5].min() + levels[backbone.grid < 1.5].max())
    low, middle, _ = (motion.alpha for motion in backbone.peaks(force, others=False))
    upper = part(backbone, (backbone.alpha > low) & (backbone.alpha > 0.5 * (low + middle)), linear_below=False)
    [row], missing = table(upper, 1, [force])
    assert row.separate and missing == [force]


def test_left_and_right_of_a_peak_beyond_the_mode_are_one_curve():
    """An unknown that swings along at some amplitudes only has a peak on either side."""
    backbone = made_up()
    q = backbone.coefficients.copy()
    q[:, 0, 1] = backbone.alpha * np.exp(-(((backbone.alpha - 30) / 4) ** 2))
    rows, missing = table(Backbone(backbone.alpha, backbone.omega, backbone.damping_ratio, q, backbone.system), 0,
                          [1.1 * backbone.levels()[1].max()])
    assert [row.separate for row in rows] == [False, False] and not missing


def part(backbone, kept, linear_below=True):
    return Backbone(backbone.alpha[kept], backbone.omega[kept], backbone.damping_ratio[kept], backbone.coefficients[kept],
                    backbone.system, linear_below)


@pytest.mark.parametrize("options, words", [(["--force", "0"], "greater than 0"), (["--force", "-1"], "greater than 0"),
                                            (["--force", "1", "nan"], "finite and greater than 0, found nan"),
                                            (["--force", "inf"], "finite and greater than 0, found inf"),
                                            (["--harmonic", "0"], "harmonic must lie in 1 to 3, found 0"),
                                            (["-o", "table.txt"], "written as FILE.csv"), (["--dof", "x9.t1"], "x9.t1"),
                                            (["--harmonic", "7"], "harmonic must lie in 1 to 3")])
def test_wrong_input(folder, capsys, options, words):
    assert main(["peaks", str(folder / "results.h5"), *options]) == 2
    assert words in capsys.readouterr().err


def test_a_sweep_has_no_such_table(tmp_path, capsys):
    done = launch.run(cases.dof5(tmp_path, omega=[1.0, 1.01], **SETTINGS))
    assert main(["peaks", str(done.folder / "results.h5")]) == 2
    assert "follows no nonlinear mode" in capsys.readouterr().err


@pytest.mark.slow
def test_two_posts(tmp_path):
    """The table of the example beside its sweeps, as its README has them."""
    example = launch.ROOT / "inputs/two_solids"
    subprocess.run([sys.executable, example / "model.py", "-o", tmp_path / "model.h5"], env=launch.SURROUNDINGS, check=True)
    (tmp_path / "mode.toml").write_text((example / "mode.toml").read_text())
    subprocess.run([launch.BINARY, "run", tmp_path / "mode.toml", "--out", tmp_path], env=launch.SURROUNDINGS, check=True)
    assert main(["peaks", str(tmp_path / "results.h5"), "--hz", "--force", "0.5", "1", "2", "5", "10"]) == 0
    rows = read(tmp_path / "results_peaks.csv")
    swept = [(52.9, 657.3, 0), (85.2, 657.3, 2), (99.2, 656.5, 2), (148.6, 653.6, 5), (193.8, 649.7, 5)]
    for row, (amplitude, frequency, slipping) in zip(rows, swept, strict=True):
        assert row["amplitude [m]"] == pytest.approx(1e-6 * amplitude, rel=max(2e-3, 1.5 * row["error"]))
        assert row["frequency [Hz]"] == pytest.approx(frequency, rel=5e-4)
        assert row["slipping"] == pytest.approx(slipping / 9) and row["open"] == pytest.approx(3 / 9)
