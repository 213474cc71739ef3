"""The command `verify`: runs of every kind hold, and results that were tampered with do not."""

from types import SimpleNamespace

import h5py
import numpy as np
import pytest

import cases
import cyclic_sector
import test_nonlinear_modes
import test_paths
from dovetail import Results, reference, verify
from dovetail.__main__ import main
from dovetail.hdf5_read import words
from dovetail.reduced_system import equations
from dovetail.verify_bounds import scaled_forces
from launch import run

FEW = {"harmonics": 3, "omega": [0.8, 1.2]}
SAMPLES = 1024  # in place of MANY, for speed


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(verify, "MANY", SAMPLES)


@pytest.fixture(scope="module")
def exact(tmp_path_factory):
    case = cases.several_points(tmp_path_factory.mktemp("exact"), samples="exact", kind="auto", **FEW)
    return run(case, out="out").folder


@pytest.fixture(scope="module")
def runs(exact, tmp_path_factory):
    return {"exact": exact, 64: run(cases.several_points(tmp_path_factory.mktemp("sampled"), **FEW), out="out").folder}


@pytest.fixture
def copy(exact, tmp_path):
    for name in ("results.h5", "reduced.h5"):
        (tmp_path / name).write_bytes((exact / name).read_bytes())
    return tmp_path / "results.h5"


def said(path, capsys, *options, status=0):
    assert main(["verify", path, *options]) == status
    return capsys.readouterr()


def test_an_exact_run_holds(exact, capsys):
    out = said(exact / "results.h5", capsys, "--points", 3).out
    assert out.count("holds") == 3 and "verified: 3 of " in out.splitlines()[-1] and f"{SAMPLES} samples" in out
    found = verify.verdict(Results(exact / "results.h5"), 12, SAMPLES)
    assert found.rubbed > 0.1 * found.work and found.residual < 1e-4 and found.sampling is None


def test_forces_at_few_samples_hold_by_their_own_equations(tmp_path, capsys):
    done = run(cases.several_points(tmp_path, **FEW), out="out")
    assert "forces at 64 samples" in said(done.folder / "results.h5", capsys, "--points", 2).out
    found = verify.verdict(Results(done.folder / "results.h5"), 12, SAMPLES)
    assert found.residual < 1e-9 and 1e-5 < found.sampling < 1e-2 and not found.complaints


def test_the_phase_of_the_load_does_not_matter(tmp_path):
    bounds = []
    for name, fourier in (("a", [0, 0, 1]), ("b", [0, 0.5**0.5, 0.5**0.5])):  # an eighth of a period, two samples of the run
        (tmp_path / name).mkdir()
        done = run(cases.dof5(tmp_path / name, samples=16, harmonics=3, fourier=fourier, omega=[1.0, 1.0]), out="out")
        found = verify.verdict(Results(done.folder / "results.h5"), 0, SAMPLES)
        assert not found.complaints and found.energy > 1e-6
        bounds.append(found.energy_bound)
    assert bounds[1] == pytest.approx(bounds[0], rel=1e-3)


@pytest.mark.parametrize("parameter", [
    "gap", *(pytest.param(name, marks=pytest.mark.slow) for name in ("damping", "friction_1", "preload", "force"))])
def test_values_of_a_path_are_in_the_equations(tmp_path, parameter, capsys):
    case = test_paths.path_of(tmp_path, parameter, test_paths.RANGES[parameter], harmonics=3, samples=64)
    said(run(case, out="out").folder / "results.h5", capsys, "--points", 3)


def test_a_nonlinear_mode_is_fed_by_its_negative_damping(tmp_path, capsys):
    case, _ = test_nonlinear_modes.scene(tmp_path, "dof5")
    folder = run(case, out="out").folder
    said(folder / "results.h5", capsys, "--points", 3)
    with h5py.File(folder / "results.h5", "r+") as file:
        file["points/damping_ratio"][-1] *= 1.01
    assert "the energy is off" in said(folder / "results.h5", capsys, "--points", 2, status=3).err


def motion(file):
    file["points/coefficients"][-1, 7, 1] *= 1.001


def told(file):
    file["points/residual"][-1] = 2e-8


def peak(file):
    file["events/amplitude"][np.flatnonzero(file["events/amplitude"][()])] *= 1 + 1e-6


