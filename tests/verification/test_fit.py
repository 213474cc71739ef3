"""The command fit: planted parameters come back, with the confidence that theory gives them."""

import json
import tomllib

import numpy as np
import pytest

import cases
from dovetail import Results
from dovetail.__main__ import main
from dovetail.case_runs import CaseRuns, CurveCase
from dovetail.fit import solved
from dovetail.fit_curves import CurveSearch
from dovetail.fit_search import Curves, Search, Unknown, changes_of, uncertainty
from dovetail.measured import Measured, read_measured
from dovetail.study_runs import Program
from dovetail.units import parse
from launch import BINARY, run


@pytest.fixture(autouse=True)
def undrawn(monkeypatch):
    """Drawing takes longer than the runs."""
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", lambda *_, **__: None)


def measured(path, omega, amplitude, header="omega [rad/s], amplitude [m]"):
    path.write_text("\n".join([header, *(f"{w!r}, {a!r}" for w, a in zip(omega.tolist(), amplitude.tolist()))]) + "\n")
    return path


def fitted(case, file, *options, out="case_fit"):
    """The file, or a list of them."""
    files = file if isinstance(file, list) else [file]
    out = case.path.parent / out
    assert main(["fit", str(case.path), *map(str, files), *options, "--out", str(out), "--binary", str(BINARY)]) == 0
    return json.loads((out / "fit.json").read_text()), tomllib.loads((out / "fitted.toml").read_text())


def test_closed_form_of_a_stuck_mass(tmp_path):
    """k_t and C = b K from A(w) = F / |k + k_t - w^2 + i b k w|, with noise: the least squares of this formula, and their intervals."""
    case = cases.stuck_mass(tmp_path)
    k, b, kt = 40.0, 0.01, 60.0
    omega = np.linspace(7, 13.5, 14)

    def amplitude(x):
        return 1 / np.abs(k + kt * np.exp(x[0]) - omega**2 + 1j * b * np.exp(x[1]) * k * omega)

    planted = np.log([1.2, 0.8])
    noise = 0.01 * np.random.default_rng(2).standard_normal(len(omega))
    wanted = amplitude(planted) * np.exp(noise)
    x = planted.copy()
    for _ in range(5):  # Gauss and Newton on the formula
        errors = np.log(amplitude(x) / wanted)
        jacobian = np.column_stack([np.log(amplitude(x + 1e-6 * unit) / amplitude(x - 1e-6 * unit)) / 2e-6 for unit in np.eye(2)])
        x = x - np.linalg.lstsq(jacobian, errors, rcond=None)[0]
    errors = np.log(amplitude(x) / wanted)
    covariance = np.linalg.inv(jacobian.T @ jacobian) * np.sum(errors**2) / (len(omega) - 2)
    numbers, toml = fitted(case, measured(tmp_path / "curve.csv", omega, wanted), "--parameters", "tangential_stiffness", "damping",
                           "--watch", "x1.t1")
    found, damping = numbers["parameters"]
    assert (found["factor"], damping["factor"]) == pytest.approx(np.exp(x), rel=1e-5)
    assert (found["deviation"], damping["deviation"]) == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-2)
    quantile = 2.1788  # of Student's distribution with 12 degrees of freedom, 97.5 %
    assert np.log(found["high"] / found["factor"]) == pytest.approx(quantile * found["deviation"], rel=1e-4)
    assert found["low"] < 1.2 < found["high"] and damping["low"] < 0.8 < damping["high"]
    assert toml["contact"]["tangential_stiffness"] == pytest.approx(kt * found["factor"])
    assert toml["damping"]["stiffness"] == pytest.approx(b * damping["factor"]) and found["value"] == pytest.approx(kt * found["factor"])
    assert numbers["misfit"] == pytest.approx(np.sqrt(np.mean(errors**2)), rel=1e-4)


