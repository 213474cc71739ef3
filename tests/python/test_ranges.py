"""Ranges of parameters without runs: what words mean, what becomes of a case, how samples lie, what first order is worth."""

import tomllib

import numpy as np
import pytest

import cases
import synthetic_results
from dovetail import Results, ranges
from dovetail.__main__ import main
from dovetail.case_changes import Range, apply, contact_values, need
from dovetail.case_runs import CaseRuns, CurveCase, largest_at, largest_peak
from dovetail.peak_tracks import follow
from dovetail.ranges_mode import over_amplitude
from dovetail.study_runs import Program
from launch import BINARY

CONTACT = {"law": np.array([0, 0, 2]), "normal_stiffness": np.array([1.0, 2, 3]), "gap": np.zeros(3),
           "friction": np.array([[0.3, 0.4], [0.5, 0.6], [0, 0]]), "tangential_stiffness": np.array([[1.0, 2], [3, 4], [0, 0]])}


def test_values_are_even_and_factors_even_in_the_logarithm():
    value, factor = Range.read("friction", ["0.2", "0.5"]), Range.read("friction", ["0.5x", "2x"])
    assert (value.kind, factor.kind, Range.read("gap", ["-1e-5", "1e-5"]).kind) == ("value", "factor", "offset")
    np.testing.assert_allclose([value.at(xi) for xi in (-1, 0, 0.5, 1)], [0.2, 0.35, 0.425, 0.5])
    np.testing.assert_allclose([factor.at(xi) for xi in (-1, 0, 0.5, 1)], [0.5, 1, 2**0.5, 2])
    for wanted in (value, factor):
        step = (np.log if wanted is factor else np.float64)(wanted.at(1e-6)) - (np.log if wanted is factor else np.float64)(wanted.at(0.0))
        assert wanted.half == pytest.approx(step / 1e-6, rel=1e-6)


def test_changes_of_the_joint():
    """One direction, one number per point, factors on what is there; points without friction are left aside but stay valid."""
    changed = contact_values(CONTACT, {"friction_2": ("factor", 2.0), "tangential_stiffness": ("value", 7.0), "gap": ("offset", 1e-3),
                                       "normal_stiffness": ("factor", np.array([2.0, np.nan, 10.0]))})
    np.testing.assert_allclose(changed["friction"], [[0.3, 0.8], [0.5, 1.2], [1, 1]])
    np.testing.assert_allclose(changed["tangential_stiffness"], [[7, 7], [7, 7], [1, 1]])
    np.testing.assert_allclose(changed["normal_stiffness"], [2, 2, 30])
    np.testing.assert_allclose(changed["gap"], 1e-3)
    np.testing.assert_allclose(CONTACT["friction"][0], [0.3, 0.4])  # as it was


def test_changes_of_the_case():
    content = {"contact": {"normal_stiffness_per_area": 1e9}, "damping": {"stiffness": 2.0, "ratios": [[1, 0.1]], "matrix": True},
               "excitation": {"load": [{"pattern": "a", "fourier": [0, 1]}, {"pattern": "b", "fourier": [2]}]}}
    found = apply(content, CONTACT, {"normal_stiffness": ("value", 5.0), "force": ("factor", 3.0), "damping": ("factor", 0.5)})
    assert found == {"contact": {"normal_stiffness": 5.0}, "damping": {"stiffness": 1.0, "ratios": [[1, 0.05]], "matrix": True},
                     "excitation": {"load": [{"pattern": "a", "fourier": [0, 3]}, {"pattern": "b", "fourier": [6]}]}}
    assert content["damping"]["stiffness"] == 2.0


def test_copies_are_lean_and_keep_the_rest(tmp_path):
    case = cases.dof5(tmp_path, at=[1.0])
    text = CurveCase(case.path, omega=(0.95, 1.1), until_peak=1).text(tmp_path / "a/b", {**CONTACT, "law": np.zeros(1, int),
                     "friction": np.ones((1, 2))}, {"friction": ("value", 0.5)}, watch="tip.y")
    copy, own = tomllib.loads(text), tomllib.loads(case.path.read_text())
    assert copy["continuation"] == {"omega": [0.95, 1.1], "step": 0.05, "watch": "tip.y", "stop_after_peaks": 1}
    assert copy["contact"] == {**own["contact"], "friction": 0.5} and copy["output"] == {"motion": ["tip"]}
    assert copy["stability"] == {"enabled": False} and copy["accuracy"] == {"estimates": False} and copy["model"] == "../../model.h5"


