"""The whole wheel made of a sector's reduced model: its frequencies are those of all indices, and waves move as they do in the sector."""

from types import SimpleNamespace

import h5py
import numpy as np
import pytest
import scipy.linalg

from dovetail.reference import Damping, HarmonicBalance, SectorBalance
from dovetail.reduced_system import of_index, reduced_of
from dovetail.travelling_wave import TravellingWave, spatial_index
from dovetail.wheel_model import unrolled, wave_of_wheel

MODES, CONTACT, H = 4, 6, 3
NO_CONTACT = SimpleNamespace(points=0)


def random_sector(path, sectors, phase=0.0):
    """A reduced file of random Hermitian matrices; modes of N/2 nodal diameters are real but for that phase."""
    rng = np.random.default_rng(sectors)
    with h5py.File(path, "w") as file:
        file.attrs["force_names"] = ["lift", "drag"]
        for h in range(sectors // 2 + 1):
            real = h in (0, sectors / 2)

            def random(*shape):
                return rng.normal(size=shape) + (0 if real else 1j) * rng.normal(size=shape)
            X, Y = random(CONTACT, CONTACT), random(CONTACT, CONTACT)
            turn = np.exp(1j * phase * np.arange(MODES)) if 2 * h == sectors else 1
            values = {"Kaa": rng.uniform(1, 9, MODES), "Kxx": X @ X.conj().T, "Mxx": Y @ Y.conj().T + 9 * np.eye(CONTACT),
                      "Max": 0.3 * (turn * random(CONTACT, MODES)).T, "Fa": random(2, MODES) * turn, "Fx": random(2, CONTACT)}
            for name, value in values.items():
                if h == 0:
                    file[name] = value
                else:
                    file[f"cyclic/{h}/{name}"] = value if name == "Kaa" else np.stack([value.real, value.imag + 0 * value.real], axis=-1)
        file["R"] = rng.normal(size=CONTACT)


def results_of(sectors, order):
    wave = TravellingWave(sectors, order, spatial_index(H, order, sectors))
    return SimpleNamespace(wave=wave, modes=MODES, contact_points=CONTACT // 3, path="results.h5")


def matrices(reduced):
    return scipy.linalg.block_diag(np.diag(reduced.kaa), reduced.kxx), np.block([
        [np.eye(len(reduced.kaa)), reduced.max], [reduced.max.conj().T, reduced.mxx]])


@pytest.mark.parametrize("sectors, phase", [(2, 0.0), (5, 0.0), (6, 0.0), (6, 1.3)])
def test_frequencies_are_those_of_all_nodal_diameters(tmp_path, sectors, phase):
    random_sector(tmp_path / "sector.h5", sectors, phase)
    results, expected = results_of(sectors, 1), []
    with h5py.File(tmp_path / "sector.h5") as file:
        wheel = unrolled(file, results)
        for h in range(sectors):
            index = min(h, sectors - h)
            model = reduced_of(file, results)[0] if index == 0 else of_index(file, results, index)
            expected += scipy.linalg.eigh(*matrices(model), eigvals_only=True).tolist()
    assert wheel.reduced.kxx.dtype == float and wheel.loads[:3] == [("lift", 0), ("drag", 0), ("lift", 1)]
    found = scipy.linalg.eigh(*matrices(wheel.reduced), eigvals_only=True)
    np.testing.assert_allclose(found, np.sort(expected), rtol=0, atol=1e-12 * max(expected))


@pytest.mark.parametrize("sectors, order, phase", [(2, 1, 0.4), (5, 2, 0.0), (6, 1, 1.3), (6, -1, 0.0), (6, 3, 1.3), (7, 4, 0.0),
                                                   (6, 0, 0.0)])
def test_a_wave_in_the_sector_is_one_in_the_wheel(tmp_path, sectors, order, phase):
    """Without contact forces: forces of the structure in any wave, and the loads, are those of every sector."""
    random_sector(tmp_path / "sector.h5", sectors, phase)
    results, rng = results_of(sectors, order), np.random.default_rng(1)
    with h5py.File(tmp_path / "sector.h5") as file:
        wheel = unrolled(file, results)
        models = [reduced_of(file, results)[0], *(of_index(file, results, h) for h in range(1, sectors // 2 + 1))]
    courses = rng.normal(size=(2, 2 * H + 1))
    by_sector = [results.wave.of_sector(courses[("lift", "drag").index(name)], j) for name, j in wheel.loads]
    damping = Damping(0.02, 0.1)
    one = SectorBalance(models, results.wave.index, NO_CONTACT, None, damping, courses, H, 16)
    all_of_them = HarmonicBalance(wheel.reduced, NO_CONTACT, None, damping, by_sector, H, 16)
    q = rng.normal(size=(MODES + CONTACT, 2 * H + 1))
    forces = one.structure(q, 1.7) - one.excitation
    found = all_of_them.structure(wave_of_wheel(results.wave, q, MODES, wheel.phases), 1.7) - all_of_them.excitation
    np.testing.assert_allclose(found, wave_of_wheel(results.wave, forces, MODES, wheel.phases), rtol=0, atol=1e-12 * np.abs(found).max())


def test_modes_of_half_the_sectors_that_are_not_real_are_refused(tmp_path):
    random_sector(tmp_path / "sector.h5", 6)
    with h5py.File(tmp_path / "sector.h5", "r+") as file:
        file["cyclic/3/Max"][0, 0, 1] += 0.1
        with pytest.raises(ValueError, match="results.h5: modes of N/2 nodal diameters are not real"):
            unrolled(file, results_of(6, 1))
