"""One sector of a bladed disk under a travelling load against the whole rotor, both of an independent program."""

import re
from pathlib import Path

import h5py
import numpy as np
import pytest

import cases
import cyclic_sector
import launch
import sector_model
from cyclic_sector import CASES, DATA, FEW, given

LINEAR = np.load(Path(__file__).with_name("data") / "rotor_linear.npz")
POINTS = [pytest.param(name, point, marks=() if point == 1 else pytest.mark.slow)
          for name in CASES for point in range(len(DATA[f"{name}/omega"]))]


def answer(tmp_path, name, point, expected, modes=None, further="", ranks=None):
    """Contact coefficients of a case that begins a thousandth away from those expected (points, 3, 2H+1)."""
    omega, flat = float(DATA[f"{name}/omega"][point]), expected.reshape(-1, expected.shape[-1])
    path, models = cyclic_sector.write(tmp_path, name, omega, modes=modes, further=further)
    cyclic_sector.write_start(tmp_path, name, omega, models, 1.001 * flat)
    done = launch.run(cases.Case(path, None, None, {}), ranks=ranks)
    return done.points["coefficients"][-1][-len(flat):].reshape(expected.shape)


@pytest.mark.parametrize("name, point", POINTS)
def test_a_sector_moves_as_the_whole_rotor_does(tmp_path, name, point):
    expected = DATA[f"{name}/X_rotor"][point, 0]
    found = answer(tmp_path, name, point, expected)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("name, point", POINTS)
def test_with_twenty_modes_per_index(tmp_path, name, point):
    expected = FEW[f"{name}/X_modes20"][point]
    found = answer(tmp_path, name, point, expected, modes=20)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * np.abs(expected).max())
    whole = DATA[f"{name}/X_rotor"][point, 0]
    assert np.abs(found - whole).max() > 1e-6 * np.abs(whole).max(), "all modes give another answer, which the test would see"


@pytest.mark.slow
@pytest.mark.parametrize("name, ranks", [(name, 2 + i % 2) for i, name in enumerate(CASES)])
def test_on_several_ranks(tmp_path, name, ranks):
    expected = FEW[f"{name}/X_modes20"][1]
    found = answer(tmp_path, name, 1, expected, modes=20, ranks=ranks)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("name", CASES)
def test_what_results_say_of_the_sectors(tmp_path, name):
    answer(tmp_path, name, 1, FEW[f"{name}/X_modes20"][1], modes=20)
    order = int(given(name)["engine_order"])
    with h5py.File(tmp_path / "results.h5") as file:
        assert file.attrs["sectors"] == cyclic_sector.N and file.attrs["engine_order"] == order
        indices = file["cyclic/index"][()]
        lost = file["points/contact/dissipation"][-1]
        xp = file["preload/xp"][()].reshape(-1, 3)
        assert file["cyclic/nodal_diameters"][()].tolist() == [0, 1, 2, 3]
        assert file["cyclic/frequencies"].shape == (4, 20) and (np.diff(file["cyclic/frequencies"], axis=1) > 0).all()
    assert indices.tolist() == [cyclic_sector.index(k, order) for k in range(int(given(name)["H"]) + 1)]
    expected = FEW[f"{name}/dissipation"][1]  # of all modes
    np.testing.assert_allclose(lost, expected, rtol=0, atol=2e-3 * expected.sum())
    np.testing.assert_allclose(xp, DATA[f"{name}/xp"], rtol=0, atol=1e-9 * np.abs(DATA[f"{name}/xp"]).max())


@pytest.mark.slow
def test_frequencies_by_nodal_diameter(tmp_path):
    path, _ = cyclic_sector.write(tmp_path, "eo2_separation", 1500.0, further="continuation.max_points = 1\naccuracy.estimates = false\n")
    launch.run(cases.Case(path, None, None, {}))
    with h5py.File(tmp_path / "results.h5") as file:
        found = file["cyclic/frequencies"][()]
    expected = LINEAR["stuck"]
    np.testing.assert_allclose(found, expected, rtol=1e-8)


