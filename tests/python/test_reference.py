"""The reference's parts one by one: Fourier convention, the contact law sample by sample, preload, continuation."""

import numpy as np
import pytest

from dovetail import reference
from dovetail.reference.contact import cone_step


def march(x, w=(0.0, 0.0), kn=2.0, kt=(1.0, 3.0), mu=(0.5, 0.5), gap=0.0, xp=(0.0, 0.0, 0.0), kind="coulomb"):
    """`reference.law` for one point with default parameters; x as rows [t1, t2, n]."""
    return reference.law(np.array(x) + 0.0, np.array(xp), np.array(w), kn, np.array(kt), np.array(mu), gap, kind)


def test_fourier_convention():
    """Mean = a0/2, then cosine and sine of each harmonic."""
    angle = 2 * np.pi * np.arange(9) / 9
    values = 1.5 + 2 * np.cos(angle) - 3 * np.sin(angle) + 0.5 * np.sin(3 * angle)
    coefficients = np.array([3.0, 2, -3, 0, 0, 0, 0.5])
    np.testing.assert_allclose(reference.analysis(values, 3), coefficients, atol=1e-14)
    np.testing.assert_allclose(reference.synthesis(coefficients, 9), values, atol=1e-14)


def test_too_few_samples_are_refused():
    with pytest.raises(ValueError, match="more than 6"):
        reference.analysis(np.zeros(6), 3)


def test_stick_is_a_spring_from_the_foot():
    force, state = march([[0.1, -0.1, 1], [0.2, 0.1, 1]], w=(0.05, 0.0))
    np.testing.assert_allclose(force, [[0.05, -0.3, 2], [0.15, 0.3, 2]], rtol=1e-14)
    assert (state == reference.STICK).all()


def test_slip_is_limited_by_the_normal_force_of_the_moment():
    force, state = march([[5, -5, 1], [-5, 5, 2]])
    np.testing.assert_allclose(force, [[1, -1, 2], [-2, 2, 4]], rtol=1e-14)
    np.testing.assert_array_equal(state, [[1, -1], [-1, 1]])


def test_the_foot_is_dragged_along_in_slip():
    """After slip to x = 5 with limit 1 the foot is at 4, so that x = 4.5 gives 0.5. Direction 2 does the same with kt = 3."""
    force, state = march([[5, 5, 1], [4.5, 5, 1]])
    np.testing.assert_allclose(force[:, :2], [[1, 1], [0.5, 1]], rtol=1e-14)
    assert state[1, 0] == reference.STICK


def test_the_second_pass_is_kept():
    """The first pass moves the foot, so the first sample differs from a march that begins at w."""
    force, _ = march([[0, 0, 1], [5, 0, 1], [4.5, 0, 1]])
    np.testing.assert_allclose(force[:, 0], [-1, 1, 0.5], rtol=1e-14)


def test_open_contact_carries_nothing():
    force, state = march([[1, 1, 0], [2, 2, -1]])
    assert (force == 0).all() and (state == reference.OPEN).all()


def test_landing_sets_the_foot_where_the_surface_was_at_touch():
    """From p = -1 to 3 touch is after a quarter of the step, at x_t = 1.25; from there T = 1 * (2 - 1.25)."""
    force, state = march([[1, 1.25, -1], [2, 1.25, 3]])
    np.testing.assert_allclose(force[1], [0.75, 0, 6], rtol=1e-14)
    assert (state[1] == reference.STICK).all()


def test_landing_on_the_first_sample_comes_from_the_last():
    """The same landing, wrapped round the end of the period."""
    force, _ = march([[2, 1.25, 3], [1, 1.25, -1]])
    np.testing.assert_allclose(force[0], [0.75, 0, 6], rtol=1e-14)


