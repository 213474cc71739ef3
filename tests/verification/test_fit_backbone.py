"""The command fit of a measured backbone: planted parameters come back from frequency and damping ratio over the amplitude."""

import json
import tomllib

import numpy as np
import pytest

import cases
from dovetail import Results
from dovetail.__main__ import main
from dovetail.case_runs import CaseRuns
from dovetail.fit_backbone import BackboneCase, BackboneSearch, ModeRuns, monotone, passages
from dovetail.fit_search import Curves, Unknown
from dovetail.measured import read_backbone
from dovetail.study_runs import Program
from dovetail.units import parse
from launch import BINARY, run

PLANTED = {"friction": [0.8, 0.8], "tangential_stiffness": [1.2, 1.2]}
ALPHA = np.geomspace(2, 40, 15)  # onsets lie at 4 and, as the case stands, at 6
HEADER = "amplitude [m], frequency [rad/s], damping [-]"


@pytest.fixture(autouse=True)
def drawn(monkeypatch):
    """Figures, which are not drawn: that takes longer than the runs."""
    figures = []
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", lambda figure, *_, **__: figures.append(figure))
    return figures


def mode_case(folder, amplitude=(0.5, 50), at=(), watch="x1.t1", **overrides):
    """Mode 1 of the five degrees of freedom."""
    folder.mkdir(exist_ok=True)
    case = cases.dof5(folder, harmonics=3, samples=None, step_tolerance=None, residual_tolerance=None, omega=None, step=None, kind=None,
                      initial=None, **overrides)
    kept = case.path.read_text()
    case.path.write_text(kept + f'\n[continuation]\nwatch = "{watch}"\n[mode]\nnumber = 1\namplitude = {list(amplitude)}\n'
                         + (f"at = {list(at)}\n" if len(at) else ""))
    return case


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """(amplitude of x1.t1, of its first harmonic, omega, damping ratio) of the planted mode at ALPHA, (15,) each."""
    results = Results(run(mode_case(tmp_path_factory.mktemp("bench"), at=ALPHA.tolist(), **PLANTED)).folder / "results.h5")
    points = [results.at(alpha) for alpha in ALPHA]
    np.testing.assert_allclose(results.modal_amplitude[points], ALPHA, rtol=1e-12)
    return [values[points] for values in (results.amplitude("x1.t1"), results.harmonic("x1.t1", 1), results.omega, results.damping_ratio)]


def written(path, *columns, header=HEADER):
    path.write_text("\n".join([header, *(", ".join(map(repr, row)) for row in np.column_stack(columns).tolist())]) + "\n")
    return path


def fitted(case, file, *options):
    out = case.path.parent / "case_fit"
    assert main(["fit", str(case.path), str(file), *options, "--out", str(out), "--binary", str(BINARY)]) == 0
    return json.loads((out / "fit.json").read_text()), tomllib.loads((out / "fitted.toml").read_text())


def test_planted_parameters_come_back_exactly(tmp_path, bench, capsys, drawn):
    """Without noise, from a case whose points begin to slip elsewhere, and which reaches less far."""
    size, _, omega, zeta = bench
    case = mode_case(tmp_path, (1.0, 30))
    rows = np.random.default_rng(1).permutation(len(size))  # in any order
    file = written(tmp_path / "backbone.csv", 1e3 * size[rows], omega[rows] / (2 * np.pi), 100 * zeta[rows],
                   header="amplitude [mm], frequency [Hz], damping [%]")
    numbers, toml = fitted(case, file)
    friction, stiffness = numbers["parameters"]
    assert friction["factor"] == pytest.approx(0.8, rel=1e-6) and stiffness["factor"] == pytest.approx(1.2, rel=1e-6)
    assert toml == {"contact": {"friction": friction["value"], "tangential_stiffness": stiffness["value"]}}
    assert numbers["amplitude"] == pytest.approx(size) and numbers["omega"]["fitted"] == pytest.approx(omega, rel=1e-7)
    assert numbers["damping_ratio"]["measured"] == pytest.approx(zeta) and numbers["damping_ratio"]["misfit"] < 1e-6
    assert numbers["omega"]["misfit"] < 1e-7 and numbers["measured"] == "backbone.csv" and numbers["watched"] == "x1.t1"
    said, [picture] = capsys.readouterr().out, drawn
    assert "backbone of 15 amplitudes, x1.t1, half the peak-to-peak" in said and "frequency: relative error" in said
    assert "reach beyond those of the mode of the case, 0 to " in said
    assert picture.texts[0].get_text().startswith("friction 0.8x (0.8 to 0.8), tangential_stiffness 1.2x (1.2 to 1.2)")
    assert [axis.get_ylabel() for axis in picture.axes] == ["frequency [Hz]", "damping ratio [%]"]
    for axis, values in zip(picture.axes, (omega / (2 * np.pi), 100 * zeta)):
        before, after, points = axis.get_lines()
        np.testing.assert_allclose(points.get_ydata(), values)
        np.testing.assert_allclose(np.interp(size[1:-1], *after.get_data()), values[1:-1], rtol=5e-3)
        assert not np.allclose(np.interp(size[1:-1], *before.get_data()), values[1:-1], rtol=0.01)


