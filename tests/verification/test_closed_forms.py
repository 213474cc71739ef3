"""The reference against closed forms: friction loop, linear and fully stuck response, complete modal basis."""

import numpy as np
import pytest

import cases
import truth
from dovetail import reference


@pytest.mark.parametrize("amplitude", [0.4, 1.0, 3.0])
def test_energy_per_cycle_of_one_slider(amplitude):
    """x = X cos: the loop has the area 4 mu N (X - mu N / kt), nothing below X = mu N / kt = 0.6.

    The samples hold both turning points. Only the cells in which slip begins miss their corner: error of order (X/N)^2.
    """
    kt, mu, normal, samples = 2.0, 0.4, 3.0, 4096
    x = np.zeros((samples, 3))
    x[:, 0] = amplitude * np.cos(2 * np.pi * np.arange(samples) / samples)
    force, _ = reference.law(x, np.array([0, 0, normal]), np.zeros(2), 1.0, np.array([kt, kt]), np.array([mu, mu]), 0.0)
    closed, T = np.append(x[:, 0], x[0, 0]), np.append(force[:, 0], force[0, 0])
    area = np.sum((T[1:] + T[:-1]) / 2 * np.diff(closed))
    assert area == pytest.approx(truth.jenkins_loop_area(amplitude, kt, mu * normal), abs=2e-5)


def test_slider_force_along_the_loop():
    """Steady loop by hand: from the top (T = mu N) it falls with slope kt for a travel of 2 mu N / kt, then slips."""
    kt, limit, X, samples = 2.0, 1.2, 3.0, 256
    x = np.zeros((samples, 3))
    x[:, 0] = X * np.cos(2 * np.pi * np.arange(samples) / samples)
    force, state = reference.law(x, np.array([0, 0, 3.0]), np.zeros(2), 1.0, np.array([kt, kt]), np.array([0.4, 0.4]), 0.0)
    down, up = x[:samples // 2, 0], x[samples // 2:, 0]
    expected = np.concatenate([np.maximum(limit - kt * (X - down), -limit), np.minimum(-limit + kt * (up + X), limit)])
    np.testing.assert_allclose(force[:, 0], expected, atol=1e-13)
    assert set(state[:, 0]) == {reference.STICK, 1, -1}


@pytest.mark.parametrize("make, closed", [(cases.always_open, 0), (cases.always_stuck, 1)])
def test_all_modes_give_the_full_models_response(make, closed, tmp_path):
    """Craig-Bampton with all modes is a change of basis, and the law is linear: equal to round-off (1e-11 relative)."""
    case = make(tmp_path)
    structure, contact = case.structure, case.contact
    springs = np.zeros(len(structure.K))
    springs[structure.contact_dofs] = closed * np.column_stack([contact.kt, contact.kn])
    system = case.system()
    for omega in (0.8, 1.13, 1.6):
        exact = truth.linear_response(structure.K, structure.M, case.settings["stiffness"], structure.force,
                                      case.settings["fourier"], omega, springs)
        X = system.contact_part(system.solve(omega))
        exact = exact[structure.contact_dofs]
        np.testing.assert_allclose(X[:, :, :5], exact, rtol=0, atol=1e-11 * np.abs(exact).max())
        assert np.abs(X[:, :, 5:]).max() < 1e-11


def test_preload_equals_the_full_models_statics(tmp_path):
    """xp of a stuck joint: K u + springs (u - gap) = P, solved without any reduction."""
    case = cases.always_stuck(tmp_path)
    structure, contact = case.structure, case.contact
    K, load = structure.K.copy(), structure.preload.copy()
    for dofs, kt, kn, gap in zip(structure.contact_dofs, contact.kt, contact.kn, contact.gap):
        K[dofs, dofs] += [*kt, kn]
        load[dofs[2]] += kn * gap
    exact = np.linalg.solve(K, load)[structure.contact_dofs]
    np.testing.assert_allclose(case.preload.xp, exact, rtol=0, atol=1e-11 * np.abs(exact).max())


def test_static_reduction_is_exact_with_any_number_of_modes():
    """Psi alone carries every static load on contact dofs: K_xx is the Schur complement and R the condensed load."""
    structure = cases.random_structure()
    reduced = reference.craig_bampton(structure.K, structure.M, structure.contact_dofs, structure.force, structure.preload, 1)
    flexibility = np.linalg.inv(structure.K)
    c = structure.contact_dofs.ravel()
    np.testing.assert_allclose(np.linalg.inv(reduced.kxx), flexibility[np.ix_(c, c)], atol=1e-12)
    np.testing.assert_allclose(np.linalg.solve(reduced.kxx, -reduced.r), (flexibility @ structure.preload)[c], atol=1e-12)