def test_preload_state_and_gap_shift_the_law():
    """x is measured from xp, w and gap are total: shifting all of them changes nothing."""
    x = np.random.default_rng(1).normal(size=(16, 3))
    force, state = march(x, w=(0.2, -0.1), gap=-0.3)
    shift = np.array([0.7, -0.4, 0.9])
    moved, moved_state = march(x - shift, xp=shift, w=(0.2, -0.1), gap=-0.3)
    np.testing.assert_allclose(moved, force, atol=1e-14)
    np.testing.assert_array_equal(moved_state, state)


def test_cone_bounds_the_length_of_both_forces():
    """To and fro along (0.6, 0.8) of the force, where mu N = 1; 0.2 back sticks."""
    force, state = march([[3, 4 / 3, 1], [2.88, 3.84 / 3, 1], [0, 0, 1]], kind="cone")
    np.testing.assert_allclose(force[:, :2], [[0.6, 0.8], [0.48, 0.64], [-0.6, -0.8]], atol=1e-12)
    np.testing.assert_array_equal(state, [[1, 1], [0, 0], [-1, -1]])
    np.testing.assert_array_equal(march([[-3, 0, 1], [3, 0, 1]], kind="cone")[1], [[-1, 1], [1, 1]])


@pytest.mark.parametrize("force, step, bounds", [((1.0, 0), (0.9, 0.7), (1, 1.4)), ((1.0, 0), (-0.2, 0.7), (1, 0.6)),
                                                 ((0.1, -0.3), (2, 1), (1, 1.4)), ((0.6, -0.8), (-3, 1), (1, 0.8))])
def test_a_step_of_the_cone_is_the_limit_of_returns_along_the_radius(force, step, bounds):
    """Slip all along, under a bound that grows or falls, after stick, and after stick from the bound itself."""
    n = 40000
    fine = np.array(force)
    for i in range(n):
        fine = fine + np.array(step) / n
        limit = bounds[0] + (bounds[1] - bounds[0]) * (i + 1) / n
        fine *= min(1, limit / np.hypot(*fine))
    exact, slips = cone_step(*(np.array(values, float) for values in (force, step, bounds[:1], bounds[1:])))
    np.testing.assert_allclose(exact, fine, atol=1e-4)
    assert slips and np.hypot(*exact) == pytest.approx(bounds[1], rel=1e-14)


def test_cone_along_one_direction_is_coulomb():
    x = np.random.default_rng(6).normal(size=(40, 3))
    x[:, 1] = 0
    force, state = march(x, kind="cone")
    expected, expected_state = march(x)
    np.testing.assert_allclose(force, expected, atol=1e-13)
    np.testing.assert_array_equal(state[:, 0], expected_state[:, 0])


def test_cone_turns_with_the_plane():
    """With equal k_t no direction of the plane is special; under the other law t1 and t2 are."""
    x = 2 * np.random.default_rng(7).normal(size=(40, 3))
    turn = np.eye(3)
    turn[:2, :2] = [[0.8, -0.6], [0.6, 0.8]]
    for kind, same in (("cone", True), ("coulomb", False)):
        turned = march(x @ turn.T, kt=(2.0, 2.0), kind=kind)[0]
        assert np.allclose(turned, march(x, kt=(2.0, 2.0), kind=kind)[0] @ turn.T, atol=1e-12) == same


@pytest.mark.parametrize("lift", [1.5, 0.97, 0.3])
def test_cone_goes_round_until_the_force_is_periodic(lift):
    """From any foot, always closed, or open at the last sample and, with the third, before: another period after it brings nothing new."""
    angle = 2 * np.pi * np.arange(24) / 24
    x = np.column_stack([2 * np.cos(angle), np.sin(2 * angle + 0.3), lift - np.cos(angle + angle[1])])
    force, state = march(x, w=(3, -2), kind="cone")
    again, _ = march(np.concatenate([x, x]), w=(3, -2), kind="cone")
    np.testing.assert_allclose(force, again[24:], atol=1e-9)
    np.testing.assert_allclose(march(x + 1e-30j, w=(3, -2), kind="cone")[0].real, force, atol=1e-9)
    assert (state[-1] == reference.OPEN).all() == (lift < 1) and (np.abs(state) == 1).any()