@pytest.mark.slow
def test_planted_parameters_come_back_through_noise(tmp_path, bench):
    """0.05 % of the frequency and 1 % of the damping ratio: within the confidence, and a scatter of each is left."""
    size, _, omega, zeta = bench
    dice = np.random.default_rng(5)
    omega, zeta = omega * np.exp(5e-4 * dice.standard_normal(15)), zeta * np.exp(0.01 * dice.standard_normal(15))
    numbers, _ = fitted(mode_case(tmp_path), written(tmp_path / "backbone.csv", size, omega, zeta))
    for found, planted in zip(numbers["parameters"], (0.8, 1.2)):
        assert found["low"] < planted < found["high"] and found["deviation"] < 5e-3
    assert 2e-4 < numbers["omega"]["misfit"] < 1e-3 and 5e-3 < numbers["damping_ratio"]["misfit"] < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("name, column, other", [("frequency [rad/s]", 2, "damping_ratio"), ("damping [-]", 3, "omega")])
def test_one_quantity_alone(tmp_path, bench, drawn, name, column, other):
    case = mode_case(tmp_path, tangential_stiffness=[1.2, 1.2])
    file = written(tmp_path / "backbone.csv", bench[0], bench[column], header=f"amplitude [m], {name}")
    numbers, _ = fitted(case, file, "--parameters", "friction")
    assert numbers["parameters"][0]["factor"] == pytest.approx(0.8, rel=1e-5) and other not in numbers and len(drawn[0].axes) == 1


@pytest.mark.slow
def test_the_first_harmonic_and_damping(tmp_path, bench):
    """The harmonic that was measured, and the damping of the case twice too large; what was computed is taken over."""
    _, first, omega, zeta = bench
    case = mode_case(tmp_path, stiffness=0.1, tangential_stiffness=[1.2, 1.2])
    file = written(tmp_path / "backbone.csv", first, omega, zeta)
    options = "--harmonic", "1", "--parameters", "friction", "damping"
    numbers, toml = fitted(case, file, *options)
    friction, damping = numbers["parameters"]
    assert friction["factor"] == pytest.approx(0.8, rel=1e-6) and damping["factor"] == pytest.approx(0.5, rel=1e-6)
    assert toml["damping"]["stiffness"] == pytest.approx(0.05) and numbers["harmonic"] == 1
    kept = (case.path.parent / "case_fit" / "runs.jsonl").read_text()
    assert fitted(case, file, *options)[0] == numbers and (case.path.parent / "case_fit" / "runs.jsonl").read_text() == kept


@pytest.mark.slow
def test_a_case_without_damping_whose_points_stick(tmp_path, bench, capsys):
    size, _, omega, zeta = bench
    case = mode_case(tmp_path, stiffness=0.0, tangential_stiffness=[1.2, 1.2])
    numbers, _ = fitted(case, written(tmp_path / "backbone.csv", size, omega, zeta), "--parameters", "friction")
    assert "has no damping, or less than a tenth of what was measured, at 5 of the amplitudes" in capsys.readouterr().out
    assert numbers["damping_ratio"]["fitted"][:6].count(None) == 5 and numbers["damping_ratio"]["misfit"] < 2.4


