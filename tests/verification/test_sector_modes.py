"""Nonlinear modes of a sector, waves that travel round the disk: against the equations of the whole rotor, the program itself on all
sectors where the wave stands, peaks of forced motions, and linear modes.
"""

import h5py
import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
from scipy.sparse.linalg import splu

import cases
import cyclic_sector
import launch
import sector_model
import whole_rotor
from cyclic_sector import DATA, N
from dovetail import Results, reference
from dovetail.modes import Backbone
from small_wave import SHROUD, scene

DAMPING = float(DATA["sector/xi"])
GIVEN = cyclic_sector.given("eo2_separation")
AMPLITUDE = (1e-6, 2e-4)


def mode(folder, order, wish="number = 1", amplitude=AMPLITUDE, ranks=None, status=0, **keys):
    more = f"mode = {{ {wish}, amplitude = {list(amplitude)} }}\n"
    return launch.run(scene(folder, order, omega="", more=more, **{"friction": SHROUD, **keys}), ranks=ranks, status=status)


def balanced(points):
    """What is dissipated is fed, at every point."""
    assert np.abs(points["energy_error"]).max() < 1e-10


def amplitudes(coefficients):
    """(H+1, n) of coefficients (n, 2H+1)."""
    return np.vstack([coefficients[:, 0], coefficients[:, 1::2].T - 1j * coefficients[:, 2::2].T])


class WholeRotor:
    """K, M and contacts of all sectors, in unknowns of whole_rotor.coordinates; motions from those of sector 0."""

    def __init__(self):
        pairs = [(a, b, axes, beyond) for a, b, _, axes, beyond in sector_model.contacts()]
        self.T, self.elastic = whole_rotor.coordinates(pairs)
        parts = {name: sp.csr_matrix(tuple(DATA[f"sector/{name}_{part}"] for part in ("data", "indices", "indptr"))) for name in "KM"}
        self.K, self.M = (self.T.T @ sp.block_diag([parts[name]] * N) @ self.T for name in "KM")
        self.contact = reference.Contact(np.tile(GIVEN["kn"], N), np.tile(GIVEN["kt"], (N, 1)), np.tile(SHROUD, (N, 1)),
                                         np.tile(GIVEN["gap"], N))
        self.bases = [model["basis"] for model in cyclic_sector.of_every_index("eo2_separation")]
        self.free = np.repeat(3 * sector_model.FREE, 3) + np.tile(range(3), len(sector_model.FREE))
        self.solve = splu((self.T.T @ self.T).tocsc()).solve

    def motion(self, q, order):
        """Amplitudes (H+1, unknowns) from those of sector 0, (H+1, n), and how far neighbours are from meeting."""
        found, apart = [], 0.0
        for k, own in enumerate(q):
            h = cyclic_sector.index(k, order)
            u = np.zeros(3 * whole_rotor.NODES, complex)
            u[self.free] = (self.bases[h] if h >= 0 else self.bases[-h].conj()) @ own
            U = np.concatenate([u * np.exp(-2j * np.pi * j * h / N) for j in range(N)])
            right = self.T.T @ U
            found.append(self.solve(right.real) + 1j * self.solve(right.imag))
            apart = max(apart, np.abs(self.T @ found[-1] - U).max() / max(np.abs(u).max(), 1e-300))
        return np.array(found), apart

    def residual(self, v, omega, zeta, preload, samples=8192):
        """Of the equations of a nonlinear mode, (H+1, unknowns), and the contact forces in it."""
        H = len(v) - 1
        X = np.zeros((len(self.contact.kn) * 3, 2 * H + 1))
        x = v[:, self.elastic:]
        X[:, 0], X[:, 1::2], X[:, 2::2] = x[0].real, x[1:].real.T, -x[1:].imag.T
        G = reference.contact.contact_coefficients(X.reshape(-1, 3, 2 * H + 1), self.contact, preload, samples).reshape(-1, 2 * H + 1)
        out = []
        for k, own in enumerate(v):
            w = k * omega
            stiff = 1 + 1j * w * DAMPING
            out.append(stiff * (self.K @ own) - (w**2 + 2j * k * zeta * omega**2) * (self.M @ own))
            out[-1][self.elastic:] += G[:, 0] if k == 0 else G[:, 2 * k - 1] - 1j * G[:, 2 * k]
        return np.array(out), G