def test_laws_without_friction():
    """kt and mu have no meaning there, not even as divisors; the bilateral spring pulls and is never open."""
    x = [[1, -1, 0.5], [2, 3, -0.25]]
    force, state = march(x, kt=(0.0, 0.0), mu=(0.0, 0.0), kind="unilateral")
    np.testing.assert_array_equal(force, [[0, 0, 1], [0, 0, 0]])
    np.testing.assert_array_equal(state, [[0, 0], [2, 2]])
    force, state = march(x, gap=0.25, kind="bilateral")
    np.testing.assert_array_equal(force, [[0, 0, 0.5], [0, 0, -1]])
    assert not state.any()


def test_laws_by_name_and_by_number_point_by_point():
    rng = np.random.default_rng(8)
    x, w = rng.normal(size=(4, 32, 3)), rng.normal(size=(4, 2))
    together, states = reference.law(x, np.zeros((4, 3)), w, np.full(4, 2.0), np.ones((4, 2)), np.full((4, 2), 0.5), np.zeros(4),
                                     np.arange(4))
    for i, name in enumerate(reference.LAWS):
        force, state = march(x[i], w=w[i], kt=(1.0, 1.0), kind=name)
        np.testing.assert_array_equal(together[i], force)
        np.testing.assert_array_equal(states[i], state)
    with pytest.raises(ValueError, match="banana"):
        march(x[0], kind="banana")


@pytest.mark.parametrize("law", reference.LAWS)
@pytest.mark.parametrize("place", [[0.1, 0.2, 1], [3.0, 0.1, 1], [-3.0, 4.0, 1], [1.0, 1.0, -1]])
def test_force_at_a_standstill(law, place):
    """Reached in one step from a foot at zero: the first sample of a march that moves no further. Slope by differences."""
    contact, x = reference.Contact.uniform(1, 2.0, [1.0, 3.0], 0.5, 0.125, law), np.array([place], float)
    g, w, slope = reference.static_law(x, contact)
    np.testing.assert_allclose(g, march(x, gap=0.125, kind=law)[0], atol=1e-15)
    np.testing.assert_allclose(march(x, w=w[0], gap=0.125, kind=law)[0], g, atol=1e-15)  # what it left holds that force
    for i, direction in enumerate(1e-6 * np.eye(3)):
        ahead, behind = (reference.static_law(x + sign * direction, contact)[0] for sign in (1, -1))
        np.testing.assert_allclose(slope[0, :, i], ((ahead - behind) / 2e-6)[0], atol=1e-8)
    if law in ("unilateral", "bilateral"):
        assert not w.any()


@pytest.mark.parametrize("law, springs", [("coulomb", [1, 3, 2]), ("cone", [1, 3, 2]), ("unilateral", [0, 0, 2]),
                                          ("bilateral", [0, 0, 2])])
def test_touching_without_force_has_the_slope_of_the_closed_contact(law, springs):
    contact = reference.Contact.uniform(1, 2.0, [1.0, 3.0], 0.5, 0.25, law)
    g, _, slope = reference.static_law(np.array([[0.5, 0.5, 0.25]]), contact)
    np.testing.assert_array_equal(g, np.zeros((1, 3)))
    np.testing.assert_array_equal(slope[0], np.diag(springs))


def test_many_points_at_once_equal_one_by_one():
    rng = np.random.default_rng(2)
    x, xp, w = rng.normal(size=(5, 32, 3)), rng.normal(size=(5, 3)), rng.normal(size=(5, 2))
    kn, kt, mu, gap = rng.uniform(1, 2, 5), rng.uniform(1, 2, (5, 2)), rng.uniform(0, 1, (5, 2)), rng.normal(size=5)
    together, states = reference.law(x, xp, w, kn, kt, mu, gap)
    for i in range(5):
        force, state = reference.law(x[i], xp[i], w[i], kn[i], kt[i], mu[i], gap[i])
        np.testing.assert_array_equal(together[i], force)
        np.testing.assert_array_equal(states[i], state)


