"""Every kind of damping: against the reference, closed forms, integration in time, and motions that a prototype found.

damping.npz holds motions of nine dofs with one contact point that slips and lifts off under two loads, found by dense harmonic
balance of the full model with an exact contact law of its own, for four kinds of damping.
"""

from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

import cases
import truth
from dovetail import reference
from launch import run

KINDS = {"mass": {"mass": 0.06}, "structural": {"structural": 0.03},
         "all": {"stiffness": 0.01, "mass": 0.03, "structural": 0.02}}
NONE = {"stiffness": 0.0, "mass": 0.0, "structural": 0.0}


def close(actual, expected, relative):
    np.testing.assert_allclose(actual, expected, rtol=0, atol=relative * np.abs(expected).max())


@pytest.mark.parametrize("solver", ["modal", "assembled"])
@pytest.mark.parametrize("kind", KINDS)
def test_the_reference_finds_the_same_points(tmp_path, kind, solver):
    """Four points that slip and lift off."""
    case = cases.several_points(tmp_path, solver=solver, omega=[0.85, 1.2], at=[0.95, 1.05, 1.15], **NONE | KINDS[kind])
    points = run(case).points
    system = case.system()
    assert points["slip"].max() > 0.2 and points["open"].max() > 0.2
    for omega in (0.85, 0.95, 1.05, 1.15, 1.2):
        for i in np.flatnonzero(points["omega"] == omega):
            close(points["coefficients"][i], system.solve(omega, points["coefficients"][i]), 1e-7)
    assert set(points["omega"]) >= {0.85, 0.95, 1.05, 1.15, 1.2}


@pytest.mark.parametrize("make, closed", [(cases.always_open, 0), (cases.always_stuck, 1)])
@pytest.mark.parametrize("kind", KINDS)
def test_linear_cases_equal_the_full_model(tmp_path, make, closed, kind):
    """All modes kept and nothing slips. Springs of the contacts take no part in any damping."""
    case = make(tmp_path, omega=[0.9, 1.1], **NONE | KINDS[kind])
    points, s, damping = run(case).points, case.structure, case.system().damping
    springs = np.zeros(len(s.K))
    springs[s.contact_dofs] = closed * np.column_stack([case.contact.kt, case.contact.kn])
    for omega, q in zip(points["omega"], points["coefficients"]):
        exact = truth.linear_response(s.K, s.M, damping.viscous(s.K, s.M), s.force, case.settings["fourier"], omega, springs,
                                      damping.structural * s.K)[s.contact_dofs]
        close(case.system().contact_part(q)[:, :, :5], exact, 1e-8)


def stuck_modes(K, M, springs):
    """Squares of the frequencies [rad^2/s^2] and mass-normalised modes with these springs (n,)."""
    return scipy.linalg.eigh(K + np.diag(springs), M)


@pytest.mark.parametrize("solver", ["modal", "assembled"])
def test_the_reference_finds_the_same_points_with_ratios(tmp_path, solver):
    """All of C = M Phi diag(2 zeta sqrt(lambda)) Phi^T M, which is full, where points slip and lift off."""
    ratios = [[1, 0.02], [3, 0.03], [2, 0.01]]
    case = cases.several_points(tmp_path, solver=solver, omega=[0.85, 1.2], at=[0.95, 1.05, 1.15], stiffness=0.005, ratios=ratios)
    points, plain = run(case).points, case.system()
    springs = np.r_[np.zeros(plain.modes), np.column_stack([case.contact.kt, case.contact.kn]).ravel()]
    squares, modes = stuck_modes(plain.K, plain.M, springs)
    rates = np.zeros(len(squares))
    for mode, ratio in ratios:
        rates[mode - 1] = 2 * ratio * np.sqrt(squares[mode - 1])
    damping = reference.Damping(0.005, matrix=plain.M @ modes @ np.diag(rates) @ modes.T @ plain.M)
    system = reference.HarmonicBalance(case.reduced, case.contact, case.preload, damping, case.settings["fourier"],
                                       case.settings["harmonics"], case.settings["samples"])
    assert points["slip"].max() > 0.2 and points["open"].max() > 0.2
    assert set(points["omega"]) >= {0.85, 0.95, 1.05, 1.15, 1.2}
    for omega in (0.85, 0.95, 1.05, 1.15, 1.2):
        for i in np.flatnonzero(points["omega"] == omega):
            close(points["coefficients"][i], system.solve(omega, points["coefficients"][i]), 1e-7)