@pytest.mark.slow
def test_runs_have_points_at_the_measured_amplitudes(tmp_path, bench):
    """Also with factors far from those of the case."""
    case = mode_case(tmp_path)
    runs = CaseRuns(BackboneCase(case.path), Program(BINARY), tmp_path / "out")
    mode = ModeRuns(runs, [Unknown("tangential_stiffness")], bench[0], None)
    mode.first = mode.digest(runs.begin())["at"]
    near, far = mode.records([[0.0], [np.log(3.0)]])
    assert near["off"] < 1e-5 and far["off"] < 1e-5 and len(far["at"]) == len(ALPHA)
    assert all(len(passes) == 1 for passes in far["passes"]) and mode.count <= 10


def test_what_was_kept_of_other_amplitudes_is_not_taken_over(tmp_path):
    """A second test of the same amplitudes: the runs are the same."""
    case = mode_case(tmp_path)
    for amplitude in ([2.0, 3.0], [2.0, 2.0, 3.0]):
        runs = CaseRuns(BackboneCase(case.path), Program(BINARY), tmp_path / "out")
        mode = ModeRuns(runs, [Unknown("friction")], np.array(amplitude), None)
        mode.first = mode.digest(runs.begin())["at"]
        assert len(mode.first) == 2 and len(mode.records([[0.0]])[0]["passes"]) == len(amplitude)


def test_passages_of_a_mode_that_turns_back():
    """Amplitude 1 to 3, back to 2, on to 4, with omega the place along the curve: cubics without overshoot are exact on straight lines."""
    place = np.linspace(0, 5, 51)
    logs = np.interp(place, [0, 2, 3, 5], [0, 2, 1, 3])
    found = passages(np.exp([0.5, 1.5, 2.5, 3.5]), np.exp(logs), np.exp(2 * logs), place, 0 * place)
    omegas = [[omega for omega, _ in passes] for passes in found["passes"]]
    assert omegas[0] == pytest.approx([0.5]) and omegas[1] == pytest.approx([1.5, 2.5, 3.5]) and omegas[2] == pytest.approx([4.5])
    assert omegas[3] == [] and np.log(found["at"]) == pytest.approx([1, 3, 5, 6.5])  # beyond: in proportion
    assert found["off"] == pytest.approx(0.5) and [len(piece) for piece in monotone(logs)] == [21, 11, 21]
    assert monotone(np.ones(1)) == [] and monotone(np.zeros(0)) == []
    assert passages(np.ones(2), *np.zeros((4, 0))) == {"passes": [[], []], "at": [], "off": 0.0}


class Formula(ModeRuns):
    """In place of runs."""

    def __init__(self, scatter):
        super().__init__(None, [Unknown("friction")], np.ones(6), None)
        dice = np.random.default_rng(3)
        self.noise = [[np.exp(size * sign) for size, sign in zip(scatter, signs)] for signs in dice.choice([-1, 1], (6, 2))]

    def records(self, places):
        return [{"status": 0, "passes": [[noise] for noise in self.noise]} for _ in places]


@pytest.mark.parametrize("scatter, ratio", [((1e-3, 0.1), 100), ((5e-4, 0.01), 20), ((0, 0.01), 1000), ((0.01, 0.01), 10)])
def test_frequency_and_damping_count_by_their_scatter(scatter, ratio):
    """A relative error of a frequency weighs 10 to 1000 times that of a damping ratio."""
    mode = Formula(scatter)
    curves = Curves([BackboneSearch(mode, name, np.ones(6)) for name in ("omega", "damping_ratio")])
    assert curves.scatter[1] / curves.scatter[0] == pytest.approx(100)
    curves.weigh(np.zeros(1))
    assert curves.scatter[1] / curves.scatter[0] == pytest.approx(ratio)


def test_units_and_order_of_columns(tmp_path):
    (file := tmp_path / "b.csv").write_text("# ring-down\namplitude [um]; damping ratio [%]; frequency [kHz]\n"
                                            "20; 3; 0.1\n10; 2; 0.2\n20; 4; 0.1\n")
    found = read_backbone(file, parse("t, mm, s, N"))
    np.testing.assert_allclose(found.amplitude, [0.01, 0.02, 0.02])
    np.testing.assert_allclose(found.quantities["omega"], 2 * np.pi * np.array([200, 100, 100]))
    np.testing.assert_allclose(found.quantities["damping_ratio"], [0.02, 0.03, 0.04])
    assert found.hertz and list(found.quantities) == ["omega", "damping_ratio"]
    file.write_text("amplitude [m] damping [-]\n1 0.02\n2 0.03\n")
    assert list((found := read_backbone(file, parse("SI"))).quantities) == ["damping_ratio"] and not found.hertz