def estimate(file):
    file["points/error_harmonics"][:] *= 1e-3


def frequency(file):
    file["points/omega"][-1] *= 1.001


def energy(file):
    file["points/contact/dissipation"][-1] *= 1.01


def preload(file):
    file["preload/xp"][2] += 1e-3


@pytest.mark.parametrize("change, words", [(motion, "allowed"), (frequency, "residual"), (energy, "dissipation is off"),
                                           (preload, "preload: forces are off"), (told, "/points/residual is 2.0e-08"),
                                           (peak, "/events/amplitude is"), (estimate, "estimated errors: ")])
def test_results_that_were_tampered_with_fail(copy, change, words, capsys):
    with h5py.File(copy, "r+") as file:
        change(file)
    err = said(copy, capsys, "--points", 2, status=3).err
    assert words in err and "does not hold" in err


@pytest.mark.parametrize("taken, samples", [(64, SAMPLES), pytest.param("exact", 65536, marks=pytest.mark.slow)])
def test_a_harmonic_that_is_off_by_a_hundred_thousandth_of_its_size_is_found(runs, taken, samples, monkeypatch):
    results = Results(runs[taken] / "results.h5")
    point = results.largest_point(results.watched)
    stored = results.coefficients_at(point)

    def complaints(harmonic, part):
        q = stored.copy()
        q[:, max(0, 2 * harmonic - 1):2 * harmonic + 1] *= 1 + part
        monkeypatch.setattr(results, "coefficients_at", lambda _: q)
        return verify.verdict(results, point, samples).complaints
    assert not complaints(0, 0.0)
    assert all("the residual" in complaints(harmonic, 1e-5)[0] for harmonic in range(4))


def test_the_residual_is_the_one_that_newtons_method_has_left(tmp_path):
    done = run(cases.several_points(tmp_path, kind="auto", max_points=6, **FEW | {"step_tolerance": 0.01, "residual_tolerance": 0.01}))
    results = Results(done.folder / "results.h5")
    system = equations(results)
    for point in range(1, 6):
        q, omega = results.coefficients_at(point), results.omega[point]
        modes, contacts = np.split(system.residual(q, omega), [system.modes])
        own = np.hypot(*(np.linalg.norm(part) / unit for part, unit in zip((modes, contacts), scaled_forces(results, system))))
        assert own == pytest.approx(results.points("residual")[point], rel=1e-4) and own > 1e-10


def one_point(folder, fa, fx, **settings):
    """A reduced model of modes with these forces, and a mass of its own that rubs at one contact point."""
    modes = len(fa)
    model = reference.Reduced(kaa=np.arange(1.0, modes + 1), max=np.zeros((modes, 3)), mxx=np.eye(3), kxx=np.eye(3), fa=np.array(fa),
                              fx=np.array(fx), r=np.array([0.0, 0, -1]))
    cases.write_reduced(folder, model)
    return cases.write(folder, "one point", "reduced.h5", None, model, settings, stiffness=0.05, fourier=[0, 1],
                       normal_stiffness=10.0, tangential_stiffness=0.5, friction=0.5, gap=0.0, harmonics=1, kind="auto")


def hardly_moved(folder):
    """By the load, the first mode: a ten-thousandth of what moves the second."""
    return one_point(folder, [1e-4, 1.0], [0.1, 0, 0], omega=[0.5, 0.6])


def a_mode(folder):
    return test_nonlinear_modes.scene(folder, "dof5")[0]


def a_peak_without_modes(folder):
    case = one_point(folder, [], [0.4, 0, 0], omega=[0.1, 0.3], unit="Hz")
    text = case.path.read_text().replace("[continuation]", '[continuation]\nwatch = "x1.t1"')
    case.path.write_text(text + '\n[path]\nparameter = "force"\nrange = [1, 1.1]\npeak = "amplitude"\n')
    return case


@pytest.mark.parametrize("scene", [hardly_moved, a_mode, a_peak_without_modes])
def test_units_are_those_of_the_run(tmp_path, scene):
    folder = run(scene(tmp_path), out="out").folder
    results = Results(folder / "results.h5")
    with h5py.File(folder / "state.h5") as file:
        frequency, modal, contact = file["scales"][()]
    force = modal * frequency**2
    np.testing.assert_allclose(scaled_forces(results, equations(results)), [force, force * modal / contact], rtol=1e-6)