@pytest.mark.slow
def test_planted_friction_and_stiffness_come_back(tmp_path):
    """Five degrees of freedom, whose point slips and lifts off: a curve with 1 % noise."""
    settings = {"kind": "auto", "harmonics": 3, "samples": "exact", "omega": [0.95, 1.15], **cases.TIGHT}
    omega = np.linspace(0.95, 1.15, 15)
    (planted := tmp_path / "planted").mkdir()
    done = run(cases.dof5(planted, **settings, friction=[0.8, 0.8], tangential_stiffness=[1.2, 1.2], at=omega[1:-1].tolist()))
    results = Results(done.folder / "results.h5")
    amplitude = results.amplitude("a1")[[int(np.argmin(np.abs(results.omega - w))) for w in omega]]
    noise = 0.01 * np.random.default_rng(1).standard_normal(len(omega))
    case = cases.dof5(tmp_path, **settings)
    numbers, toml = fitted(case, measured(tmp_path / "curve.csv", omega, amplitude * (1 + noise)), "--watch", "a1")
    friction, stiffness = numbers["parameters"]
    assert friction["low"] < 0.8 < friction["high"] and stiffness["low"] < 1.2 < stiffness["high"]
    assert friction["deviation"] < 0.05 and stiffness["deviation"] < 0.05 and 0.005 < numbers["misfit"] < 0.015
    assert toml == {"contact": {"friction": friction["value"], "tangential_stiffness": stiffness["value"]}}


@pytest.mark.slow
def test_planted_parameters_come_back_from_two_force_levels(tmp_path, capsys, monkeypatch):
    """Five degrees of freedom, noise of 0.5 % under the whole load and 2 % under 0.6 of it: within the confidence of both, which is
    narrower than that of either alone."""
    drawn = []
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", lambda figure, *_, **__: drawn.append(figure))
    settings = {"kind": "auto", "harmonics": 3, "samples": "exact", "omega": [0.95, 1.15], **cases.TIGHT}
    omega, files, forces, noise = np.linspace(0.95, 1.15, 15), [], (1.0, 0.6), (0.005, 0.02)
    dice = np.random.default_rng(4)
    for force, part in zip(forces, noise):
        (planted := tmp_path / f"planted_{force}").mkdir()
        done = run(cases.dof5(planted, **settings, friction=[0.8, 0.8], tangential_stiffness=[1.2, 1.2], fourier=[0, 0, force],
                              at=omega[1:-1].tolist()))
        results = Results(done.folder / "results.h5")
        amplitude = results.amplitude("a1")[[int(np.argmin(np.abs(results.omega - w))) for w in omega]]
        files.append(measured(tmp_path / f"curve_{force}.csv", omega, amplitude * np.exp(part * dice.standard_normal(len(omega)))))
    case = cases.dof5(tmp_path, **settings)
    both, toml = fitted(case, files, "--force", "1", "0.6", "--watch", "a1")
    said, [picture] = capsys.readouterr().out, drawn
    assert "2 curves: 30 frequencies" in said and "curve_0.6.csv: force 0.6x, 15 frequencies" in said
    assert {"curve_1.0.csv", "curve_0.6.csv"} <= {text.get_text() for text in picture.axes[0].get_legend().get_texts()}
    alone = [fitted(case, file, "--force", str(force), "--watch", "a1", out=f"alone_{force}")[0] for file, force in zip(files, forces)]
    for i, planted in enumerate((0.8, 1.2)):
        assert both["parameters"][i]["low"] < planted < both["parameters"][i]["high"]
        assert both["parameters"][i]["deviation"] < min(one["parameters"][i]["deviation"] for one in alone)
    for one, part in zip(both["curves"], noise):
        assert part / 2 < one["misfit"] < 2 * part
    assert toml["contact"]["friction"] == both["parameters"][0]["value"] and "excitation" not in toml


@pytest.mark.slow
def test_what_the_curve_does_not_depend_on_is_told(tmp_path, capsys):
    """Friction of a point that never slips."""
    case = cases.stuck_mass(tmp_path)
    omega = np.linspace(9, 11, 5)
    file = measured(tmp_path / "curve.csv", omega, 1.01 / np.abs(100 - omega**2 + 0.4j * omega))
    numbers, _ = fitted(case, file, "--watch", "x1.t1")
    assert "the curve hardly depends on friction" in capsys.readouterr().out and numbers["parameters"][0]["high"] is None