@pytest.mark.parametrize("name", ["eo2_separation", pytest.param("eo-1_two_loads", marks=pytest.mark.slow)])
def test_from_the_model_of_the_sector(tmp_path, name):
    """The reduction of the program itself, with all modes, in place of that of these tests."""
    point, case = 1, given(name)
    omega, expected = float(DATA[f"{name}/omega"][point]), DATA[f"{name}/X_rotor"][point, 0]
    path, models = cyclic_sector.write(tmp_path, name, omega, further="accuracy.estimates = false\n")
    sector_model.write_model(tmp_path / "model.h5", patterns=case["patterns"].tolist())
    path.write_text(path.read_text().replace('reduced = "sector.h5"', f'model = "model.h5"\nreduction.modes = {sector_model.ALL}\n'
                                             f"reduction.interior_modes = {sector_model.INNER}"))
    cases_of = cases.Case(path, None, None, {})
    launch.run(cases_of, "-modes_eps_type", "lapack", command="reduce")
    with h5py.File(tmp_path / "reduced.h5") as file:
        for h, model in enumerate(models):  # their modes, for the start
            group = file["/"] if h == 0 else file[f"cyclic/{h}"]
            values = {key: group[key][()] if h == 0 else group[key][..., 0] + 1j * group[key][..., 1] for key in ("Max", "Fa")}
            model.update(Kaa=group["Kaa"][()], Mxa=values["Max"].conj().T, Fa=np.atleast_2d(values["Fa"]))
    cyclic_sector.write_start(tmp_path, name, omega, models, 1.001 * expected.reshape(-1, 15))
    found = launch.run(cases_of, "-modes_eps_type", "lapack").points["coefficients"][-1][-24:].reshape(expected.shape)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.slow
def test_a_sweep_through_separation_comes_by_the_answers(tmp_path):
    """From rest, with shrouds that open: every frequency of the independent program lies on the curve."""
    name = "eo2_separation"
    omegas = DATA[f"{name}/omega"]
    path, _ = cyclic_sector.write(tmp_path, name, 1800.0, samples=512, modes=20, further=f"continuation.at = {omegas.tolist()}\n")
    path.write_text(path.read_text().replace("[1800.0, 1800.0]", "[1800.0, 2600.0]"))
    points = launch.run(cases.Case(path, None, None, {})).points
    for omega, expected in zip(omegas, FEW[f"{name}/X_modes20"]):
        at = np.flatnonzero(np.isclose(points["omega"], omega, rtol=1e-12))
        found = points["coefficients"][at][:, -24:].reshape(-1, 8, 3, 15)
        assert len(at) and np.abs(found - expected).max(axis=(1, 2, 3)).min() < 2e-3 * np.abs(expected).max()


def test_engine_order_0_is_the_plain_model(tmp_path):
    """And so is any multiple of the number of sectors."""
    name, found = "eo1_root", {}
    for order in ("plain", 0, -6):
        folder = tmp_path / str(order)
        folder.mkdir()
        path, _ = cyclic_sector.write(folder, name, 2000.0, samples=256, modes=20)
        text = path.read_text()
        if order == "plain":
            text = text.replace("excitation.engine_order = 1\n", "").replace("{ harmonics", '{ solver = "assembled", harmonics')
            with h5py.File(folder / "sector.h5", "r+") as file:
                del file["cyclic"]
        path.write_text(text.replace("engine_order = 1", f"engine_order = {order}"))
        found[order] = launch.run(cases.Case(path, None, None, {})).points["coefficients"][-1]
    for order in (0, -6):
        np.testing.assert_allclose(found[order], found["plain"], rtol=0, atol=1e-12 * np.abs(found["plain"]).max())


@pytest.mark.parametrize("order, second, words", [
    (1, False, None), (0, False, None), (3, True, None),
    (3, False, "engine order 3, which on 6 sectors is nodal diameter 3: a standing wave, neighbours in opposite phase; engine orders 3 "
               "and -3"),
    (-6, False, "engine order -6, which on 6 sectors is nodal diameter 0: a standing wave, all sectors alike")])
