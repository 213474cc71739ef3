"""Motion of all sectors of a bladed disk, from the results of one, against the whole rotor of an independent program."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

import cases
import cyclic_sector
import launch
import sector_model
from cyclic_sector import CASES, DATA, given
from dovetail import Results, fourier
from whole_rotor import later

TIP = np.load(Path(__file__).with_name("data") / "cyclic_tip.npz")
NODES, POINT, N = TIP["set_tip"], 1, cyclic_sector.N


@pytest.fixture(scope="module", params=[pytest.param(name, marks=() if name == "eo2_separation" else pytest.mark.slow)
                                        for name in CASES])
def run(request, tmp_path_factory):
    """Name of a case, and its results at one frequency, with all modes."""
    folder, name = tmp_path_factory.mktemp("sector"), request.param
    omega, expected = float(DATA[f"{name}/omega"][POINT]), DATA[f"{name}/X_rotor"][POINT, 0]
    points = len(expected)
    path, models = cyclic_sector.write(folder, name, omega, further="accuracy.estimates = false\n")
    sector_model.write_model(folder / "model.h5", patterns=given(name)["patterns"].tolist(), points=points)
    with h5py.File(folder / "model.h5", "r+") as file:
        file["mesh/sets/tip"] = NODES
    interior = sector_model.INNER + 6 * (8 - points)  # nodes of a shroud that touches nothing
    modes = interior + 3 * (points - 6) + 3 * len(sector_model.SECTOR["left"])
    path.write_text(path.read_text().replace('reduced = "sector.h5"', f'model = "model.h5"\nreduction.modes = {modes}\n'
                                             f"reduction.interior_modes = {interior}"))
    case = cases.Case(path, None, None, {})
    launch.run(case, "-modes_eps_type", "lapack", command="reduce")
    with h5py.File(folder / "reduced.h5") as file:
        for h, model in enumerate(models):  # their modes, for the start
            group = file["/"] if h == 0 else file[f"cyclic/{h}"]
            values = {key: group[key][()] if h == 0 else group[key][..., 0] + 1j * group[key][..., 1] for key in ("Max", "Fa")}
            model.update(Kaa=group["Kaa"][()], Mxa=values["Max"].conj().T, Fa=np.atleast_2d(values["Fa"]))
    cyclic_sector.write_start(folder, name, omega, models, 1.001 * expected.reshape(-1, 15))
    launch.run(case, "-modes_eps_type", "lapack")
    return name, Results(folder / "results.h5")


def coefficients(values):
    """Fourier coefficients (..., 2H+1) of equal samples (n, ...) of a period, H = 7."""
    n = len(values)
    return np.moveaxis(2 / n * np.tensordot(fourier.basis(7, fourier.phases(n)) * np.r_[2, np.ones(14)], values, (0, 0)), 0, -1)


def test_contacts_of_every_sector(run):
    name, results = run
    for j in range(N):
        expected = DATA[f"{name}/X_rotor"][POINT, j]
        found = results.coefficients_at(-1, sector=j)[results.modes:].reshape(expected.shape)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * np.abs(expected).max())


def test_loops_of_other_sectors(run):
    """Displacement is that of the whole rotor, and the loops are the same ones, which the run has summed up."""
    name, results = run
    samples, j = 64 * N, int(np.argmax(results.contact_activity(-1).dissipation))
    first, lost = results.contact_force(-1, j + 1, samples)[0], results.dissipated(-1, j + 1)
    assert lost > 0
    for sector in range(N):
        then, area = np.roll(first, 64 * sector * results.wave.engine_order, axis=0), 0.0
        for direction in (0, 1):
            x, T = results.hysteresis(-1, j + 1, direction, samples, sector=sector)
            X = DATA[f"{name}/X_rotor"][POINT, sector, j, direction]
            expected = fourier.basis(7, fourier.phases(samples)) @ X + results.xp[3 * j + direction]
            np.testing.assert_allclose(x, expected, rtol=0, atol=1e-8 * np.abs(DATA[f"{name}/X_rotor"]).max())
            np.testing.assert_allclose(T, then[:, direction], rtol=0, atol=1e-8 * np.abs(first).max())
            area += np.sum((T + np.roll(T, -1)) / 2 * (np.roll(x, -1) - x))
        assert area == pytest.approx(lost, rel=2e-2)


def test_displacements(run):
    name, results = run
    expected, order = TIP[f"{name}/U_tip"], int(given(name)["engine_order"])
    found = {j: results.displacement(-1, "tip", 64, sector=j) for j in range(N)}
    for j, values in found.items():
        then = np.array([later(series, j * 2 * np.pi * order / N) for series in expected])
        np.testing.assert_allclose(coefficients(values).reshape(expected.shape)[:, 1:], then[:, 1:], rtol=0,
                                   atol=1e-8 * np.abs(expected).max())
        np.testing.assert_array_equal(results.full(-1, 64, sector=j)[:, sector_model.DOF[NODES]], values)
    np.testing.assert_array_equal(results.displacement(-1, "tip", 64), found[0])
    series = results.response("tip.y").coefficients[-1]
    np.testing.assert_allclose(series, expected.reshape(4, 3, 15)[:, 1].mean(axis=0), rtol=0, atol=1e-8 * np.abs(expected).max())


def test_displacements_of_the_few_that_are_kept(run, tmp_path):
    """In whatever order the rows are."""
    _, results = run
    for name in ("results.h5", "reduced.h5", "model.h5"):
        shutil.copy(results.path.parent / name, tmp_path)
    with h5py.File(tmp_path / "reduced.h5", "r+") as file:
        dofs = file["recovery/elastic_dofs"][()]
        rows = np.random.default_rng(1).permutation(np.flatnonzero(np.isin(dofs, sector_model.DOF[NODES])))
        for name in (*(f"recovery/{part}" for part in ("elastic_dofs", "xe0", "Phi", "Psi")),
                     *(f"cyclic/{h}/{part}" for h in range(1, N // 2 + 1) for part in ("Phi", "Psi"))):
            values = file[name][()][rows]
            del file[name]
            file[name] = values
    few = Results(tmp_path / "results.h5").displacement(-1, "tip", 16, sector=2)
    whole = results.displacement(-1, "tip", 16, sector=2)
    np.testing.assert_allclose(few, whole, rtol=0, atol=1e-13 * np.abs(whole).max())
    with pytest.raises(ValueError, match="keeps 12 elastic degrees of freedom, and .* of the ones wanted"):
        Results(tmp_path / "results.h5").displacement(-1, NODES + 1)


def test_means(run):
    """What is static beside the motion: x_e0 and the preload, of which only the motion is known from elsewhere."""
    name, results = run
    expected = TIP[f"{name}/U_tip"]
    with h5py.File(results.reduced) as file:
        order = np.argsort(file["recovery/elastic_dofs"][()])
        rest = (file["recovery/xe0"][()] + file["recovery/Psi"][()] @ results.xp)[order]
    mean = results.displacement(-1, "tip", 64).mean(axis=0) - rest[sector_model.DOF[NODES]]
    np.testing.assert_allclose(mean.ravel(), expected[:, 0] / 2, rtol=0, atol=1e-8 * np.abs(expected).max())


def test_global_axes(run):
    """Left of the next sector is right of this one: where they meet, both move alike."""
    _, results = run
    left, right = (sector_model.SECTOR[side] for side in ("left", "right"))
    for j in range(N):
        here = results.displacement(-1, right, 16, sector=j, axes="global")
        there = results.displacement(-1, left, 16, sector=(j + 1) % N, axes="global")
        np.testing.assert_allclose(there, here, rtol=0, atol=1e-12 * np.abs(here).max())
    own = results.displacement(-1, right, 16, sector=1)
    assert np.abs(own - results.displacement(-1, right, 16, sector=1, axes="global")).max() > 0.1 * np.abs(own).max()


def test_what_is_said(run):
    name, results = run
    with h5py.File(results.path) as file:
        assert results.wave.index.tolist() == file["cyclic/index"][()].tolist()
        np.testing.assert_array_equal(results.wave.frequencies, file["cyclic/frequencies"][()])
    order = int(given(name)["engine_order"])
    assert (results.wave.sectors, results.wave.engine_order) == (6, order)
    for sector in (6, -1, 1.0):
        with pytest.raises(ValueError, match="sector must be a whole number from 0 to 5, found"):
            results.hysteresis(-1, 1, sector=sector)
    with pytest.raises(ValueError, match='axes must be "sector" or "global"'):
        results.displacement(-1, "tip", axes="cylindrical")
