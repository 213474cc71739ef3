"""Several load patterns: against one, against the reference, closed forms of a rotating force, and time integration."""

from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.linalg

import cases
import launch
import truth
from dovetail import reference
from test_against_core import close, run

DATA = Path(__file__).parent / "data/damping.npz"
PATTERNS = {"lift": [0, 1, 0, 0, 0.2], "drag": [0.3, 0, -0.8, 0.1]}


def two_patterns(folder, **overrides):
    """The four contact points of `cases.several_points` under two patterns, of which some slip and some lift off."""
    structure = cases.random_structure()
    structure.force = np.random.default_rng(3).normal(size=(2, structure.force.size))
    return cases.several_points(folder, structure=structure, loads=PATTERNS, **overrides)


@pytest.fixture(scope="module")
def branch(tmp_path_factory):
    return run(two_patterns(tmp_path_factory.mktemp("branch"), omega=[0.8, 1.2]))


def test_every_point_solves_the_reference_equations(branch):
    system = branch.case.system()
    limit = 1e-8 * np.linalg.norm(system.excitation)
    assert len(branch.omega) > 5 and np.abs(branch.q).max() > 0.1
    for omega, q in zip(branch.omega, branch.q):
        assert np.linalg.norm(system.residual(q, omega)) < limit, f"at omega = {omega}"


def test_reduction(branch):
    r = branch.case.reduced
    with h5py.File(branch.directory / "reduced.h5", "r") as file:
        names = [name if isinstance(name, str) else name.decode() for name in file.attrs["force_names"]]
        rows = [names.index(name) for name in PATTERNS]
        assert file["Fa"].shape == (2, r.kaa.size) and file["left_out/Fa"].shape[0] == 2
        close(file["Fa"][()][rows], r.fa, 1e-9)
        close(file["Fx"][()][rows], r.fx, 1e-9)


@pytest.mark.slow
def test_ranks_do_not_change_the_branch(branch):
    together = run(branch.case, 2)
    close(together.omega, branch.omega, 1e-8)
    close(together.q, branch.q, 1e-8)


def test_the_reduced_file_is_a_model_of_its_own(branch, tmp_path):
    """Read back from a file, and with one of its patterns alone."""
    text = branch.case.path.read_text().replace('model = "model.h5"', f'reduced = "{branch.directory / "reduced.h5"}"')
    text = text.replace("[reduction]\nmodes = 5\n", "")
    case = cases.Case(tmp_path / "case.toml", None, branch.case.reduced, branch.case.settings)
    case.path.write_text(text)
    np.testing.assert_array_equal(launch.run(case).points["coefficients"], branch.q)
    case.path.write_text(text[:text.index('[[excitation.load]]\npattern = "drag"')])
    alone = launch.run(case).points
    r, s = case.reduced, case.settings
    one = reference.Reduced(r.kaa, r.max, r.mxx, r.kxx, r.fa[0], r.fx[0], r.r)
    system = reference.HarmonicBalance(one, branch.case.contact, branch.case.preload, s["stiffness"], PATTERNS["lift"], s["harmonics"],
                                       s["samples"])
    for omega, q in zip(alone["omega"], alone["coefficients"]):
        assert np.linalg.norm(system.residual(q, omega)) < 1e-8 * np.linalg.norm(system.excitation)


@pytest.mark.parametrize("form, ranks", [("modal", 1), *(pytest.param(*other, marks=pytest.mark.slow) for other in
                                                         (("modal", 2), ("assembled", 1)))])
def test_two_halves_are_one(form, ranks, tmp_path):
    """Two equal patterns with half the course each: the same curve. Scales are chosen from the loads."""
    settings = {"omega": [0.8, 1.2], "solver": form, "kind": "auto", "samples": None}
    (tmp_path / "one").mkdir(), (tmp_path / "two").mkdir()
    one = run(cases.several_points(tmp_path / "one", **settings), ranks)
    structure, course = cases.random_structure(), [0.1, 0.5, 0.25, 0, 0.15]
    structure.force = np.array([structure.force, structure.force])
    loads = {"half": course, "other half": course}
    two = run(cases.several_points(tmp_path / "two", structure=structure, loads=loads, **settings), ranks)
    close(two.omega, one.omega, 1e-9)
    close(two.q, one.q, 1e-8)
    estimated = []
    for done in (one, two):  # by the load on modes that are left out, too
        with h5py.File(done.directory / "results.h5") as file:
            estimated.append(file["points/error_modes"][()])
    assert np.nanmax(estimated[0]) > 1e-3
    np.testing.assert_allclose(*estimated, rtol=1e-5)