def test_a_standing_wave_is_warned_of(tmp_path, order, second, words):
    """Of one pattern, under an engine order that the user may take for a travelling one."""
    path, _ = cyclic_sector.write(tmp_path, "eo-1_two_loads" if second else "eo1_root", 2000.0, samples=256, modes=20)
    text = path.read_text()
    path.write_text(re.sub(r"engine_order = -?\d+", f"engine_order = {order}", text))
    done = launch.run(cases.Case(path, None, None, {}))
    found = [warning["text"] for warning in done.summary["warnings"] if warning["kind"] == "standing_wave"]
    assert len(found) == (words is not None) and (not words or words in found[0])
    said = "warning: harmonic 1 of the load is engine order"
    modes, dry = launch.run(cases.Case(path, None, None, {}), command="modes"), launch.run(cases.Case(path, None, None, {}), "--dry-run")
    assert done.out.count(said) == len(found) == modes.out.count(said) == dry.out.count(said)


@pytest.mark.parametrize("harmonics, warned", [((3,), True), ((3, 6), True), ((3, 4), False)])
def test_a_wave_stands_only_if_all_harmonics_do(tmp_path, harmonics, warned):
    """Engine order 1: harmonics 3 and 6 of 6 sectors stand, harmonic 4 travels, and EO and -EO differ by it."""
    path, _ = cyclic_sector.write(tmp_path, "eo1_root", 2000.0, samples=256, modes=20)
    series = [9.0 if place in [2 * k - 1 for k in harmonics] else 0.0 for place in range(15)]
    path.write_text(re.sub(r"fourier = \[.*?\]", f"fourier = {series}", path.read_text()))
    done = launch.run(cases.Case(path, None, None, {}), "--dry-run")
    assert ("a standing wave" in done.out) == warned


@pytest.mark.parametrize("parameter, key, factor",
                         [("friction", "mu", 1.2), ("force", "fourier", 0.9),
                          pytest.param("normal_stiffness", "kn", 1.2, marks=pytest.mark.slow)])
def test_a_path_ends_where_the_case_with_that_value_is(tmp_path, monkeypatch, parameter, key, factor):
    """Another parameter than the frequency; the case with that value begins a thousandth from where the path ends.

    Means are measured from the preload, which is another one there, and where friction holds them they are not the only ones.
    """
    name, point = "eo1_root", 1
    omega, first = float(DATA[f"{name}/omega"][point]), FEW[f"{name}/X_modes20"][point].reshape(-1, 15)

    def last(folder, X, old="", new=""):
        folder.mkdir()
        path, models = cyclic_sector.write(folder, name, omega, samples='"exact"', modes=20, further="accuracy.estimates = false\n")
        cyclic_sector.write_start(folder, name, omega, models, X)
        path.write_text(path.read_text().replace(old, new))
        return launch.run(cases.Case(path, None, None, {})).points["coefficients"][-1][-len(X):]

    end = last(tmp_path / "path", first, f"continuation.omega = [{omega!r}, {omega!r}]\n",
               f'path = {{ parameter = "{parameter}", range = [1.0, {factor}], omega = {omega!r} }}\n')
    assert np.abs(end - first)[:, 1:].max() > 1e-3 * np.abs(first).max(), "the parameter changes the motion"
    unchanged = given(name)
    monkeypatch.setattr(cyclic_sector, "given", lambda _: {**unchanged, key: factor * unchanged[key]})
    there = last(tmp_path / "there", 1.001 * end)
    np.testing.assert_allclose(there[:, 1:], end[:, 1:], rtol=0, atol=1e-7 * np.abs(end).max())