def test_ratios_of_a_stuck_structure_are_those_of_its_modes(tmp_path):
    """The sum over the full model's modes, each with the ratio that it was given."""
    case = cases.always_stuck(tmp_path, fourier=[0, 1], harmonics=1, stiffness=0.0, omega=[0.9, 1.6],
                              ratios=[[mode, 0.002 * mode] for mode in range(1, 25)])
    points, s = run(case).points, case.structure
    springs = np.zeros(len(s.K))
    springs[s.contact_dofs] = np.column_stack([case.contact.kt, case.contact.kn])
    squares, modes = stuck_modes(s.K, s.M, springs)
    ratios = 0.002 * np.arange(1, len(squares) + 1)
    assert min(abs(np.sqrt(squares) - w).min() for w in points["omega"]) < 0.02  # the sweep meets a resonance
    for omega, q in zip(points["omega"], points["coefficients"]):
        z = modes @ (modes.T @ s.force / (squares - omega ** 2 + 2j * ratios * np.sqrt(squares) * omega))
        exact = np.stack([z.real, -z.imag], axis=-1)[s.contact_dofs]
        close(case.system().contact_part(q)[:, :, 1:3], exact, 1e-8)


@pytest.mark.parametrize("omega, states", [(9.0, {0, 1, 2}), (6.0, {-1, 0, 1})])
def test_mass_damping_in_time(tmp_path, omega, states):
    """A mass that slips, and lifts off at the higher frequency, 60 harmonics, against integration from event to event."""
    a = 0.8
    case = cases.single_mass(tmp_path, 2, samples="exact", harmonics=60, omega=[omega, omega], stiffness=0.0, mass=a, friction=0.3,
                             fourier=[0, 0, 6])
    points, p = run(case).points, case.preload
    M, K = np.eye(3), 40 * np.eye(3)
    orbit = truth.steady_state(M, a * M, K, np.arange(3).reshape(1, 3), case.contact, case.reduced.fx, case.settings["fourier"],
                               -case.reduced.r, omega, p.xp.ravel(), p.w, steps=2048, tolerance=1e-9)
    assert set(orbit.states.ravel()) == states
    expected = reference.analysis((orbit.u - orbit.u.mean(axis=0)).T, 5)
    close(points["coefficients"][0][1:, 1:11], expected[:, 1:], 1e-6)


def test_hysteretic_damping_is_not_judged_nor_integrated(tmp_path):
    case = cases.dof5(tmp_path, structural=0.02, stiffness=0.0, max_points=2)
    done = run(case)
    assert "damping.structural: stability is not judged, and nothing is integrated in time" in done.out
    assert "stable" not in done.points
    done = run(cases.dof5(tmp_path, ratios=[[1, 0.02]], max_points=2))
    assert "damping.ratios: stability is not judged, and nothing is integrated in time" in done.out
    assert "stable" not in done.points
    done = run(cases.dof5(tmp_path, structural=0.0, max_points=2))
    assert "stability is not judged" not in done.out and "stable" in done.points


# ------------------------------------------------------------------------------------------------------ the prototype
FOUND = dict(np.load(Path(__file__).parent / "data/damping.npz"))


def of_the_prototype():
    """Reduced model with all modes, the basis T of all dofs by its unknowns, and the contact point."""
    K, M, P, dofs = (FOUND[name] for name in ("K", "M", "P", "contact_dofs"))
    reduced = reference.craig_bampton(K, M, dofs, FOUND["F"][0], P, 6)
    _, phi, psi = reference.bases(K, M, dofs, 6)
    T = np.block([[phi, psi], [np.zeros((3, 6)), np.eye(3)]])  # the contact dofs are the last
    contact = reference.Contact.uniform(1, *(float(FOUND[name]) for name in ("kn", "kt", "mu", "gap")))
    return reduced, T, contact


def dampings(T):
    """Each kind of the prototype for the reduced model."""
    K, M = FOUND["K"], FOUND["M"]
    stuck = K + np.diag(6 * [0.0] + 2 * [float(FOUND["kt"])] + [float(FOUND["kn"])])
    squares, modes = scipy.linalg.eigh(stuck, M)
    by_ratios = M @ modes @ np.diag(2 * FOUND["stuck_ratio_values"] * np.sqrt(squares)) @ modes.T @ M
    a, b = FOUND["rayleigh_ab"]
    return {"rayleigh": reference.Damping(b, a), "matrix": reference.Damping(matrix=T.T @ FOUND["C_matrix"] @ T),
            "stuck_ratios": reference.Damping(matrix=T.T @ by_ratios @ T),
            "structural": reference.Damping(structural=float(FOUND["eta"]))}


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["rayleigh", "matrix", "stuck_ratios", "structural"])
def test_motions_of_the_prototype_solve_the_reference_equations(kind):
    """To 1e-8 of the force, with so many samples that their error is less."""
    reduced, T, contact = of_the_prototype()
    preload = reference.contact_preload(reduced, contact)
    system = reference.HarmonicBalance(reduced, contact, preload, dampings(T)[kind], FOUND["fourier_1"], 7, 2 ** 15)
    system.excitation[:, :4] += np.outer(T.T @ FOUND["F"][1], FOUND["fourier_2"])
    for omega, motion in zip(FOUND["omega"], FOUND[kind]):
        q = np.linalg.solve(T, motion)  # from the state with the contact at zero
        q[6:, 0] -= 2 * preload.xp.ravel()
        left = system.residual(q, omega)
        assert np.linalg.norm(left[:6]) < 1e-13  # no contact, no samples
        assert np.linalg.norm(left) < 1e-8 * np.linalg.norm(system.excitation)
