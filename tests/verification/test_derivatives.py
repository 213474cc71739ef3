"""Derivatives of the reference against differences, in every contact state.

The sampled force is a smooth function of X as long as no sample changes its state: piecewise linear, and rational where a
landing is interpolated. Extrapolated central differences with step 1e-4 are then exact to about 1e-11 relative; 1e-7
leaves room, while any missing term (of relative size 1/N at least) shows.
"""

import numpy as np
import pytest

import cases
from dovetail import reference

SAMPLES = 64
CONTACT = reference.Contact.uniform(1, 2.0, [1.0, 1.5], [0.4, 0.3])
OTHERS = {law: reference.Contact.uniform(1, 2.0, [1.0, 1.5], 0.4, law=law) for law in reference.LAWS[1:]}
PRELOAD = reference.Preload(xp=np.array([[0.1, -0.05, 1.0]]), g=np.array([[0.1, -0.075, 2.0]]), w=np.zeros((1, 2)))

# Coefficients [a0, a1, b1, a2, b2] of t1, t2, n on top of the preload, N = 2 N; and what they are to show
WAVES = {
    "stick": [[0, 0.3, 0.1, 0.05, 0], [0, 0.1, 0.2, 0, 0.03], [0, 0.2, 0, 0, 0.1]],
    "slip": [[0, 2.0, 1.0, 0.3, 0], [0, 1.0, -2.0, 0, 0.3], [0, 0.2, 0.1, 0, 0.1]],
    "slip along a line": [[0, 2.0, 1.0, 0.3, 0], [0, 1.0, 0.5, 0.15, 0], [0, 0.2, 0.1, 0, 0.1]],
    "separation": [[0, 2.0, 1.0, 0.3, 0], [0, 1.0, -2.0, 0, 0.3], [-6, 0.2, 0, 0, 0.1]],
    "landing in stick": [[0, 0.1, 0.05, 0.03, 0], [0, 0.1, -0.1, 0, 0.02], [0, 0.5, 2.0, 0, 0.1]],
    "landing in slip": [[0, 4.0, 1.0, 0.3, 0], [0, 3.0, -2.0, 0, 0.3], [0, 1.4, 0.2, 0, 0.1]],
    "landing across the ends": [[0, 0.2, 1.0, 0.3, 0], [0, 1.0, 0.4, 0, 0.3], [0, -0.95, 2.0, 0, 0.1]],
    "shakedown": [[5, 0.3, 0.1, 0.05, 0], [-5, 0.1, 0.2, 0, 0.03], [0, 0.2, 0, 0, 0.1]],
}


def difference(function, x, direction, step=1e-4):
    """Derivative of `function` at x along `direction`: central differences at `step` and half of it, extrapolated."""
    coarse, fine = ((function(x + h * direction) - function(x - h * direction)) / (2 * h) for h in (step, step / 2))
    return (4 * fine - coarse) / 3


def history(X, contact=CONTACT):
    """Forces (N, 3) and states (N, 2) of the one point."""
    x = np.swapaxes(reference.synthesis(X, SAMPLES), -1, -2)
    force, state = reference.law(x, PRELOAD.xp, PRELOAD.w, contact.kn, contact.kt, contact.mu, contact.gap, contact.kind)
    return force[0], state[0]


@pytest.mark.parametrize("name", WAVES)
@pytest.mark.parametrize("contact", [CONTACT, *OTHERS.values()], ids=["coulomb", *OTHERS])
def test_contact_jacobian(name, contact):
    X = np.array([WAVES[name]], float)

    def G(X):
        return reference.contact_coefficients(X, contact, PRELOAD, SAMPLES)

    jacobian = reference.contact_jacobian(X, contact, PRELOAD, SAMPLES)[0]
    scale = np.abs(jacobian).max()
    directions = np.eye(X.size).reshape(X.size, *X.shape)
    columns = difference(G, X, directions)[:, 0].reshape(*X.shape[1:], *X.shape[1:])
    np.testing.assert_allclose(jacobian, np.moveaxis(columns, (0, 1), (2, 3)), rtol=0, atol=1e-7 * max(scale, 1))


def test_the_waves_show_what_they_are_named_after():
    states = {name: history(np.array([wave], float))[1] for name, wave in WAVES.items()}
    shown = {name: set(state.ravel()) for name, state in states.items()}
    assert shown["stick"] == {0}
    assert shown["slip"] == {0, 1, -1}
    assert shown["separation"] == {2}
    landed = {}
    for name, state in states.items():
        landed[name] = np.flatnonzero((np.roll(state, 1, axis=0) == 2)[:, 0] & (state[:, 0] != 2))
    assert (states["landing in stick"][landed["landing in stick"]] == 0).all()
    assert (np.abs(states["landing in slip"][landed["landing in slip"]]) == 1).all()
    assert landed["landing across the ends"] == [0]
    assert len(landed["landing in stick"]) == len(landed["landing in slip"]) == 1


def test_the_same_waves_under_the_cone_slip_stick_and_open():
    states = {name: set(history(np.array([wave], float), OTHERS["cone"])[1].ravel()) for name, wave in WAVES.items()}
    assert states["stick"] == {0} and states["slip"] == {1, -1} and states["separation"] == {2}
    assert states["slip along a line"] == {0, 1, -1} and states["landing in stick"] >= {0, 2}
    assert states["landing in slip"] >= {2, 1, -1}


def test_shakedown_sticks_with_a_foot_that_the_first_pass_moved():
    """All through the second pass the force is kt (x - w) with one constant w per direction, and it is not the initial 0.

    States are not compared: at the sample that slipped last in the first pass, |T| = mu N up to round-off in the second.
    """
    X = np.array([WAVES["shakedown"]], float)
    force, _ = history(X)
    surface = reference.synthesis(X, SAMPLES)[0, :2].T + PRELOAD.xp[0, :2]
    foot = surface - force[:, :2] / CONTACT.kt[0]
    assert np.ptp(foot, axis=0).max() < 1e-13
    assert np.abs(foot).min() > 1


@pytest.fixture(scope="module")
def mixed(tmp_path_factory):
    """Four contact points in a state where all things happen, and the equations they belong to."""
    case = cases.several_points(tmp_path_factory.mktemp("mixed"), samples=SAMPLES)
    system = case.system()
    q = 0.5 * np.random.default_rng(3).normal(size=system.shape)
    x = np.swapaxes(reference.synthesis(system.contact_part(q), SAMPLES), -1, -2)
    c, p = case.contact, case.preload
    states = reference.law(x, p.xp, p.w, c.kn, c.kt, c.mu, c.gap)[1]
    assert set(states.ravel()) == {0, 1, -1, 2}
    return system, q


def test_system_jacobian(mixed):
    """Along random directions, steps small enough (1e-6) that no sample changes state: round-off 1e-10 remains."""
    system, q = mixed
    jacobian = system.jacobian(q, 1.3)
    for direction in np.random.default_rng(4).normal(size=(5, *system.shape)):
        expected = difference(lambda q: system.residual(q, 1.3), q, direction, 1e-6).ravel()
        np.testing.assert_allclose(jacobian @ direction.ravel(), expected, rtol=0, atol=1e-7 * np.abs(expected).max())


def test_omega_derivative(mixed):
    """Equation (13). The residual is a quadratic in omega, for which central differences are exact."""
    system, q = mixed
    expected = difference(lambda omega: system.residual(q, omega), 1.3, 1.0, 1e-3)
    np.testing.assert_allclose(system.omega_derivative(q, 1.3), expected, rtol=0, atol=1e-10 * np.abs(expected).max())
