"""The compiled program against the reference, closed forms and time integration; on one rank and on several.

The program is $DOVETAIL, or build/dovetail. Every comparison solves to 1e-10, so that 1e-7 in the coefficients leaves room
for the conditioning of the equations (some 1e3 near the folds), while any slip in them is far larger.
"""

import subprocess
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pytest

import cases
import truth
from dovetail import reference
from launch import BINARY, SECONDS, SURROUNDINGS


@dataclass
class Run:
    """What one run of the program left: the case, and its files as arrays."""

    case: cases.Case
    omega: np.ndarray
    q: np.ndarray  # (points, N_a + 3 N_x, 2H+1)
    preload: reference.Preload
    directory: Path
    states: set = None  # contact states that must occur on the branch


def run(case, ranks=1):
    """`dovetail run` under mpirun; fails with the program's own words."""
    assert BINARY.is_file(), f"there is no program at {BINARY}: build it, or name it in $DOVETAIL"
    directory = case.path.parent / f"out{ranks}"
    command = ["mpirun", "-n", str(ranks), str(BINARY), "run", str(case.path), "--out", str(directory)]
    done = subprocess.run(command, env=SURROUNDINGS, capture_output=True, text=True, timeout=SECONDS)
    assert done.returncode == 0, f"{' '.join(command)} ended with {done.returncode}\n{done.stdout}\n{done.stderr}"
    with h5py.File(directory / "results.h5", "r") as file:
        assert file.attrs["ranks"] == ranks, "the ranks did not work together"
        points = case.reduced.r.size // 3
        preload = reference.Preload(file["preload/xp"][()].reshape(points, 3), file["preload/g"][()].reshape(points, 3),
                                    file["preload/w"][()].reshape(points, 2))
        return Run(case, file["points/omega"][()], file["points/coefficients"][()], preload, directory)


def close(actual, expected, relative):
    """Equal to `relative` of the largest entry."""
    np.testing.assert_allclose(actual, expected, rtol=0, atol=relative * np.abs(expected).max())


BRANCHES = {
    "dof5": lambda folder: cases.dof5(folder, **cases.TIGHT),
    "check 1": lambda folder: cases.single_mass(folder, 1, omega=[14, 11]),
    "check 2": lambda folder: cases.single_mass(folder, 2, omega=[13, 11.6], harmonics=5),
    "several points": lambda folder: cases.several_points(folder, omega=[0.8, 1.2]),
}
STATES = {"dof5": {0, 1, -1}, "check 1": {0, 2}, "check 2": {0, 1, 2}, "several points": {0, 1, -1, 2}}  # that must occur


@pytest.fixture(scope="module", params=BRANCHES)
def branch(request, tmp_path_factory):
    done = run(BRANCHES[request.param](tmp_path_factory.mktemp("branch")))
    done.states = STATES[request.param]
    return done


def test_branch_arrives(branch):
    """First and last point exactly at the ends of the range, and more than a handful between."""
    first, last = branch.case.settings["omega"]
    assert (branch.omega[0], branch.omega[-1]) == (first, last)
    assert branch.q.shape == (len(branch.omega), *branch.case.system().shape)
    assert len(branch.omega) > 5


def test_preload(branch):
    """Newton to 1e-10 on both sides; xp = 0 in some directions, so relative to the largest entry."""
    expected = branch.case.preload
    close(branch.preload.xp, expected.xp, 1e-9)
    close(branch.preload.g, expected.g, 1e-9)
    np.testing.assert_allclose(branch.preload.w, expected.w, rtol=0, atol=1e-9 * np.abs(expected.xp).max())


@pytest.mark.slow
def test_every_point_solves_the_reference_equations(branch):
    """Residual within 1e-8 of the excitation: 1e-10 was asked for, the rest is round-off and the choice of norm."""
    system = branch.case.system()
    limit = 1e-8 * np.linalg.norm(system.excitation)
    for omega, q in zip(branch.omega, branch.q):
        assert np.linalg.norm(system.residual(q, omega)) < limit, f"at omega = {omega}"


