"""The exact evaluation of the contact laws: whole branches against the reference, energy, and time integration."""

import numpy as np
import pytest

import cases
import truth
from dovetail import Results, reference
from test_against_core import BRANCHES, run

SWEEPS = {"dof5": {}, "check 1": {"omega": [14, 11]}, "check 2": {"omega": [13, 11.6], "harmonics": 5},
          "several points": {"omega": [0.8, 1.2]}}
MAKE = {"dof5": lambda folder, **o: cases.dof5(folder, **cases.TIGHT, **o),
        "check 1": lambda folder, **o: cases.single_mass(folder, 1, **o),
        "check 2": lambda folder, **o: cases.single_mass(folder, 2, **o), "several points": cases.several_points}
assert set(SWEEPS) == set(BRANCHES)


@pytest.fixture(scope="module", params=SWEEPS)
def branch(request, tmp_path_factory):
    return run(MAKE[request.param](tmp_path_factory.mktemp("exact"), samples="exact", **SWEEPS[request.param]))


def residuals(done, samples):
    """Largest residual of the reference's equations over the branch, relative to the excitation, with that many samples."""
    system, c = done.case.system(samples=samples), done.case.contact
    X = done.q[:, system.modes:].reshape(len(done.q), c.points, 3, -1)
    G = reference.contact_coefficients(X, c, done.preload, samples)
    worst = 0
    for omega, q, force in zip(done.omega, done.q, G):
        r = (system.dynamic_stiffness(omega) @ q.ravel()).reshape(system.shape) - system.excitation
        r[system.modes:] += force.reshape(-1, system.shape[1])
        worst = max(worst, np.linalg.norm(r))
    return worst / np.linalg.norm(system.excitation)


@pytest.mark.slow
def test_the_reference_gets_there_as_its_samples_grow(branch):
    """Sampling error falls as N^-2: by 64 over three doublings, here by 30 at least, and is next to nothing in the end."""
    coarse, fine = residuals(branch, 512), residuals(branch, 4096)
    assert fine < coarse / 30
    assert fine < 3e-5


def test_energy_is_balanced(branch):
    """Work of the excitation over a period = what damping takes + what the joints take, as stored with every point."""
    system, results = branch.case.system(samples=64), Results(branch.directory / "results.h5")
    k = np.arange(1, system.H + 1)
    for i in range(0, len(branch.omega), 1 + len(branch.omega) // 20):
        q, f = branch.q[i], system.excitation
        a, b = q[:, 1::2], q[:, 2::2]
        supplied = np.pi * np.sum(k * (f[:, 1::2] * b - f[:, 2::2] * a))
        damped = np.pi * branch.omega[i] * np.sum(k ** 2 * (a * (system.C @ a) + b * (system.C @ b)))
        rubbed = results.contact_activity(i).dissipation
        assert np.all(rubbed > -1e-9 * supplied)
        assert supplied == pytest.approx(damped + rubbed.sum(), rel=1e-7)


@pytest.mark.slow
def test_time_integration(tmp_path):
    """H = 40 against the integrated full model and the peaks found with N = 4096."""
    case = cases.dof5(tmp_path, harmonics=40, samples="exact", omega=[1.0, 1.05], at=[1.0215], **cases.TIGHT)
    done = run(case)
    s, p = case.structure, case.preload
    start = s.static_state(p.xp)
    for omega, peak in ((1.0215, 2.698249), (1.05, 2.526097)):
        q = done.q[np.argmin(np.abs(done.omega - omega))]
        assert truth.peak(q[0]) == pytest.approx(peak, abs=1e-6)
        orbit = truth.steady_state(s.M, case.settings["stiffness"], s.K, s.contact_dofs, case.contact, s.force,
                                   case.settings["fourier"], s.preload, omega, start, p.w)
        integrated = (orbit.u - start)[:, s.contact_dofs.ravel()].T
        np.testing.assert_allclose(reference.synthesis(q[2:], integrated.shape[1]), integrated, rtol=0, atol=1e-5)


@pytest.mark.slow
def test_ranks_do_not_change_the_branch(tmp_path):
    case = cases.several_points(tmp_path, samples="exact", omega=[0.8, 1.2])
    alone, together = run(case), run(case, 2)
    np.testing.assert_allclose(together.omega, alone.omega, rtol=1e-8)
    np.testing.assert_allclose(together.q, alone.q, rtol=0, atol=1e-8 * np.abs(alone.q).max())