def test_more_samples_go_on_with_those_that_are_there():
    given = [Range("friction", "value", 0.2, 0.5), Range("force", "factor", 0.5, 2)]
    few, many = ranges.spread(given, 5, 3), ranges.spread(given, 40, 3)
    assert few == many[:5] and few != ranges.spread(given, 5, 4)
    places = np.array([[place["friction"], place["force"]] for place in ranges.spread(given, 256, 1)])
    assert np.abs(places).max() <= 1 and np.abs(places.mean(axis=0)).max() < 0.01
    np.testing.assert_allclose(np.cov(places.T), np.eye(2) / 3, atol=0.01)
    each = ranges.spread(given, 4, 3, points=3)[0]
    assert each["friction"].shape == (3,) and isinstance(each["force"], float)


def test_branches_that_turn_back_count_with_their_largest_amplitude(tmp_path):
    """Over the frequencies 1, 2, 1.5, 3 the amplitudes 1, 5, 2, 1: at 1.75 are three points."""
    coefficients = np.zeros((4, 4, 3))
    coefficients[:, 0, 1] = 1, 5, 2, 1
    results = Results(synthetic_results.write(tmp_path / "r.h5", [1.0, 2, 1.5, 3], coefficients, 1, {
        key: values[:1] for key, values in CONTACT.items() if key != "law"}))
    np.testing.assert_allclose(largest_at(results, "a1", [0.5, 1.75, 2.0, 2.25]), [np.nan, 4, 5, 1.5])
    found = largest_peak(results, "a1")
    assert found["peak"] and found["rms"] == 5 and found["amplitude"] >= 5


def place_of(wanted, number):
    """The xi of a number."""
    low, high, number = np.log([wanted.low, wanted.high, number]) if wanted.kind == "factor" else (wanted.low, wanted.high, number)
    return 2 * (number - low) / (high - low) - 1


class Formula:
    """In place of runs: peaks by a formula of xi."""

    def __init__(self, given, amplitude):
        self.given, self.amplitude, self.dof, self.contact, self.asked = given, amplitude, "tip.y", CONTACT, 0

    def each(self, list_of_changes, digest, what, at=None):
        self.asked += len(list_of_changes)
        places = [{wanted.name: place_of(wanted, changes[wanted.name][1]) for wanted in self.given} for changes in list_of_changes]
        return [{"status": 0, "reason": "", "peak": True, "omega": 2.0, "amplitude": self.amplitude(**place)} for place in places]


@pytest.mark.parametrize("amplitude, slopes, meaningless", [
    (lambda force, friction: 5 + force - 2 * friction + 0.5 * friction**2, {"force": 1, "friction": -2}, False),
    (lambda force, friction: 5 + 0.1 * force + friction**2 + 0.01 * friction, {"force": 0.1, "friction": 0.01}, True),
    (lambda force, friction: 5 + friction**2, {"force": 0, "friction": 0}, True),
    (lambda force, friction: 5 + 0 * force, {"force": 0, "friction": 0}, False),
    (lambda force, friction: 5 + 0.1 * friction + 3 * (friction - 0.02) ** 2, {"force": 0.0, "friction": -0.02}, True)])
def test_first_order_is_told_where_it_is_meaningless(amplitude, slopes, meaningless):
    """The second one has its minimum over friction beside a slope by force; the last beside the middle: slope -0.02, where the ends
    lie 3 higher."""
    given = [Range("force", "factor", 0.5, 2), Range("friction", "value", 0.2, 0.6)]
    runs = Formula(given, amplitude)

    def changes(places):
        return {wanted.name: (wanted.kind, wanted.at(places.get(wanted.name, 0.0))) for wanted in given}

    middle = runs.each([changes({})], None, "")[0]
    first = ranges.first_order(runs, given, changes, None, middle, False)
    assert first.amplitude == pytest.approx(slopes, abs=1e-9) and set(first.by.values()) == {"differences"}
    assert first.flat == (not any(slopes.values()))
    assert first.meaningless == meaningless and first.omega == pytest.approx({"force": 0, "friction": 0})
    assert first.deviation() == pytest.approx(np.hypot(*slopes.values()) / np.sqrt(3))