def test_estimated_errors_are_those_of_more_harmonics(tmp_path):
    """Of three harmonics, against nine: in the indices that these have."""
    name, point = "eo2_separation", 1
    omega, start = float(DATA[f"{name}/omega"][point]), FEW[f"{name}/X_modes20"][point].reshape(-1, 15)
    scales, found = {"frequency": 2000.0, "modal": 1e-4, "contact": 1e-5}, {}
    for H in (3, 9):
        folder = tmp_path / str(H)
        folder.mkdir()
        further = 'scaling.kind = "manual"\n'
        further += "".join(f"scaling.{key} = {value}\n" for key, value in scales.items())
        path, models = cyclic_sector.write(folder, name, omega, samples='"exact"', modes=20, further=further)
        cyclic_sector.write_start(folder, name, omega, models, start)
        path.write_text(path.read_text().replace("harmonics = 7", f"harmonics = {H}").replace(8 * "0.0, " + "0.0]", "0.0]"))
        found[H] = launch.run(cases.Case(path, None, None, {})).points
    X = {H: np.pad(points["coefficients"][-1] / np.r_[np.full(20, scales["modal"]), np.full(24, scales["contact"])][:, None],
                   ((0, 0), (0, 2 * (9 - H)))) for H, points in found.items()}
    actual = np.linalg.norm((X[3] - X[9])[:, 1:]) / np.linalg.norm(X[9][:, 1:])
    estimated = found[3]["error_harmonics"][-1]
    assert 1e-3 < actual and 0.6 * actual < estimated < 1.5 * actual


REFUSED = {
    "engine order missing": ("excitation.engine_order = 1\n", "", "one of 6 equal sectors; write engine_order"),
    "not whole": ("engine_order = 1", "engine_order = 1.5", "must be a whole number"),
    "stability": ("continuation.omega", "stability.enabled = true\ncontinuation.omega", "stability is not judged"),
    "integration": ("continuation.omega", 'recovery.strategies = ["jump", "integration"]\ncontinuation.omega',
                    "nothing is integrated in time"),
    "ratios": ("damping.stiffness", "damping.ratios = [[1, 0.01]]\ndamping.stiffness", "modes differ with the nodal diameter"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_a_sector_does_not_have_is_refused_in_words(tmp_path, what):
    old, new, words = REFUSED[what]
    path, _ = cyclic_sector.write(tmp_path, "eo1_root", 2000.0, samples='"exact"', modes=4)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    refused = launch.run(cases.Case(path, None, None, {}), status=2)
    assert words in refused.err and str(path) in refused.err


def test_an_engine_order_of_no_sector_is_refused(tmp_path):
    path, _ = cyclic_sector.write(tmp_path, "eo1_root", 2000.0, modes=4)
    with h5py.File(tmp_path / "sector.h5", "r+") as file:
        del file["cyclic"]
    refused = launch.run(cases.Case(path, None, None, {}), status=2)
    assert "excitation.engine_order" in refused.err and "is no sector of a cyclic structure" in refused.err


@pytest.mark.parametrize("attribute, value", [("engine_order", 2), ("sectors", 12)])
def test_a_start_from_another_wave_is_refused(tmp_path, attribute, value):
    path, models = cyclic_sector.write(tmp_path, "eo1_root", 2000.0, modes=4)
    cyclic_sector.write_start(tmp_path, "eo1_root", 2000.0, models, np.ones((18, 15)))
    with h5py.File(tmp_path / "start.h5", "r+") as file:
        file.attrs[attribute] = value
    refused = launch.run(cases.Case(path, None, None, {}), status=2)
    assert f"{value if attribute == 'sectors' else 6} sectors, engine order {value if attribute == 'engine_order' else 1}" in refused.err


@pytest.mark.parametrize("name", ["viscous", "structural"])
def test_matrices_of_the_model_that_have_no_index_are_refused(tmp_path, name):
    path, _ = cyclic_sector.write(tmp_path, "eo1_root", 2000.0, modes=4)
    with h5py.File(tmp_path / "sector.h5", "r+") as file:
        file["Caa" if name == "viscous" else "Saa"] = np.ones(4)
    assert "matrix is left out; on a sector of a cyclic structure none is taken yet" in launch.run(
        cases.Case(path, None, None, {}), "--dry-run").out
    path.write_text(("damping.matrix = true\n" if name == "viscous" else "damping.structural = 0.01\n") + path.read_text())
    assert "is not taken yet" in launch.run(cases.Case(path, None, None, {}), status=2).err