@pytest.mark.parametrize("order", [1, pytest.param(-2, marks=pytest.mark.slow), pytest.param(8, marks=pytest.mark.slow)])
def test_all_sectors_swing_as_the_whole_rotor_does(tmp_path, order):
    """The motion of the sector, passed on from sector to sector, is a mode of the whole rotor, whose matrices it has not seen."""
    done = mode(tmp_path, order, harmonics=3, modes=None)
    results, rotor = Results(done.folder / "results.h5"), WholeRotor()
    balanced(done.points)
    preload = reference.Preload(*(np.tile(values, (N, 1)) for values in (results.xp.reshape(-1, 3), results.g.reshape(-1, 3), results.w)))
    slips = np.flatnonzero(results.points("slip") > 0)
    assert len(slips) > 3
    for point in (slips[len(slips) // 2], slips[-1]):
        omega, zeta = results.omega[point], results.points("damping_ratio")[point]
        v, apart = rotor.motion(amplitudes(results.coefficients[point]), order)
        assert apart < 1e-9
        left, G = rotor.residual(v, omega, zeta, preload)
        size = np.abs(G).max()
        assert np.abs(left).max() < 1e-6 * size  # samples of the reference
        # length 1 on one sector
        alpha = results.points("modal_amplitude")[point]
        assert abs(np.vdot(v[1], rotor.M @ v[1]).real / (N * alpha**2) - 1) < 1e-9
        # and it is no mode with another frequency, damping or sense
        assert np.abs(rotor.residual(v, omega, 0.99 * zeta, preload)[0]).max() > 1e-5 * size
        backward, _ = rotor.motion(amplitudes(results.coefficients[point]), -order)
        assert np.abs(rotor.residual(backward, omega, zeta, preload)[0]).max() > 1e-2 * size


@pytest.mark.slow
@pytest.mark.parametrize("order, number, at", [(0, 4, [2.5e-6, 2.56e-6]), (3, 3, [3.6e-5, 5.3e-5])])
def test_a_standing_wave_is_a_mode_of_all_sectors_in_the_program(tmp_path, order, number, at):
    """Sectors swing alike, or neighbours against each other. The whole rotor has sqrt(6) times the modal amplitude."""
    amplitude = (0.9 * at[0], 1.005 * at[-1])
    (folder := tmp_path / "sector").mkdir()
    done = mode(folder, order, f"number = {number}, at = {at}", amplitude, harmonics=1, modes=None)
    one = done.points
    with h5py.File(done.folder / "results.h5") as file:
        stuck = float(file["mode/omega"][0])
    path = whole_rotor.write(tmp_path, "eo3_aliased", 2000.0, samples=64)
    text = path.read_text().replace("samples = 64", 'samples = "exact", solver = "modal"').replace("harmonics = 7", "harmonics = 1")
    text = text.replace("step_tolerance = 1e-6, residual_tolerance = 1e-6", "step_tolerance = 1e-8, residual_tolerance = 1e-8")
    wanted = [float(a * np.sqrt(N)) for a in at]
    ends = [float(a * np.sqrt(N)) for a in amplitude]
    lines = [line for line in text.splitlines() if not line.startswith(("continuation.omega", "pattern", "fourier", "[["))]
    lines += [f"mode = {{ near = {stuck!r}, amplitude = {ends}, at = {wanted} }}", "[[excitation.load]]", 'pattern = "lift_0"',
              "fourier = [0, 1]"]
    path.write_text("\n".join(lines))
    with h5py.File(tmp_path / "model.h5", "r+") as file:
        file["contact/friction"][...] = np.tile(SHROUD, (N, 1))
    whole = launch.run(cases.Case(path, None, None, {})).points
    balanced(whole)
    for a, b in zip(at, wanted):
        i, j = (int(np.argmin(np.abs(points["modal_amplitude"] - value))) for points, value in ((one, a), (whole, b)))
        assert one["slip"][i] > 0
        assert abs(whole["omega"][j] / one["omega"][i] - 1) < 1e-8
        assert abs(whole["damping_ratio"][j] / one["damping_ratio"][i] - 1) < 1e-7
        fed = 2 * np.pi * one["damping_ratio"][i] * (one["omega"][i] * b) ** 2
        assert abs(whole["friction_energy"][j] - N * one["friction_energy"][i]) < 1e-6 * fed


@pytest.mark.parametrize("order", [1, pytest.param(-1, marks=pytest.mark.slow), pytest.param(2, marks=pytest.mark.slow)])
def test_peaks_of_forced_motions_lie_on_the_mode(tmp_path, order):
    """At the force level of the mode's end, as far as one mode tells."""
    (folder := tmp_path / "mode").mkdir()
    done = mode(folder, order, wish="number = 1, to_force = 1.0", amplitude=(1e-6, 1e-3), force=40.0)
    results = Results(done.folder / "results.h5")
    balanced(done.points)
    omega, zeta = results.omega[-1], results.points("damping_ratio")[-1]
    assert abs(results.points("force_level")[-1] - 1) < 1e-8 and results.points("slip")[-1] > 0
    resonance = omega * np.sqrt(1 - 2 * zeta**2)
    (folder := tmp_path / "forced").mkdir()
    more = f'continuation.watch = "x8.t1"\ncontinuation.at = [{resonance!r}]\n'
    forced = Results(launch.run(scene(folder, order, 40.0, omega=(0.995 * resonance, 1.005 * resonance), more=more,
                                      friction=SHROUD)).folder / "results.h5")
    peak = forced.peak("x8.t1")
    assert abs(peak[0] / resonance - 1) < 1e-3
    assert abs(peak[1] / results.amplitude("x8.t1")[-1] - 1) < 2e-2
    linear = results.amplitude("x8.t1")[0] * results.points("modal_amplitude")[-1] / results.points("modal_amplitude")[0]
    assert abs(linear / peak[1] - 1) > 5e-2, "a linear mode would not do"


@pytest.mark.parametrize("order, number", [(1, 1), (-1, 2), (2, 2), (3, 1), (0, 1), (7, 1)])
def test_it_begins_with_the_linear_mode_of_its_nodal_diameter(tmp_path, order, number):
    """Shape and frequency by the test's own matrices; of the wave in the other sense they are conjugate."""
    done = mode(tmp_path, order, wish=f"number = {number}", amplitude=(1e-9, 1e-8), harmonics=1)
    h = cyclic_sector.index(1, order)
    model = cyclic_sector.of_every_index("eo2_separation", 12)[abs(h)]
    turned = np.conj if h < 0 else np.asarray
    a, x = len(model["Kaa"]), len(model["Kxx"])
    springs = np.column_stack([GIVEN["kt"], GIVEN["kn"]]).ravel()
    K = scipy.linalg.block_diag(np.diag(model["Kaa"]), turned(model["Kxx"]) + np.diag(springs))
    M = np.block([[np.eye(a), turned(model["Mxa"]).conj().T], [turned(model["Mxa"]), turned(model["Mxx"])]])
    squares, shapes = scipy.linalg.eigh(K, M)
    with h5py.File(done.folder / "results.h5") as file:
        assert abs(file["mode/omega"][0] / np.sqrt(squares[number - 1]) - 1) < 1e-9
        shape = file["mode/shape"][()] @ [1, 1j]
    assert abs(abs(np.vdot(shapes[:, number - 1], M @ shape)) - 1) < 1e-8 and len(shape) == a + x
    motion = amplitudes(done.points["coefficients"][0])[1] / done.points["modal_amplitude"][0]
    assert abs(np.vdot(shape, M @ motion) - 1) < 1e-3  # in phase; damping moves it a little
    assert f"mode {number} of nodal diameter {abs(h)}" in done.out


@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_ranks_do_not_change_the_mode(tmp_path, ranks):
    found = []
    for count in (None, ranks):
        (folder := tmp_path / str(count)).mkdir()
        done = mode(folder, 1, wish="number = 1, at = [1.2e-4]", amplitude=(6e-5, 1.25e-4), ranks=count, harmonics=3)
        points = done.points
        balanced(points)
        with h5py.File(done.folder / "results.h5") as file:
            shape = file["mode/shape"][()]
        i = int(np.argmin(np.abs(points["modal_amplitude"] - 1.2e-4)))
        assert points["slip"][i] > 0
        found.append((points["omega"][i], points["damping_ratio"][i], points["coefficients"][i], shape))
    for one, other in zip(*found):
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-8 * np.abs(one).max())


def test_a_load_of_another_nodal_diameter_does_no_work(tmp_path):
    """Harmonic 2 of engine order 1 has nodal diameter 2."""
    def edit(text):
        return text.replace("fourier = [0.0, 9.0]", "fourier = [0, 0, 0, 9.0]")

    done = mode(tmp_path, 1, amplitude=(1e-9, 1e-8), harmonics=3, edit=edit)
    assert np.isinf(done.points["force_level"]).all()
    (folder := tmp_path / "refused").mkdir()
    refused = mode(folder, 1, wish="number = 1, to_force = 1.0", harmonics=3, status=2, edit=edit)
    assert "does no work on mode 1" in refused.err


@pytest.mark.slow
def test_forced_motions_from_the_mode(tmp_path):
    """Synthesised, refined by the NumPy equations, and solved by the program at that frequency."""
    (folder := tmp_path / "mode").mkdir()
    done = mode(folder, 1, wish="number = 1, to_force = 1.2", amplitude=(1e-6, 1e-3), force=40.0, harmonics=3)
    backbone = Backbone.read(Results(done.folder / "results.h5"), samples=2048)
    motion, = backbone.peaks()
    refined = backbone.refine(motion)
    error = np.linalg.norm((refined.coefficients - motion.coefficients)[:, 1:]) / np.linalg.norm(refined.coefficients[:, 1:])
    assert error < 2e-2 and 0.5 < backbone.error(motion) / error < 2
    (folder := tmp_path / "forced").mkdir()
    omega = motion.omega
    more = f"continuation.at = [{omega!r}]\n"
    case = scene(folder, 1, 40.0, 3, omega=(0.998 * omega, 1.002 * omega), more=more, friction=SHROUD)
    forced = Results(launch.run(case).folder / "results.h5")
    solved = forced.coefficients[np.flatnonzero(forced.omega == omega)[0]]
    np.testing.assert_allclose(refined.coefficients[:, 1:], solved[:, 1:], rtol=0, atol=1e-5 * np.abs(solved).max())
    with pytest.raises(ValueError, match="harmonic 2 of the load has index 2, the mode of a sector 1"):
        backbone.peaks(harmonic=2)


@pytest.mark.parametrize("law", ["coulomb", "cone"])
def test_what_gives_way_first(tmp_path, law):
    """Instant by instant over half a period, both senses: friction reaches its bound, or the normal force is gone."""
    friction = SHROUD if law == "coulomb" else np.full((8, 2), 0.7)
    done = mode(tmp_path, 1, amplitude=(1e-9, 1e-8), harmonics=1, friction=friction,
                edit=lambda text: f'contact.law = "{law}"\n{text}')
    results = Results(done.folder / "results.h5")
    with h5py.File(done.folder / "results.h5") as file:
        phi, onset = (file["mode/shape"][()] @ [1, 1j])[12:].reshape(8, 3), file["mode/onset"][0]
    g, theta, least = results.g.reshape(-1, 3), np.linspace(0, np.pi, 20001), np.inf
    for p in range(8):
        x = (phi[p][:, None] * np.exp(1j * theta)).real
        t, n = GIVEN["kt"][p][:, None] * x[:2], GIVEN["kn"][p] * x[2]
        least = min(least, g[p, 2] / np.abs(n).max())
        for d in range(2) if law == "coulomb" else ():
            for sense in (1, -1):
                rate = np.abs(t[d] - sense * friction[p, d] * n).max()
                least = min(least, (friction[p, d] * g[p, 2] - sense * g[p, d]) / rate)
        if law == "cone":  # |T + a t|^2 = mu^2 (N + a n)^2
            A, B, C = (np.sum(u * v, axis=0) - friction[p, 0] ** 2 * a * b for u, v, a, b in (
                (t, t, n, n), (g[p, :2, None], t, g[p, 2], n), (g[p, :2], g[p, :2], g[p, 2], g[p, 2])))
            root = np.sqrt(np.maximum(B**2 - A * C, 0))
            places = np.abs(np.concatenate([(-B + root) / A, (-B - root) / A])[np.tile(B**2 - A * C >= 0, 2)])
            least = min(least, places.min())
    assert abs(onset / least - 1) < 1e-6