# Two points opposite each other on an axisymmetric body: masses m on springs k and damping, tied to each other by springs.
RING = {"m": 1.3, "k": 4.0, "tie": 2.0, "xi": 0.02, "kt": 5.0, "kn": 50.0, "mu": 0.3, "press": 4.0}


def ring(folder, law, omega, force, **overrides):
    """A force that goes round with omega on both points alike: patterns along t1 and t2, 90 degrees apart."""
    p = RING
    K = scipy.linalg.block_diag(1, np.kron([[p["k"] + p["tie"], -p["tie"]], [-p["tie"], p["k"] + p["tie"]]], np.eye(3)))
    along = np.hstack([np.zeros((2, 1)), np.tile(np.eye(3)[:2], 2)])  # the first dof is a mass by itself
    structure = cases.Structure(K, p["m"] * np.eye(7), np.arange(1, 7).reshape(2, 3), force * along,
                                np.array([0, *2 * [0, 0, p["press"]]]))
    settings = dict(modes=1, stiffness=p["xi"], normal_stiffness=p["kn"], tangential_stiffness=p["kt"], friction=p["mu"], gap=0.0,
                    initial=0.0, law=law, harmonics=3, omega=[omega, omega], kind="auto", **cases.TIGHT)
    loads = {"along t1": [0, 1], "along t2": [0, 0, 1]}
    return cases.full(folder, "a force that goes round", structure, overrides, loads=loads, **settings)


def expected_ring(q):
    """Every point goes round: t2 follows t1 by a quarter period; n rests. The complex amplitude of t1."""
    q = q[1:]
    for point in (q[:3], q[3:]):
        np.testing.assert_allclose(point[1, 2], point[0, 1], rtol=1e-8)
        np.testing.assert_allclose(point[1, 1], -point[0, 2], rtol=0, atol=1e-8 * np.abs(point).max())
        np.testing.assert_allclose(point[2], 0, atol=1e-9)
        np.testing.assert_allclose(point[:, 3:], 0, atol=1e-9)
    np.testing.assert_allclose(q[3:], q[:3], rtol=0, atol=1e-10)
    return q[0, 1] - 1j * q[0, 2]


def ring_stiffness(omega):
    return RING["k"] * (1 + 1j * omega * RING["xi"]) - omega ** 2 * RING["m"]


@pytest.mark.parametrize("law", ["coulomb", "cone"])
def test_a_force_goes_round_and_nothing_slips(law, tmp_path):
    """A linear answer: F / (k (1 + i omega xi) + kt - m omega^2). Both preloads are those of the springs in series."""
    omega, force = 2.3, 0.1
    found = expected_ring(run(ring(tmp_path, law, omega, force)).q[0])
    wanted = force / (ring_stiffness(omega) + RING["kt"])
    assert abs(found - wanted) < (1e-9 if law == "coulomb" else 1e-6) * abs(wanted)


def test_a_force_goes_round_and_the_cone_slips(tmp_path):
    """T, of size mu N, points along the slider's velocity, and so at right angles to its place w: |x|^2 = |w|^2 + R^2, R = mu N / kt.

    In the phase of x = X: T = kt (R^2 + i R sqrt(X^2 - R^2)) / X. Sampled forces come near with 1 / N^2.
    """
    omega, X = 2.3, 0.6
    normal = RING["press"] * RING["kn"] / (RING["kn"] + RING["k"])
    R = RING["mu"] * normal / RING["kt"]
    assert X > 2 * R
    force = ring_stiffness(omega) * X + RING["kt"] * (R ** 2 + 1j * R * np.sqrt(X ** 2 - R ** 2)) / X
    off = []
    for samples in (64, 128):
        done = run(ring(tmp_path, "cone", omega, abs(force), samples=samples))
        off.append(abs(expected_ring(done.q[0]) - X * abs(force) / force))
    assert off[1] < 1e-3 * X and off[1] < 0.27 * off[0]


