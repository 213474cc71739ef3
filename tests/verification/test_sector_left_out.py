"""What a reduced sector leaves out: against dense algebra, against runs with all modes, and as a tolerance asks for it."""

import re
import shutil
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

import cases
import cyclic_sector
import launch
import sector_model
from dovetail import Results
from dovetail.study_errors import distances
from sector_model import ALL, INNER, N
from small_wave import OMEGA

OFFSET = 3e-6  # of the sweep, for tangents of the reference
FREQUENCIES = {order: np.linspace(*OMEGA[order], 7)[1:-1] for order in OMEGA}
SWEEP = {order: OMEGA[order][1] - OMEGA[order][0] for order in OMEGA}
MASS = sector_model.matrix("M")


def scene(folder, order, reduction, balance, more="", frequencies=None):
    """A resonance at which few contact points slip, from the model of the sector."""
    sector_model.write_model(folder / "model.h5", patterns=("lift", "second"))
    path, _ = cyclic_sector.write(folder, "eo2_separation", 2000.0, samples='"exact"')
    text, at = path.read_text(), FREQUENCIES[order] if frequencies is None else frequencies
    lines = {'reduced = "sector.h5"': 'model = "model.h5"\n' + reduction, "harmonic_balance": balance,
             "excitation.engine_order": f"excitation.engine_order = {order}",
             "newton": "newton = { step_tolerance = 1e-8, residual_tolerance = 1e-8 }\n" + more, "fourier": "fourier = [0.0, 9.0]",
             "continuation.omega": f"continuation.omega = {list(OMEGA[order])}\ncontinuation.adaptive = true\n"
                                   f"continuation.at = {at.tolist()}"}
    text = "\n".join(next((new for key, new in lines.items() if line.startswith(key)), line) for line in text.splitlines()) + "\n"
    path.write_text(text)
    return cases.Case(path, None, None, {})


def complex_values(values):
    return values[..., 0] + 1j * values[..., 1] if np.isrealobj(values) and values.shape[-1] == 2 else values


def left_out(file, h):
    """(r,) squares, (patterns, r) loads."""
    group = file["left_out"] if h == 0 else file[f"cyclic/{h}/left_out"]
    return group["Kaa"][()], group["Fa"][()] if h == 0 else complex_values(group["Fa"][()])