def test_contact_force_is_measured_from_preload():
    """No motion, no force: G(0) = 0 for a point that sticks, for one that slips and for one that is open at preload."""
    contact = reference.Contact.uniform(3, 2.0, 1.0, 0.5, [0.0, 0.0, 9.0])
    xp = np.array([[0.1, 0.2, 1], [5, -5, 1], [1, 1, 1]])
    g, w, _ = reference.static_law(xp, contact)
    np.testing.assert_allclose(w, [[0, 0], [4, -4], [1, 1]])
    preload = reference.Preload(xp, g, w)
    np.testing.assert_allclose(reference.contact_coefficients(np.zeros((3, 3, 5)), contact, preload, 16), 0, atol=1e-14)


def test_preload_of_a_body_held_by_its_joint_alone():
    """K_xx is singular, and p = 0 at the start: the joint alone carries the push of 6 N, so kn x = 6, kt x = 0.5."""
    contact = reference.Contact.uniform(1, 2.0, 1.0, 0.5)
    r = np.array([-0.5, 0, -6])
    reduced = reference.Reduced(np.ones(1), np.zeros((1, 3)), np.eye(3), np.zeros((3, 3)), np.zeros(1), np.zeros(3), r)
    state = reference.contact_preload(reduced, contact)
    np.testing.assert_allclose(state.xp, [[0.5, 0, 3]], atol=1e-12)
    np.testing.assert_allclose(state.g, [-r], atol=1e-12)


def test_mode_signs_prefer_the_first_of_equally_large_entries():
    """A symmetric chain has modes with several largest entries; each time the first of them is positive."""
    K = 2 * np.eye(6) - np.eye(6, k=1) - np.eye(6, k=-1)
    _, phi, _ = reference.bases(K, np.eye(6), [[5, 3, 4]], 3)
    first = [mode[np.flatnonzero(np.abs(mode) > 0.999 * np.abs(mode).max())[0]] for mode in phi.T]
    assert min(first) > 0


def test_excitation_beyond_the_harmonics_is_refused():
    reduced = reference.Reduced(np.ones(1), np.zeros((1, 3)), np.eye(3), np.eye(3), np.zeros(1), np.zeros(3), np.zeros(3))
    contact = reference.Contact.uniform(1, 1.0, 1.0, 1.0)
    with pytest.raises(ValueError, match="5 coefficients"):
        reference.HarmonicBalance(reduced, contact, reference.contact_preload(reduced, contact), 0.1, [0, 0, 1, 0, 1], 1, 8)


@pytest.mark.parametrize("ends", [(0.5, 3.0), (3.0, 0.5)])
@pytest.mark.slow
def test_continuation_ends_exactly_and_passes_the_resonance(ends):
    """A mass on the closed, stuck joint (stiffness 1 + 3 N/m) resonates at 2 rad/s with amplitude 1 / (xi * 1 * 2)."""
    contact = reference.Contact.uniform(1, 3.0, 3.0, 1e3, -1e3)
    force = np.array([1.0, 0, 0])
    reduced = reference.Reduced(np.ones(1), np.zeros((1, 3)), np.eye(3), np.eye(3), np.zeros(1), force, np.zeros(3))
    system = reference.HarmonicBalance(reduced, contact, reference.contact_preload(reduced, contact), 0.1, [0, 1], 1, 16)
    omega, q = system.continuation(*ends, 0.05, largest=0.2)
    assert (omega[0], omega[-1]) == ends
    amplitude = np.hypot(q[:, 1, 1], q[:, 1, 2])
    np.testing.assert_allclose(amplitude, 1 / np.hypot(4 - omega ** 2, 0.1 * omega), rtol=1e-9)
    assert amplitude.max() > 4.9