def test_a_factor_for_each_joint():
    """Points of one joint have the same factor, those of none stay as they are."""
    unknowns = [Unknown("friction", "left", np.array([0, 2])), Unknown("friction", "right", np.array([3])), Unknown("force")]
    changes = changes_of(unknowns, [2.0, 3.0, 4.0], 5)
    np.testing.assert_array_equal(changes["friction"][1], [2, np.nan, 2, 3, np.nan])
    assert changes["friction"][0] == "factor" and changes["force"] == ("factor", 4.0) and str(unknowns[0]) == "friction of left"


def test_uncertainty_of_a_line():
    """y = a + b t with errors: deviations in closed form."""
    t = np.array([0.0, 1, 2, 3, 4])
    errors = np.array([0.1, -0.2, 0.1, 0.1, -0.1])
    deviation, correlation = uncertainty(errors, np.column_stack([np.ones(5), t]))
    s = np.sqrt(np.sum(errors**2) / 3)
    assert deviation == pytest.approx([s * np.sqrt(1 / 5 + 4 / 10), s / np.sqrt(10)])
    assert correlation[0, 1] == pytest.approx(-2 / np.sqrt(10) / np.sqrt(1 / 5 + 4 / 10))


class Formula(Search):
    """In place of runs: passages by a formula of x."""

    def __init__(self, formula, wanted):
        super().__init__([Unknown("friction")], np.asarray(wanted))
        self.formula = formula

    def records(self, places):
        return [{"status": 3} if (found := self.formula(float(x[0]))) is None else {"status": 0, "passes": found} for x in places]

    def passes(self, record):
        return record["passes"]


@pytest.mark.parametrize("passes, slopes", [
    (lambda x: [[np.exp(3 * x)], [np.exp(2 * x)] if x <= 0 else []], [3, 2]),  # missed above
    (lambda x: [[np.exp(3 * x)], [np.exp(2 * x)] if x > 0 else []], [3, 0]),  # missed here
    (lambda x: [[np.exp(3 * x)], [np.exp(2 * x)] if x == 0 else []], [3, 0]),  # missed on both sides
    (lambda x: [[np.exp(3 * x)], [np.exp(2 * x)]] if x <= 0 else None, [3, 2])])  # the run above fails
def test_slopes_where_a_frequency_is_missed_beside(passes, slopes):
    search = Formula(passes, [1.0, 1.0])
    assert search.derivative(np.zeros(1))[:, 0] == pytest.approx(slopes, abs=1e-9)


def test_slopes_of_what_runs_differ_by_anyway_are_none():
    """A search divided by the round-off of two runs went to a factor of a hundred."""
    search = Formula(lambda x: [[1 + 1e-11 * np.sin(1e5 * x)], [np.exp(2e-4 * x)]], [1.0, 1.0])
    slopes = search.derivative(np.zeros(1))[:, 0]
    assert slopes[0] == 0 and slopes[1] == pytest.approx(2e-4)


def scattered(dice, scatter, slopes):
    """A curve whose amplitude is exp(slope x) at each of some frequencies, measured at x = 0 with scatter."""
    wanted = np.exp(scatter * dice.standard_normal(len(slopes)))
    return Formula(lambda x: [[np.exp(slope * x)] for slope in slopes], wanted)


def test_every_curve_counts_by_its_own_scatter():
    """Least squares of a line in closed form, with the weights that it leaves itself."""
    dice, slopes = np.random.default_rng(7), [np.linspace(1, 2, 12), np.linspace(-1, 3, 20)]
    curves = Curves([scattered(dice, scatter, slope) for scatter, slope in zip((0.002, 0.01), slopes)])
    logs = [np.log(search.wanted) for search in curves.searches]
    x, scatter = 0.0, np.ones(2)
    for _ in range(20):
        x = sum(s @ y / w**2 for s, y, w in zip(slopes, logs, scatter)) / sum(s @ s / w**2 for s, w in zip(slopes, scatter))
        scatter = [np.sqrt(np.mean((s * x - y) ** 2) / (1 - 1 / 32)) for s, y in zip(slopes, logs)]
    solution = solved(curves, 1)
    deviation, _ = uncertainty(solution.fun, solution.jac)
    assert solution.x[0] == pytest.approx(x, abs=0.02 * deviation[0]) and curves.scatter == pytest.approx(scatter, rel=0.03)
    assert deviation[0] == pytest.approx(1 / np.sqrt(sum(s @ s / w**2 for s, w in zip(slopes, scatter))), rel=0.05)
    for search in curves.searches:
        one = solved(Curves([search]), 1)
        assert deviation[0] < uncertainty(one.fun, one.jac)[0][0]