def energies(patterns):
    """Twice that of the motion at rest under each pattern, contact points held, in every nodal diameter; by dense algebra."""
    rows = np.repeat(3 * sector_model.FREE, 3) + np.tile(range(3), len(sector_model.FREE))
    F = np.array([sector_model.SECTOR[f"pattern_{name}"][rows] for name in patterns]).T
    for h in range(N // 2 + 1):
        T = sector_model.transform(h)[:, :-24]
        load = T.conj().T @ F
        yield np.einsum("ij,ij->j", load.conj(), np.linalg.solve(T.conj().T @ (sector_model.matrix("K") @ T), load)).real


@pytest.mark.parametrize("interior, exact, ranks", [(12, False, None), (30, False, 2), (12, True, None), (INNER, False, 3)])
def test_nothing_of_the_load_is_lost(tmp_path, interior, exact, ranks):
    """Contact points held, a load at rest has all of its energy in the modes kept and those left out."""
    sector_model.write_model(tmp_path / "model.h5", patterns=("lift", "second"))
    path = sector_model.write_case(tmp_path / "case.toml", 8, interior, exact)
    folder = launch.run(cases.Case(path, None, None, {}), ranks=ranks, command="reduce").folder
    with h5py.File(folder / "reduced.h5") as file:
        for h, whole in enumerate(energies(("lift", "second"))):
            K, _, kept, _ = sector_model.index(file, h)
            squares, loads = left_out(file, h)
            energy = (np.abs(kept[:, :8])**2 / np.diag(K)[:8].real).sum(axis=1), (np.abs(loads)**2 / squares).sum(axis=1)
            assert np.all(energy[1] > 1e-3 * whole) and np.all(energy[0] > 1e-3 * whole)
            np.testing.assert_allclose(sum(energy), whole, rtol=1e-3 if exact else 1e-8)


def test_residuals_keep_all_of_the_load(tmp_path):
    """In every nodal diameter, at rest; and modes stay orthogonal."""
    sector_model.write_model(tmp_path / "model.h5", patterns=("lift", "second"))
    path = sector_model.write_case(tmp_path / "case.toml", 8, 12)
    path.write_text('reduction.kind = "residual"\n' + path.read_text())
    folder = launch.run(cases.Case(path, None, None, {}), command="reduce").folder
    with h5py.File(folder / "reduced.h5") as file:
        for h, whole in enumerate(energies(("lift", "second"))):
            K, _, F, motion = sector_model.index(file, h)
            np.testing.assert_allclose((np.abs(F[:, :8])**2 / np.diag(K)[:8].real).sum(axis=1), whole, rtol=1e-8)
            modes = motion[:, :8]
            np.testing.assert_allclose(modes.conj().T @ (MASS @ modes), np.eye(8), rtol=0, atol=1e-9)


@pytest.fixture(scope="module")
def all_modes(tmp_path_factory):
    """A function that gives the folder of the reference, with all modes and so many harmonics."""
    known = {}

    def reference(order, harmonics):
        if (order, harmonics) not in known:
            folder = tmp_path_factory.mktemp("reference")
            around = np.sort([f + shift * OFFSET * SWEEP[order] for f in FREQUENCIES[order] for shift in (-1, 0, 1)])
            case = scene(folder, order, f"reduction = {{ modes = {ALL}, interior_modes = {INNER} }}",
                         f"harmonic_balance.harmonics = {harmonics}", "accuracy.estimates = false\n", around)
            known[order, harmonics] = launch.run(case, "-modes_eps_type", "lapack").folder
        return known[order, harmonics]

    return reference


def errors(folder, order, reference):
    """True ones of the points at common frequencies: modes as parts of those of the reference, index by index."""
    results, finer = (Results(path / "results.h5") for path in (folder, reference))
    lifted = np.zeros((len(results.omega), ALL + 24, results.coefficients.shape[2]))
    few = results.modes
    lifted[:, ALL:] = results.coefficients[:, few:]
    with h5py.File(folder / "reduced.h5") as ours, h5py.File(reference / "reduced.h5") as theirs:
        for k, h in enumerate(results.wave.index):
            if k == 0:
                continue
            change = sector_model.index(theirs, abs(h))[3][:, :ALL].conj().T @ (MASS @ sector_model.index(ours, abs(h))[3][:, :few])
            change = change.conj() if h < 0 else change
            q = results.coefficients[:, :few, 2 * k - 1] - 1j * results.coefficients[:, :few, 2 * k]
            moved = q @ change.T
            lifted[:, :ALL, 2 * k - 1], lifted[:, :ALL, 2 * k] = moved.real, -moved.imag
    with h5py.File(folder / "state.h5") as state:
        scales = state["scales"][()]
    as_theirs = SimpleNamespace(coefficients=lifted, modes=ALL, contact_points=8, harmonics=results.harmonics, omega=results.omega)
    points, true = distances(as_theirs, finer, scales, SWEEP[order], FREQUENCIES[order], OFFSET * SWEEP[order])
    assert len(points) >= len(FREQUENCIES[order])
    return results, points, true


@pytest.mark.parametrize("order, harmonics, reduction", [
    (1, 3, "modes = 6, interior_modes = 15"), (2, 3, "modes = 10"), (1, 3, "modes = 6, interior_modes = 12, exact_modes = true"),
    pytest.param(1, 8, "modes = 6, interior_modes = 15", marks=pytest.mark.slow),
    pytest.param(1, 8, 'modes = 12, kind = "residual"', marks=pytest.mark.slow),
    pytest.param(2, 8, "modes = 12, exact_modes = true", marks=pytest.mark.slow)])
def test_estimates_are_near_the_true_errors(tmp_path, all_modes, order, harmonics, reduction):
    """With as many harmonics, each of its own index."""
    done = launch.run(scene(tmp_path, order, f"reduction = {{ {reduction} }}", f"harmonic_balance.harmonics = {harmonics}"))
    results, points, true = errors(done.folder, order, all_modes(order, harmonics))
    ratio = results.points("error_modes")[points] / true
    assert done.points["slip"].max() > 0 and true.min() > 1e-4
    assert np.all((ratio > 0.8) & (ratio < 1.25)), (ratio, true)


@pytest.mark.parametrize("tolerance, modes, ranks", [(1e-2, 20, None), *(pytest.param(*other, marks=pytest.mark.slow) for other in
                                                                    ((1e-2, 20, 2), (1e-4, 40, None), (1e-4, 40, 2)))])
def test_a_tolerance_chooses_modes_and_harmonics(tmp_path, all_modes, tolerance, modes, ranks):
    done = launch.run(scene(tmp_path, 1, "", "", f"accuracy.tolerance = {tolerance}\n"), ranks=ranks)
    results, _, true = errors(done.folder, 1, all_modes(1, 18))
    assert np.mean(true <= tolerance) >= 0.95, true
    assert results.modes == modes and done.summary["accuracy"]["above"] == 0 and done.points["slip"].max() > 0
    assert f"modes: {modes} leave out" in done.out


@pytest.mark.parametrize("name, change, words", [
    ("Max", lambda values: values[:, :-3], "shape (16, 21, 2) where (16, 24, 2) is wanted"),
    ("Maa", lambda values: values[:-1], "shape (7, 16, 2) where (8, 16, 2) is wanted"),
    ("Kaa", lambda values: -values, "squared frequencies above 0 are wanted"),
    ("Fa", lambda values: np.nan * values, "finite numbers are wanted")])
def test_a_damaged_file_is_refused(tmp_path, name, change, words):
    sector_model.write_model(tmp_path / "model.h5")
    case = cases.Case(sector_model.write_case(tmp_path / "case.toml", 8, 40), None, None, {})
    shutil.copy(launch.run(case, command="reduce").folder / "reduced.h5", tmp_path / "given.h5")
    with h5py.File(tmp_path / "given.h5", "r+") as file:
        left = file["cyclic/2/left_out"]
        values = left[name][()]
        del left[name]
        left[name] = change(values)
    keys = "".join(f"contact.{key} = 1e8\n" for key in ("normal_stiffness", "tangential_stiffness")) + "contact.friction = 0.3\n"
    text = re.sub("reduction.*\n", "", case.path.read_text())
    case.path.write_text(text.replace('model = "model.h5"\n', 'reduced = "given.h5"\n' + keys))
    refused = launch.run(case, command="modes", status=2).err
    assert f"/cyclic/2/left_out/{name}: " in refused and words in refused


def test_too_few_interior_modes_for_a_tolerance_are_told(tmp_path):
    done = launch.run(scene(tmp_path, 1, "reduction.interior_modes = 12", "", "accuracy.tolerance = 1e-3\n"))
    modes = 12 + ALL - INNER
    assert f"modes: {modes} leave out" in done.out and "the 12 interior modes make no more of them" in done.out
    assert done.summary["accuracy"]["modes"] > 5e-4 and done.summary["accuracy"]["above"] > 0


@pytest.mark.slow
def test_modes_of_a_tolerance_are_those_of_a_restart(tmp_path):
    """A run that is continued has the points of one that is not, with the modes that its beginning chose."""
    case = scene(tmp_path, 1, "", "", "continuation.max_points = 1000\naccuracy.tolerance = 1e-4\n")
    expected = Results(launch.run(case, out="whole").folder / "results.h5")
    text = case.path.read_text()
    for points in (7, 1000):
        case.path.write_text(text.replace("max_points = 1000", f"max_points = {points}"))
        done = launch.run(case, *(["--restart"] if points > 7 else []), out="parts")
    found = Results(done.folder / "results.h5")
    assert found.modes == 40 and len(found.omega) > 7
    np.testing.assert_array_equal(found.omega, expected.omega)
    np.testing.assert_array_equal(found.coefficients, expected.coefficients)


def test_a_check_looks_at_the_nodal_diameter_of_the_load(tmp_path):
    sector_model.write_model(tmp_path / "model.h5")
    case = cases.Case(sector_model.write_case(tmp_path / "case.toml", 1, 60), None, None, {})
    launch.run(case, command="reduce")
    said = {}
    for order in range(N // 2 + 1):
        case.path.write_text(re.sub("engine_order = .", f"engine_order = {order}", case.path.read_text()))
        told = re.search(r'"lift" moves at rest, contact points held, ([\d.]+) % of the energy', launch.run(case, command="check").out)
        said[order] = float(told[1]) if told else None
    with h5py.File(tmp_path / "reduced.h5") as file:
        for h, percent in said.items():
            K, _, kept, _ = sector_model.index(file, h)
            squares, loads = left_out(file, h)
            lost = (np.abs(loads)**2 / squares).sum()
            share = 100 * lost / (lost + abs(kept[0, 0])**2 / K[0, 0].real)
            assert percent == (pytest.approx(share, rel=1e-2) if share > 50 else None)
    assert len(set(said.values())) == 4