class Followed(Formula):
    """Peaks 5 + xi^2, and a run that follows them: up to `last`, of another peak where `shift` is not 0."""

    def __init__(self, given, last, shift=0.0, status=0):
        super().__init__(given, lambda friction: 5 + friction**2)
        self.last, self.shift, self.status = last, shift, status

    def each(self, list_of_changes, digest, what, at=None, path=None):
        if path is None:
            return super().each(list_of_changes, digest, what)
        assert path["parameter"] == "friction" and path["peak"] == "amplitude"
        factors = np.array([path["range"][0], *path["at"], path["range"][1]])
        assert factors == pytest.approx(np.array([0.2, 0.3, 0.4, 0.5, 0.6]) / 0.4)
        numbers = factors[0.4 * factors <= self.last]
        amplitude = 5 + ((0.4 * numbers - 0.4) / 0.2) ** 2 + self.shift
        return [{"status": self.status, "reason": "broken", "parameter": list(numbers), "omega": [2.0] * len(numbers),
                 "amplitude": list(amplitude), "rms": list(amplitude)}]


@pytest.mark.parametrize("last, shift, status, reached, reason", [
    (0.7, 0.0, 0, 5, ""), (0.45, 0.0, 0, 3, "it ends at 0.4"), (0.7, 0.2, 0, 0, "another peak"), (0.7, 0.0, 3, 0, "broken")])
def test_a_track_is_taken_as_far_as_it_is_the_largest_peak(last, shift, status, reached, reason):
    wanted, places = Range("friction", "value", 0.2, 0.6), np.linspace(-1, 1, 5)
    runs = Followed([wanted], last, shift, status)
    track = follow(runs, wanted, lambda place: {"friction": ("value", wanted.at(place.get("friction", 0.0)))}, places, None)
    records = track.at(places)
    assert [record is not None for record in records] == [i < reached for i in range(5)]
    assert (reason in track.reason) and bool(reason) == bool(track.reason)
    assert [record["amplitude"] for record in records[:reached]] == pytest.approx([6, 5.25, 5, 5.25, 6][:reached])


@pytest.mark.parametrize("options, words", [
    ([], "nothing to vary"),
    (["--friction", "0.2", "2x"], "two values, or two factors"),
    (["--friction", "0.5", "0.2"], "the first must be less"),
    (["--friction", "-0.5", "0.2"], "must be greater than 0"),
    (["--friction", "0.2", "much"], "--friction much: wanted is a number"),
    (["--gap", "0.5x", "2x"], "offsets are wanted"),
    (["--gap", "-1e-5", "-2.0e-5"], "--gap -1e-5 -2.0e-5: the first must be less"),
    (["--force", "1", "2"], "wanted are factors"),
    (["--preload", "1", "2"], "wanted are factors"),
    (["--friction", "0.2", "0.5", "--friction_1", "0.2", "0.5"], "change the same numbers"),
    (["--friction", "0.2", "0.5", "--jobs", "0"], "--jobs 0: must be at least 1"),
    (["--friction", "0.2", "0.5", "--along", "1"], "at least 2 points"),
    (["--friction", "0.2", "0.5", "--omega", "1", "1"], "curves need a range"),
    (["--friction", "0.2", "0.5", "--binary", "nowhere"], "nowhere: is no program"),
])
def test_wrong_input(tmp_path, capsys, options, words):
    case = cases.dof5(tmp_path)
    assert main(["range", str(case.path), "--binary", str(BINARY), *options]) == 2
    assert words in capsys.readouterr().err and not (tmp_path / "case_range").exists()


@pytest.mark.parametrize("command, name", [(["range", "--friction", "0.2", "0.5"], "case"), (["fit", "m.csv"], "fitted")])
def test_a_case_of_the_user_is_not_overwritten(tmp_path, capsys, command, name):
    case = cases.dof5(tmp_path)
    (tmp_path / name).mkdir()
    (file := tmp_path / name / "case.toml").write_text("mine = true\n")
    assert main([command[0], str(case.path), *command[1:], "--out", str(tmp_path), "--binary", str(BINARY)]) == 2
    assert "would be overwritten" in capsys.readouterr().err and file.read_text() == "mine = true\n"