@pytest.mark.slow
def test_reference_finds_the_same_points(branch):
    """Newton of the reference, started at about twenty points of the branch."""
    system = branch.case.system()
    for i in range(0, len(branch.omega), 1 + len(branch.omega) // 20):
        close(branch.q[i], system.solve(branch.omega[i], branch.q[i]), 1e-7)


def test_branch_visits_the_contact_states(branch):
    """Guard of the comparisons above, which would say little if nothing slipped or lifted off."""
    system, c, p = branch.case.system(), branch.case.contact, branch.case.preload
    x = np.swapaxes(reference.synthesis(branch.q[:, system.modes:], system.N), -1, -2)
    x = x.reshape(len(branch.q), system.N, -1, 3).swapaxes(1, 2)
    visited = set(reference.law(x, p.xp, p.w, c.kn, c.kt, c.mu, c.gap)[1].ravel())
    assert branch.states <= visited


@pytest.mark.parametrize("make", [cases.dof5, cases.several_points, cases.always_stuck])
def test_reduction(make, tmp_path):
    """Relative to the largest entry of each array; 1e-9 is round-off times the spread of the eigenvalues."""
    done = run(make(tmp_path, omega=[0.8, 0.8]))
    r = done.case.reduced
    expected = {"Kaa": r.kaa, "Max": r.max, "Mxx": r.mxx, "Kxx": r.kxx, "Fa": r.fa, "Fx": r.fx, "R": r.r}
    with h5py.File(done.directory / "reduced.h5", "r") as file:
        for name, values in expected.items():
            close(file[name][()], values, 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name, ranks", [("dof5", 2), ("several points", 3)])
def test_ranks_do_not_change_the_branch(name, ranks, tmp_path):
    """Same points, also where the only contact point leaves a rank without one, and where shares are uneven."""
    case = BRANCHES[name](tmp_path)
    alone, together = run(case), run(case, ranks)
    assert together.omega.shape == alone.omega.shape
    close(together.omega, alone.omega, 1e-8)
    close(together.q, alone.q, 1e-8)


@pytest.mark.parametrize("kind", [{"kind": "auto"}, {"kind": "manual", "frequency": 2.5, "modal": 0.3, "contact": 0.07}])
@pytest.mark.parametrize("make, at", [(cases.dof5, [0.95, 1.01, 1.05, 1.2]), (cases.several_points, [0.85, 1.05, 1.15])])
@pytest.mark.slow
def test_scaling_changes_nothing(make, at, kind, tmp_path):
    """Arc lengths differ, so the branches are compared at frequencies both must pass exactly, and in the preload."""
    options = {"at": at, "omega": [0.8, 1.3] if make is cases.dof5 else [0.8, 1.2], **cases.TIGHT}
    plain, scaled = (run(make(tmp_path, **options, **how)) for how in ({"kind": "none"}, kind))
    close(scaled.preload.xp, plain.preload.xp, 1e-9)
    for omega in at:
        there = [np.flatnonzero(np.isclose(r.omega, omega, rtol=1e-12, atol=0)) for r in (plain, scaled)]
        assert len(there[0]) >= 1 and len(there[0]) == len(there[1]), f"passes of {omega}: {there}"
        for i, j in zip(*there):
            close(scaled.q[j], plain.q[i], 1e-7)


@pytest.mark.parametrize("make, closed", [(cases.always_open, 0), (cases.always_stuck, 1)])
@pytest.mark.slow
def test_linear_cases_equal_the_full_model(make, closed, tmp_path):
    """All modes kept and nothing slips: the response of the full model, with springs where the contacts are closed."""
    done = run(make(tmp_path))
    s, contact, system = done.case.structure, done.case.contact, done.case.system()
    springs = np.zeros(len(s.K))
    springs[s.contact_dofs] = closed * np.column_stack([contact.kt, contact.kn])
    for omega, q in zip(done.omega, done.q):
        exact = truth.linear_response(s.K, s.M, done.case.settings["stiffness"], s.force, done.case.settings["fourier"],
                                      omega, springs)[s.contact_dofs]
        X = system.contact_part(q)
        close(X[:, :, :5], exact, 1e-8)
        assert np.abs(X[:, :, 5:]).max() < 1e-8 * np.abs(exact).max()


@pytest.mark.slow
def test_time_integration(tmp_path):
    """H = 40, N = 4096 against the integrated full model, as in test_dof5: 1.2e-5 of truncation and sampling."""
    case = cases.dof5(tmp_path, harmonics=40, samples=4096, omega=[1.0, 1.05], at=[1.0215], **cases.TIGHT)
    done = run(case)
    s, p = case.structure, case.preload
    start = s.static_state(p.xp)
    for omega, peak in ((1.0215, 2.698249), (1.05, 2.526097)):
        q = done.q[np.argmin(np.abs(done.omega - omega))]
        assert np.abs(done.omega - omega).min() < 1e-12
        assert truth.peak(q[0]) == pytest.approx(peak, abs=1e-6)
        orbit = truth.steady_state(s.M, case.settings["stiffness"], s.K, s.contact_dofs, case.contact, s.force,
                                   case.settings["fourier"], s.preload, omega, start, p.w)
        integrated = (orbit.u - start)[:, s.contact_dofs.ravel()].T
        np.testing.assert_allclose(reference.synthesis(q[2:], integrated.shape[1]), integrated, rtol=0, atol=2e-5)