def test_no_curve_rules_because_it_is_met_by_chance():
    """Three points without scatter weigh ten times those of the other, not a million times."""
    curves = Curves([scattered(np.random.default_rng(7), scatter, np.ones(count)) for scatter, count in ((0, 3), (0.01, 20))])
    curves.weigh(np.zeros(1))
    assert curves.scatter[1] / curves.scatter[0] == pytest.approx(10)


@pytest.mark.parametrize("files, forces, words", [
    (["a.csv", "b.csv"], [], "2 measured files want 2 factors"), (["a.csv", "b.csv"], ["1"], "found 1"),
    (["a.csv"], ["1", "2"], "1 measured file wants 1 factor "), (["a.csv", "b.csv"], ["1", "-2"], "--force 1 -2: factors must be"),
    (["a.csv", "a.csv"], ["1", "2"], "a.csv: this measured file is there twice"),
    (["a.csv", "c.csv"], ["1", "2"], "c.csv: amplitude [m/s]: the unit of a displacement"), (["a.csv", "d.csv"], ["1", "2"],
     "d.csv: measured from 20 to 20.2")])
def test_several_files_that_are_refused(tmp_path, capsys, files, forces, words):
    case = cases.stuck_mass(tmp_path)
    omega = np.array([9.0, 10, 11])
    for name in ("a", "b"):
        measured(tmp_path / f"{name}.csv", omega, np.ones(3))
    measured(tmp_path / "c.csv", omega, np.ones(3), "omega [rad/s], amplitude [m/s]")
    measured(tmp_path / "d.csv", omega / 10 + 19.1, np.ones(3))
    options = ["--force", *forces] if forces else []
    paths = [str(tmp_path / name) for name in files]
    assert main(["fit", str(case.path), *paths, *options, "--watch", "x1.t1", "--binary", str(BINARY)]) == 2
    assert words in capsys.readouterr().err


def test_no_more_points_than_unknowns_tell_nothing():
    deviation, _ = uncertainty(np.ones(2), np.eye(2))
    assert np.isinf(deviation).all()


def stuck_curve(folder, omega, factor=1.0):
    """That of `cases.stuck_mass` with its tangential stiffness times a factor."""
    return measured(folder / "curve.csv", omega, 1 / np.abs(40 + 60 * factor - omega**2 + 0.4j * omega))


@pytest.mark.slow
def test_a_search_that_ends_at_its_limit_is_no_fit(tmp_path, capsys):
    """The measured amplitudes lie far beneath all that a stiffness 100 times as large gives."""
    case = cases.stuck_mass(tmp_path)
    omega = np.linspace(7, 8, 5)
    numbers, _ = fitted(case, measured(tmp_path / "curve.csv", omega, np.full(5, 1e-6)), "--parameters", "tangential_stiffness",
                        "--watch", "x1.t1")
    [found] = numbers["parameters"]
    assert found["at_limit"] and found["factor"] > 90 and found["high"] is None and found["low"] is None
    said = capsys.readouterr().out
    assert "tangential_stiffness is at the limit of a factor of 100: no fit" in said and "hardly depends" not in said