def test_in_time(tmp_path):
    """H = 40, forces from event to event, against the integrated full model."""
    loads = {"first": [0, 0, 1], "second": [0, 1, 0, 0, 0.4]}
    force = [[1.0, 1, 0, 0, 0], [0, 0.4, 0, 0.3, 0]]
    case = cases.dof5(tmp_path, force, loads=loads, harmonics=40, samples=None, omega=[1.05, 1.05], **cases.TIGHT)
    q, structure = run(case).q[0], case.structure
    start = structure.static_state(case.preload.xp)
    orbit = truth.steady_state(structure.M, case.settings["stiffness"], structure.K, structure.contact_dofs, case.contact, structure.force,
                               list(loads.values()), structure.preload, 1.05, start, case.preload.w)
    assert len(np.unique(orbit.states)) > 2, "nothing slips"
    integrated = (orbit.u - start)[:, structure.contact_dofs.ravel()].T
    np.testing.assert_allclose(reference.synthesis(q[2:], integrated.shape[1]), integrated, rtol=0, atol=2e-5)


@pytest.mark.slow
def test_restart_knows_the_loads(tmp_path):
    case = two_patterns(tmp_path, omega=[0.8, 1.2], max_points=4)
    text = case.path.read_text()
    launch.run(case, out="parts")
    case.path.write_text(text.replace("max_points = 4\n", ""))
    whole, parts = launch.run(case, out="whole").points, launch.run(case, "--restart", out="parts").points
    np.testing.assert_array_equal(parts["coefficients"], whole["coefficients"])
    case.path.write_text(text.replace("fourier = [0.3, 0, -0.8, 0.1]", "fourier = [0.3, 0, -0.8, 0.2]"))
    done = launch.run(case, "--restart", out="parts", status=2)
    assert "excitation.load = lift [0, 1, 0, 0, 0.2], drag [0.3, 0, -0.8, 0.2]: this run began with lift" in done.err


def test_loads_of_another_program(tmp_path):
    """Motions by a prototype that shares nothing with this program: nine dofs, two patterns with their series, damping a M + b K.

    The equations with the program's reduced matrices and loads: modes to 1e-8 of the load; contact forces, which slip and
    lift off, are sampled here, 1e-5.
    """
    d = np.load(DATA)
    structure = cases.Structure(d["K"], d["M"], d["contact_dofs"], d["F"], d["P"])
    loads = {"one": d["fourier_1"].tolist(), "two": d["fourier_2"].tolist()}
    case = cases.full(tmp_path, "nine dofs", structure, {}, modes=6, stiffness=0.0, loads=loads, initial=0.0, harmonics=int(d["H"]),
                      omega=[0.9, 0.9], normal_stiffness=float(d["kn"]), tangential_stiffness=float(d["kt"]), friction=float(d["mu"]),
                      gap=float(d["gap"]))
    launch.run(case, command="reduce")
    with h5py.File(tmp_path / "reduced.h5") as file:
        r = reference.Reduced(*(file[name][()] for name in ("Kaa", "Max", "Mxx", "Kxx", "Fa", "Fx", "R")))
        phi, psi = (file[f"recovery/{name}"][()][np.argsort(file["recovery/elastic_dofs"][()])] for name in ("Phi", "Psi"))
    case.reduced = r
    system, (a, b), e = case.system(samples=4096), d["rayleigh_ab"], reference.split(d["K"], d["M"], d["contact_dofs"])[0]
    for omega, motion in zip(d["omega"], d["rayleigh"]):
        x = motion[d["contact_dofs"][0]]  # in all, as the elastic dofs are
        modal = phi.T @ d["M"][np.ix_(e, e)] @ (motion[e] - psi @ x)
        x[:, 0] -= 2 * case.preload.xp[0]
        q = np.vstack([modal, x])
        stiffness = system.harmonic_blocks(lambda k: system.K - (k * omega) ** 2 * system.M,
                                           lambda k: k * omega * (a * system.M + b * system.K))
        left = (stiffness @ q.ravel()).reshape(q.shape) - system.excitation
        left[6:] += reference.contact_coefficients(x[None], case.contact, case.preload, 4096)[0]
        assert np.abs(left[:6]).max() < 1e-8 * np.abs(system.excitation).max()
        assert np.abs(left[6:]).max() < 1e-5 * np.abs(system.excitation).max()