@pytest.mark.parametrize("text, words", [
    ("", "is empty"), ("1, 2\n", ":1: found '1, 2'; wanted is a header"), (HEADER + "\n", "no line behind it"),
    (HEADER + "\n1, 1\n", ":2: found '1, 1'"), (HEADER + "\n1, nan, 0.01\n2, 1, 0.02\n", "found '1, nan, 0.01'"),
    (HEADER + "\n1, 1, 0\n2, 1, 0.02\n", "greater than 0"), (HEADER + "\n1, 1, 0.01\n", "has one amplitude, 1"),
    (HEADER + "\n1, 1, 2\n2, 1, 3\n", "a damping ratio of 3"),
    ("frequency [Hz], amplitude [mm]\n1, 2\n", "begins with a frequency, as a measured response curve does"),
    ("amplitude [m]\n1\n2\n", "found 'amplitude [m]'"), ("damping [%], amplitude [m]\n1, 2\n2, 3\n", "amplitude [%]: the unit of a disp"),
    ("amplitude [m], damping [%], damping [-]\n1, 1, 1\n", "wanted is a header"),
    ("amplitude [m], phase [deg]\n1, 1\n", "phase [deg]: wanted"),
    ("amplitude [m], frequency [Hz], phase [deg]\n1, 1, 1\n", "wanted is a header")])
def test_measured_backbones_that_are_refused(tmp_path, text, words):
    (tmp_path / "b.csv").write_text(text)
    with pytest.raises(ValueError) as refused:
        read_backbone(tmp_path / "b.csv", parse("SI"))
    assert words in str(refused.value)


@pytest.mark.parametrize("options, words", [
    (["--force", "1"], "--force: "), (["--parameters", "friction", "force"], "--parameters force: "), (["--watch", "x7.t1"], "x7.t1"),
    (["--parameters", "damping"], "has no stiffness, mass"), (["--harmonic", "4"], "--harmonic 4: the case has 3"),
    (["--parameters", "friction", "tangential_stiffness", "normal_stiffness", "tangential_stiffness_1"], "is part of another"),
    (["--parameters", "friction", "tangential_stiffness", "normal_stiffness"], "has 2 values, 3 parameters need more"),
    (["--harmonic", "3", "--parameters", "friction"], "amplitudes that the mode of the case has")])
def test_wrong_options(tmp_path, capsys, options, words):
    case = mode_case(tmp_path, stiffness=0.0)
    file = written(tmp_path / "b.csv", [1.0, 2.0], [1.0, 1.0], header="amplitude [m], frequency [rad/s]")
    assert main(["fit", str(case.path), str(file), *options, "--out", str(tmp_path / "out"), "--binary", str(BINARY)]) == 2
    assert words in capsys.readouterr().err


def test_files_and_cases_of_the_other_kind(tmp_path, capsys):
    backbone = written(tmp_path / "b.csv", [1.0, 2.0], [1.0, 1.0], [0.02, 0.02])
    curve = written(tmp_path / "c.csv", [9.0, 11.0], [1.0, 1.0], header="omega [rad/s], amplitude [m]")
    elsewhere = written(tmp_path / "e.csv", [100.0, 200.0], [1.0, 1.0], [0.02, 0.02])
    (forced := tmp_path / "forced").mkdir()
    modal, forced = mode_case(tmp_path / "modal"), cases.stuck_mass(forced)
    for case, files, words in ((modal, [curve], "wants a case without [mode]"), (forced, [backbone], "wants a case with [mode]"),
                               (modal, [backbone, elsewhere], "wanted is one measured backbone, found 2 files"),
                               (modal, [elsewhere], "measured at amplitudes 100 to 200, ")):
        assert main(["fit", str(case.path), *map(str, files), "--binary", str(BINARY)]) == 2
        assert words in capsys.readouterr().err