def test_a_search_that_is_broken_off_is_no_fit(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("dovetail.fit.EVALUATIONS", 1)
    numbers, _ = fitted(cases.stuck_mass(tmp_path), stuck_curve(tmp_path, np.linspace(9, 11, 5), 1.2), "--parameters",
                        "tangential_stiffness", "--watch", "x1.t1")
    said = capsys.readouterr().out
    assert not numbers["converged"] and "caution: not converged" in said and numbers["parameters"][0]["high"] is None
    assert "hardly depends" not in said


def test_measured_frequencies_and_the_sweep_of_the_case(tmp_path, capsys):
    case = cases.stuck_mass(tmp_path)
    command = ["fit", str(case.path), str(stuck_curve(tmp_path, np.linspace(1, 2, 5))), "--watch", "x1.t1", "--binary", str(BINARY)]
    assert main(command) == 2
    said = capsys.readouterr().err
    assert "measured from 1 to 2" in said and "continuation.omega from 7 to 13.5" in said
    stuck_curve(tmp_path, np.linspace(6.5, 9, 5))
    assert main([*command, "--parameters", "tangential_stiffness"]) == 0
    assert "6.5 to 9, reach beyond continuation.omega, 7 to 13.5" in capsys.readouterr().out


def test_measured_files_say_their_units(tmp_path):
    file = tmp_path / "m.csv"
    file.write_text("# bench 3\nfrequency [Hz]; amplitude [um]\n2; 5\n1; 4\n")
    found = read_measured(file, parse("t, mm, s, N"))
    np.testing.assert_allclose(found.omega, 2 * np.pi * np.array([1, 2]))
    np.testing.assert_allclose(found.amplitude, [4e-3, 5e-3])
    file.write_text("omega [rad/s]\tamplitude [mm]\n1000\t5\n")
    found = read_measured(file, parse("kg, mm, ms"))
    assert found.omega == pytest.approx([1.0]) and found.amplitude == pytest.approx([5.0])


@pytest.mark.parametrize("text, words", [
    ("", "is empty"), ("1, 2\n", ":1: found '1, 2'; wanted is a header"), ("frequency [Hz], amplitude [m]\n1, x\n", ":2: found '1, x'"),
    ("frequency [Hz], amplitude [m]\n1, 2\n1, 3\n", "frequency 1 is there twice"),
    ("frequency [rpm], amplitude [m]\n1, 2\n", "[rpm]: the unit"),
    ("frequency [Hz], amplitude [g]\n1, 2\n", "amplitude [g]: the unit of a displacement"), ("frequency [Hz], amplitude [m]\n", "no line"),
    ("frequency [Hz], amplitude [m]\n1, -2\n", "greater than 0"),
    ("frequency [Hz]; amplitude [mm]\n100,5; 0,012\n", ":2: found '100,5; 0,012'"),
    ("frequency [Hz], amplitude [mm]\n100, 5, 90\n", "no further column"),
    ("frequency [Hz], amplitude [mm], phase [deg]\n100, 5\n", "wanted is a header"),
    ("frequency [Hz], amplitude [mm], phase\n100, 5\n", "wanted is a header")])
def test_measured_files_that_are_refused(tmp_path, text, words):
    (tmp_path / "m.csv").write_text(text)
    with pytest.raises(ValueError) as refused:
        read_measured(tmp_path / "m.csv", parse("SI"))
    assert words in str(refused.value)


def test_amplitudes_are_lengths_also_where_units_are_not_known(tmp_path):
    (file := tmp_path / "m.csv").write_text("frequency [Hz], amplitude [m/s]\n1, 2\n")
    with pytest.raises(ValueError, match="unit of a displacement"):
        read_measured(file, parse(""))
    file.write_text("frequency [Hz], amplitude [mm]\n1, 2\n")
    assert read_measured(file, parse("")).amplitude == pytest.approx([2.0])


def test_a_harmonic_does_not_take_over_peaks_of_another(tmp_path):
    """The run is the same, what is kept of it is not: a mass that sticks has no second harmonic."""
    case = cases.stuck_mass(tmp_path)
    case.edit("harmonics = 1", "harmonics = 2")
    curve = Measured(np.linspace(9, 11, 3), np.ones(3))
    for harmonic, there in ((None, True), (2, False), (None, True)):
        runs = CaseRuns(CurveCase(case.path, (9, 11), "x1.t1"), Program(BINARY), tmp_path / "out")
        runs.begin()
        [record] = CurveSearch(runs, [Unknown("tangential_stiffness")], curve, [10.0], harmonic).records(np.zeros((1, 1)))
        assert all((max(values) > 1e-3) == there for values in record["passes"])


@pytest.mark.parametrize("options, words", [
    (["--jobs", "0"], "--jobs 0"), (["--parameters", "friction", "friction_1"], "one of them is part of another"),
    (["--harmonic", "0"], "--harmonic 0"), (["--parameters", "damping"], "has no stiffness, mass")])
def test_wrong_input(tmp_path, capsys, options, words):
    case = cases.dof5(tmp_path, stiffness=0.0)
    assert main(["fit", str(case.path), "none.csv", "--binary", str(BINARY), *options]) == 2
    assert words in capsys.readouterr().err