@pytest.fixture
def original():
    """The original's algorithm on two points with different parameters that slip and lift off; a full matrix couples them."""
    rng = np.random.default_rng(5)
    kxx = 4 * np.eye(6) + (lambda a: a + a.T)(0.2 * rng.normal(size=(6, 6)))
    reduced = reference.Reduced(np.array([2.0]), 0.1 * rng.normal(size=(1, 6)), np.eye(6), kxx, np.ones(1), rng.normal(size=6),
                                np.array([0, 0, -2.0, 0, 0, -1.0]))
    contact = reference.Contact.uniform(2, [2.0, 3.0], [[1.0, 2.0], [0.5, 1.5]], [[0.3, 0.2], [0.4, 0.0]], [-0.1, 0.05])
    arguments = reduced, contact, reference.contact_preload(reduced, contact), 0.02, [0, 1, 0.5], 3, 32
    system = reference.Original(*arguments)
    system.arguments = arguments
    return system


def pressed(scale, seed=2):
    """Coefficients (2, 3, 7) of a motion during which both points stay closed."""
    X = scale * np.random.default_rng(seed).normal(size=(2, 3, 7))
    X[:, 2] *= 0.1
    X[:, 2, 0] += 1
    return X


def test_original_law_of_closed_contacts_is_the_law(original):
    """The clamped form gives the same force, and the foot at the end of the second period that `law` leaves behind."""
    c, p = original.contact, original.preload
    G, foot = original.march(pressed(0.3))
    np.testing.assert_allclose(G, reference.contact_coefficients(pressed(0.3), c, p, 32), atol=1e-14)
    x = np.swapaxes(reference.synthesis(pressed(0.3), 32), 1, 2)
    force, state = reference.law(x, p.xp, p.w, c.kn, c.kt, c.mu, c.gap)
    assert {1, -1, 0} == set(state.ravel())
    np.testing.assert_allclose(foot, x[:, -1, :2] + p.xp[:, :2] - force[:, -1, :2] / c.kt, atol=1e-14)


def test_original_foot_lands_early(original):
    """Touch at a quarter of the step, as above: the foot stays where the surface was at the sample before, at 1 instead of 1.25."""
    samples = np.array([[1.0, 2, 2], [0, 0, 0], [-1, 3, 3]])
    original.N, original.H = 3, 1
    original.contact = reference.Contact.uniform(1, 1.0, 1.0, 10.0)
    original.preload = reference.Preload(*np.zeros((2, 1, 3)), np.zeros((1, 2)))
    original.foot = original.preload.w
    G, foot = original.march(reference.analysis(samples, 1)[None])
    np.testing.assert_allclose(reference.synthesis(G[0], 3), [[0, 1, 1], [0, 0, 0], [0, 3, 3]], atol=1e-14)
    np.testing.assert_allclose(foot, [[1, 0]], atol=1e-14)


def test_original_remembers(original):
    """Slip moves the feet, so a stuck motion evaluated before and after it has two different residuals; `HarmonicBalance` has one."""
    def residual(system, X):
        return system.residual(np.vstack([np.zeros(7), X.reshape(6, 7)]), 1.0)

    plain = reference.HarmonicBalance(*original.arguments)
    for system, forgets in ((plain, True), (original, False)):
        before = residual(system, pressed(1e-3))
        residual(system, pressed(0.3))
        assert np.array_equal(residual(system, pressed(1e-3)), before) == forgets


def test_original_jacobian(original):
    """Forward differences of all coefficients at once, against complex step with the same feet; evaluating it moves no foot."""
    q = np.vstack([np.ones(7), pressed(0.3).reshape(6, 7)])
    original.foot = original.march(pressed(0.3))[1]
    foot = original.foot.copy()
    plain = reference.HarmonicBalance(*original.arguments)
    plain.preload = reference.Preload(original.preload.xp, original.preload.g, foot)
    np.testing.assert_allclose(original.jacobian(q, 1.0), plain.jacobian(q, 1.0), atol=2e-7)
    np.testing.assert_array_equal(original.foot, foot)