def test_a_copy_that_was_broken_off_is_overwritten(tmp_path):
    case = cases.dof5(tmp_path)
    (tmp_path / "case").mkdir()
    curves = CurveCase(case.path)
    (tmp_path / "case/case.toml").write_text(curves.text(tmp_path / "case"))
    assert CaseRuns(curves, Program(BINARY), tmp_path)._run(tmp_path / "case", None, "").folder == tmp_path / "case"


@pytest.mark.parametrize("section, command", [("[path]\nparameter = \"force\"\nrange = [1, 2]\n", ["range", "--friction", "0.2", "0.5"]),
                                              ("[path]\nparameter = \"force\"\nrange = [1, 2]\n", ["fit", "m.csv"])])
def test_other_curves_are_refused(tmp_path, capsys, section, command):
    case = cases.dof5(tmp_path)
    case.path.write_text(f"{case.path.read_text()}\n{section}")
    assert main([command[0], str(case.path), *command[1:], "--binary", str(BINARY)]) == 2
    said = capsys.readouterr().err
    assert "curves over the frequency are wanted" in said and "study" not in said


@pytest.mark.parametrize("options, words", [(["--omega", "1", "2"], "--omega is for peaks of a curve"), (["--track"], "--track is for"),
                                            (["--until-peak", "1"], "--until-peak is for"), (["--watch", "a1"], "--watch is for")])
def test_options_of_peaks_are_refused_for_a_mode(tmp_path, capsys, options, words):
    case = cases.dof5(tmp_path, omega=None, step=None)
    case.path.write_text(f"{case.path.read_text()}\n[mode]\nnumber = 1\namplitude = [1, 2]\n")
    assert main(["range", str(case.path), "--friction", "0.2", "0.5", *options, "--binary", str(BINARY)]) == 2
    assert words in capsys.readouterr().err


def test_a_mode_over_given_amplitudes(tmp_path):
    """Levels in proportion to the amplitude stay so between points, and a mode that turns back counts once at each amplitude."""
    alpha = np.array([0.1, 10, 8, 20])
    q = np.zeros((4, 4, 3))
    results = Results(synthetic_results.write(tmp_path / "r.h5", [2.0, 2.0, 1.9, 1.8], q, 1, {
        key: values[:1] for key, values in CONTACT.items() if key != "law"}, modal_amplitude=alpha, damping_ratio=0.01 * alpha,
        force_level=3 * alpha))
    found = over_amplitude(results, np.array([0.05, 0.1, 1.0, 10.0, 20.0, 30.0]))
    assert found["force_level"] == [None, pytest.approx(0.3), pytest.approx(3), pytest.approx(30), pytest.approx(60), None]
    assert found["omega"][1:5] == [2.0, 2.0, 2.0, 1.8] and found["omega"][0] is None


@pytest.mark.parametrize("mode", ["", "\n[mode]\nnumber = 1\namplitude = [0.5, 5]\n"], ids=["curve", "mode"])
def test_damping_by_a_matrix_is_not_scaled(tmp_path, capsys, mode):
    """The ranges of a mode were those of one damping."""
    case = cases.dof5(tmp_path)
    case.edit("[damping]", "[damping]\nmatrix = true")
    case.path.write_text(case.path.read_text() + mode)
    for command in (["range", str(case.path), "--damping", "0.5x", "2x"], ["fit", str(case.path), "m.csv", "--parameters", "damping"]):
        assert main([*command, "--binary", str(BINARY)]) == 2
        assert "the matrix of the model has no factor" in capsys.readouterr().err


def test_what_a_case_has_not(tmp_path, capsys):
    case = cases.dof5(tmp_path, stiffness=0.0)
    assert main(["range", str(case.path), "--damping", "0.5x", "2x", "--binary", str(BINARY)]) == 2
    assert "has no stiffness, mass" in capsys.readouterr().err
    with pytest.raises(ValueError, match="no contact point of this case has friction"):
        need("friction", {"law": np.array([2, 3])})
    with pytest.raises(ValueError, match="one friction for both"):
        need("friction_1", {"law": np.array([1, 0])})