def test_work_that_is_made_of_rounding_errors_is_no_balance():
    """Of points that stick, without damping: the energy is off by all of it, and may be."""
    sticks = SimpleNamespace(point=0, residual=1e-12, energy=1.0, energy_bound=1e12)
    slips = SimpleNamespace(point=3, residual=1e-9, energy=2e-9, energy_bound=1e-8)
    assert verify.summed_up([sticks, slips], 9).endswith("energy balances to 2.0e-09, at point 3")
    assert verify.summed_up([sticks], 9).endswith("there is no energy to balance")


def test_a_peak_that_is_none_is_found(copy, capsys):
    results = Results(copy)
    amplitudes = [results.amplitude(dof) for dof in results.dof_names()]
    with h5py.File(copy, "r+") as file:
        names = words(file["events/kind"], "names").split()
        rows = np.flatnonzero(file["events/kind"][()] == names.index("peak"))
        row = rows[np.argmax(file["events/amplitude"][rows])]
        dof = int(file["events/unknown"][row])
        point = next(i for i in range(file["events/point"][row], len(results)) if amplitudes[dof][i] < 0.99 * amplitudes[dof][i - 1])
        file["events/point"][row], file["events/amplitude"][row], file["points/located"][point] = point, amplitudes[dof][point], 1
    assert "is no maximum" in said(copy, capsys, "--points", 1, status=3).err


def test_files_that_are_not_those_of_the_run_are_refused(copy, capsys):
    assert "format must be dovetail-results" in said(copy.parent / "reduced.h5", capsys, status=2).err
    with h5py.File(copy.parent / "reduced.h5", "r+") as file:
        file.attrs["fingerprint"] = "another"
    assert "another fingerprint" in said(copy, capsys, status=2).err
    (copy.parent / "text.h5").write_text("no HDF5\n")
    assert "text.h5" in said(copy.parent / "text.h5", capsys, status=2).err


def test_what_cannot_be_judged_is_said(copy, capsys):
    assert "not judged: stability" in said(copy, capsys, "--points", 1).out
    (copy.parent / "reduced.h5").unlink()
    assert "reduced.h5" in said(copy, capsys, status=2).err
    assert "--points 0" in said(copy, capsys, "--points", 0, status=2).err


class LargestFirst:
    """Of 11 points, the first is the largest, and two are peaks."""

    watched = "a1"

    def __len__(self):
        return 11

    def largest_point(self, _):
        return 0

    class events:
        @staticmethod
        def of(_):
            return SimpleNamespace(point=np.array([7, 3]))


def test_points_are_the_ends_the_largest_and_others(exact):
    results = Results(exact / "results.h5")
    found = verify.looked_at(results, 5)
    assert len(found) == 5 and found[0] == 0 and found[-1] == len(results) - 1 and results.largest_point(results.watched) in found
    assert verify.looked_at(LargestFirst(), 3) == [0, 5, 10]  # an end is the largest: no other goes for it
    assert verify.looked_at(LargestFirst(), 4) == [0, 3, 7, 10] and verify.looked_at(LargestFirst(), 5) == [0, 2, 5, 7, 10]
    assert verify.looked_at(results, 10**6) == list(range(len(results)))


@pytest.mark.slow
def test_a_cone_holds(tmp_path, capsys):
    case = cases.several_points(tmp_path, law="cone", friction=0.3, samples="exact", kind="auto", harmonics=2, omega=[1.0, 1.0])
    said(run(case, out="out").folder / "results.h5", capsys)


@pytest.mark.slow
def test_a_sector_holds(tmp_path, capsys):
    name = list(cyclic_sector.CASES)[0]
    omega = float(cyclic_sector.DATA[f"{name}/omega"][1])
    path, models = cyclic_sector.write(tmp_path, name, omega, modes=20)
    answer = cyclic_sector.FEW[f"{name}/X_modes20"][1]
    cyclic_sector.write_start(tmp_path, name, omega, models, answer.reshape(-1, answer.shape[-1]))
    said(run(cases.Case(path, None, None, {})).folder / "results.h5", capsys)
