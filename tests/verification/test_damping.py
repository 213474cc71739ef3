"""Every kind of damping: against the reference, closed forms, integration in time, and motions that a prototype found.

damping.npz holds motions of nine dofs with one contact point that slips and lifts off under two loads, found by dense harmonic
balance of the full model with an exact contact law of its own, for four kinds of damping.
"""

import re
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.linalg

import cases
import truth
from dovetail import Model, reference
from launch import run

KINDS = {"mass": {"mass": 0.06}, "structural": {"structural": 0.03},
         "all": {"stiffness": 0.01, "mass": 0.03, "structural": 0.02}}
NONE = {"stiffness": 0.0, "mass": 0.0, "structural": 0.0}


def close(actual, expected, relative):
    np.testing.assert_allclose(actual, expected, rtol=0, atol=relative * np.abs(expected).max())


def dashpots(structure, seed=3):
    """A viscous matrix that is proportional to nothing, of a few dashpots between dofs, and stiffness of a part of the structure."""
    rng = np.random.default_rng(seed)
    n = len(structure.K)
    B = rng.normal(size=(n, 5)) / np.sqrt(n)
    part = rng.normal(size=(n, n // 2)) / np.sqrt(n)
    return {"C": 0.3 * B @ B.T, "K_structural": 8 * part @ part.T}


OTHERS = {"matrix": {"matrix": True}, "fixed": {"ratios": [[1, 0.02], [3, 0.03], [2, 0.01]], "of": "fixed", "stiffness": 0.01},
          "contact": {"stiffness": 0.02, "damped_springs": True}, "parts": {"structural": 0.02},
          "stuck": {"ratios": [[1, 0.02], [3, 0.03], [2, 0.01]], "stiffness": 0.005},
          "together": {"stiffness": 0.01, "mass": 0.01, "structural": 0.01, "matrix": True, "damped_springs": True,
                       "ratios": [[1, 0.01], [4, 0.03]]}}
PARTS = ("all", "matrix", "parts", "stuck")  # of "together"
WITH = {"matrix": ["C"], "parts": ["K_structural"], "together": ["C", "K_structural"]}


def with_matrices(kind):
    structure = cases.random_structure()
    matrices = dashpots(structure)
    return replace(structure, matrices={name: matrices[name] for name in WITH.get(kind, [])})


# Kinds one by one are quick where none of the others is like them; all kinds together in both forms.
@pytest.mark.parametrize("kind, solver, ranks", [
    *(pytest.param(kind, solver, 1, marks=() if kind == "together" or solver == "modal" and kind not in PARTS else pytest.mark.slow)
      for kind in (*KINDS, *OTHERS) for solver in ("modal", "assembled")),
    *(pytest.param(kind, "modal", 2, marks=pytest.mark.slow) for kind in ("together", "parts", "stuck", "fixed"))])
def test_the_reference_finds_the_same_points(tmp_path, kind, solver, ranks):
    """Four points that slip and lift off."""
    keys = NONE | (KINDS | OTHERS)[kind]
    case = cases.several_points(tmp_path, structure=with_matrices(kind), solver=solver, omega=[0.85, 1.2], at=[0.95, 1.05, 1.15], **keys)
    points = run(case, ranks=ranks).points
    system = case.system()
    assert points["slip"].max() > 0.2 and points["open"].max() > 0.2
    for omega in (0.85, 0.95, 1.05, 1.15, 1.2):
        for i in np.flatnonzero(points["omega"] == omega):
            close(points["coefficients"][i], system.solve(omega, points["coefficients"][i]), 1e-7)
    assert set(points["omega"]) >= {0.85, 0.95, 1.05, 1.15, 1.2}


@pytest.mark.parametrize("make, closed", [(cases.always_open, 0), (cases.always_stuck, 1)])
@pytest.mark.parametrize("kind", [kind if kind == "all" else pytest.param(kind, marks=pytest.mark.slow) for kind in KINDS])
def test_linear_cases_equal_the_full_model(tmp_path, make, closed, kind):
    """All modes kept and nothing slips. Springs of the contacts take no part in any damping."""
    case = make(tmp_path, omega=[0.9, 1.1], **NONE | KINDS[kind])
    points, s, system = run(case).points, case.structure, case.system()
    damping = system.damping
    springs = np.zeros(len(s.K))
    springs[s.contact_dofs] = closed * np.column_stack([case.contact.kt, case.contact.kn])
    for omega, q in zip(points["omega"], points["coefficients"]):
        exact = truth.linear_response(s.K, s.M, damping.viscous(s.K, s.M), s.force, case.settings["fourier"], omega, springs,
                                      damping.structural * s.K)[s.contact_dofs]
        close(system.contact_part(q)[:, :, :5], exact, 1e-8)


def stuck_modes(K, M, springs):
    """Squares of the frequencies [rad^2/s^2] and mass-normalised modes with these springs (n,)."""
    return scipy.linalg.eigh(K + np.diag(springs), M)


def test_ratios_of_a_stuck_structure_are_those_of_its_modes(tmp_path):
    """The sum over the full model's modes, each with the ratio that it was given."""
    case = cases.always_stuck(tmp_path, fourier=[0, 1], harmonics=1, stiffness=0.0, omega=[0.9, 1.6],
                              ratios=[[mode, 0.002 * mode] for mode in range(1, 25)])
    points, s, system = run(case).points, case.structure, case.system()
    springs = np.zeros(len(s.K))
    springs[s.contact_dofs] = np.column_stack([case.contact.kt, case.contact.kn])
    squares, modes = stuck_modes(s.K, s.M, springs)
    ratios = 0.002 * np.arange(1, len(squares) + 1)
    assert min(abs(np.sqrt(squares) - w).min() for w in points["omega"]) < 0.02  # the sweep meets a resonance
    for omega, q in zip(points["omega"], points["coefficients"]):
        z = modes @ (modes.T @ s.force / (squares - omega ** 2 + 2j * ratios * np.sqrt(squares) * omega))
        exact = np.stack([z.real, -z.imag], axis=-1)[s.contact_dofs]
        close(system.contact_part(q)[:, :, 1:3], exact, 1e-8)


@pytest.mark.slow
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


VISCOUS = [{"matrix": True}, {"ratios": [[1, 0.03], [2, 0.02]], "of": "fixed"}, {"ratios": [[1, 0.05], [2, 0.04], [5, 0.02]]},
           {"stiffness": 0.05, "damped_springs": True}]


@pytest.mark.parametrize("keys", [pytest.param(keys, id=name, marks=() if name in ("matrix", "contact") else pytest.mark.slow)
                                  for name, keys in zip(["matrix", "fixed", "stuck", "contact"], VISCOUS)])
def test_viscous_kinds_in_time(tmp_path, keys):
    """Five dofs that slip, 40 harmonics, against integration from event to event. Stability is judged with all of them."""
    omega, dofs = 0.95, 5
    case = cases.dof5(tmp_path, **NONE | {"mass": 0.05} | keys | cases.TIGHT, samples="exact", harmonics=40, omega=[omega, omega],
                      friction=[0.2, 0.2], fourier=[0, 0, 3], enabled=True)
    if "matrix" in keys:
        C = np.zeros((dofs, dofs))
        C[0, 0], C[1:3, 1:3] = 0.1, 0.3 * np.array([[1, -1], [-1, 1]])
        Model.read(tmp_path / "model.h5").with_damping_matrix(C).write(tmp_path / "model.h5")
        case.structure.matrices["C"] = C
    points, p, system = run(case).points, case.preload, case.system(harmonics=5, samples=64)
    modes = system.modes
    orbit = truth.steady_state(system.M, system.C, system.K, modes + np.arange(3).reshape(1, 3), case.contact,
                               np.r_[case.reduced.fa, case.reduced.fx], case.settings["fourier"], np.r_[np.zeros(modes), -case.reduced.r],
                               omega, np.r_[np.zeros(modes), p.xp.ravel()], p.w, steps=256, tolerance=1e-8)
    assert {-1, 0, 1} <= set(orbit.states.ravel())
    expected = reference.analysis((orbit.u - orbit.u.mean(axis=0)).T, 5)
    close(points["coefficients"][0][:, 1:11], expected[:, 1:], 1e-6)
    assert points["stable"][0] == 1


def test_hysteretic_damping_is_not_judged_nor_integrated(tmp_path):
    case = cases.dof5(tmp_path, structural=0.02, stiffness=0.0, max_points=2)
    done = run(case)
    assert "damping.structural: stability is not judged, and nothing is integrated in time" in done.out
    assert "stable" not in done.points
    for keys in ({"structural": 0.0}, {"ratios": [[1, 0.02]]}, {"damped_springs": True}):
        done = run(cases.dof5(tmp_path, max_points=2, **keys))
        assert "stability is not judged" not in done.out and "stable" in done.points


def test_a_matrix_that_is_left_out_is_told(tmp_path):
    case = cases.dof5(tmp_path, max_points=2)
    model, n = Model.read(tmp_path / "model.h5"), 5
    model.with_damping_matrix(np.eye(n)).with_structural_matrix(np.eye(n)).write(tmp_path / "model.h5")
    out = run(case).out
    assert "viscous damping matrix is left out; damping.matrix = true takes it" in out
    assert "structural matrix is left out; damping.structural is the loss factor it wants" in out
    assert "left out" not in run(cases.dof5(tmp_path, max_points=2)).out


def test_a_matrix_of_the_reduced_file_is_that_of_the_model(tmp_path):
    """Read from reduced.h5, whole and as the diagonal alone."""
    (tmp_path / "model").mkdir()
    case = cases.several_points(tmp_path / "model", structure=with_matrices("together"), omega=[0.9, 1.0], **NONE | OTHERS["together"])
    whole = run(case).points
    reduced = tmp_path / "reduced.h5"
    reduced.write_bytes((tmp_path / "model/reduced.h5").read_bytes())
    text = case.path.read_text().replace('model = "model.h5"', 'reduced = "reduced.h5"')
    (tmp_path / "case.toml").write_text(re.sub(r"\[reduction\]\nmodes = \d+\n", "", text))
    again = run(replace(case, path=tmp_path / "case.toml")).points
    np.testing.assert_array_equal(again["coefficients"], whole["coefficients"])

    with h5py.File(reduced, "r+") as file:
        del file.attrs["fingerprint"], file["Cax"], file["Cxx"], file["Saa"], file["Sax"], file["Sxx"]
        diagonal = file["Caa"][()].diagonal().copy()
        del file["Caa"]
        file["Caa"] = diagonal
    points = run(replace(case, path=tmp_path / "case.toml")).points
    damping = case.damping()
    C = damping.matrix - case_matrix(case)
    C[np.arange(5), np.arange(5)] += diagonal
    system = reference.HarmonicBalance(case.reduced, case.contact, case.preload, replace(damping, matrix=C, structural_matrix=None),
                                       case.settings["fourier"], case.settings["harmonics"], case.settings["samples"])
    close(points["coefficients"][0], system.solve(0.9, points["coefficients"][0]), 1e-7)


def case_matrix(case):
    s = case.structure
    return reference.projected(s.matrices["C"], s.K, s.M, s.contact_dofs, len(case.reduced.kaa))


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


@pytest.mark.parametrize("solver, ranks", [("modal", 1), *(pytest.param(*other, marks=pytest.mark.slow) for other in
                                                           (("modal", 2), ("assembled", 1)))])
@pytest.mark.parametrize("kind", ["rayleigh", pytest.param("matrix", marks=pytest.mark.slow), "stuck_ratios", "structural"])
def test_the_program_finds_the_motions_of_the_prototype(tmp_path, kind, solver, ranks):
    """Every dof of the full model, to 1e-8 of the largest motion."""
    _, T, contact = of_the_prototype()
    a, b = FOUND["rayleigh_ab"]
    keys = {"rayleigh": {"stiffness": float(b), "mass": float(a)}, "matrix": {"matrix": True},
            "stuck_ratios": {"ratios": [[j + 1, float(ratio)] for j, ratio in enumerate(FOUND["stuck_ratio_values"])]},
            "structural": {"structural": float(FOUND["eta"])}}[kind]
    structure = cases.Structure(FOUND["K"], FOUND["M"], FOUND["contact_dofs"], FOUND["F"], FOUND["P"],
                                {"C": FOUND["C_matrix"]} if kind == "matrix" else {})
    omega = [float(w) for w in FOUND["omega"]]
    case = cases.full(tmp_path, "nine dofs", structure, NONE | keys | {"solver": solver}, modes=6,
                      loads={"one": FOUND["fourier_1"].tolist(), "two": FOUND["fourier_2"].tolist()},
                      normal_stiffness=float(FOUND["kn"]), tangential_stiffness=float(FOUND["kt"]), friction=float(FOUND["mu"]),
                      gap=float(FOUND["gap"]), initial=0.0, harmonics=7, samples="exact", omega=[min(omega), max(omega)],
                      at=sorted(omega), step=0.05, **cases.TIGHT)
    points, preload = run(case, ranks=ranks).points, case.preload
    for w, motion in zip(omega, FOUND[kind]):
        (i, *_), = [np.flatnonzero(points["omega"] == w)]
        q = points["coefficients"][i].copy()
        q[6:, 0] += 2 * preload.xp.ravel()
        close(T @ q, motion, 1e-8)
