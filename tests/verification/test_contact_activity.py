"""What the program says of each contact point, /points/contact of results.h5, against the reference's march over the same motion.

The case scales inside the solver (kind = "auto"), so that an energy left in scaled units would show, and its four points
obey the four laws. The march takes what the program stored as motion: how that was found plays no part.
"""

import numpy as np
import pytest

import cases
from dovetail import Results, reference
from launch import run

SAMPLES = 64
LAWS = ["coulomb", "cone", "unilateral", "bilateral"]
PLACES = {"in order": [0, 1, 2, 3], "turned": [1, 0, 3, 2]}  # each law at two of the points


def results_of(folder, order, samples=None, **where):
    """The branch of `cases.several_points` with a law of its own at each point; without `samples`, exact but for the cone."""
    case = cases.several_points(folder, kind="auto", friction=[0.3, 0.2, 0.5, 0.4], omega=[0.8, 1.2], samples=samples or SAMPLES)
    text = case.path.read_text().replace("[contact]\n", f"[contact]\nlaw = {[LAWS[i] for i in order]}\n".replace("'", '"'))
    if samples is None:
        text = text.replace(f"samples = {SAMPLES}\n", "")
    case.path.write_text(text)
    return Results(run(case, **where).folder / "results.h5")


def marched(results, samples, law=None):
    """Shares of stick, slip, open and the dissipation (n, N_x) of the stored motions, from `samples` per period; `law`: in place of the
    points' own."""
    names = ("normal_stiffness", "tangential_stiffness", "friction", "gap")
    c = reference.Contact(*(results.contact[name] for name in names), results.contact["law"] if law is None else law)
    preload = reference.Preload(results.xp.reshape(-1, 3), results.g.reshape(-1, 3), results.w)
    X = results.coefficients[:, results.modes:].reshape(len(results), c.points, 3, -1)
    x = np.swapaxes(reference.synthesis(X, samples), -1, -2)
    _, state = reference.law(x, preload.xp, preload.w, c.kn, c.kt, c.mu, c.gap, c.kind)
    is_open, slips = state[..., 0] == reference.OPEN, (np.abs(state) == 1).any(axis=-1)
    G = reference.contact_coefficients(X, c, preload, samples)
    k = np.arange(1, results.harmonics + 1)
    work = np.pi * np.sum(k * (G[..., 1::2] * X[..., 2::2] - G[..., 2::2] * X[..., 1::2]), axis=(2, 3))
    return {"stick": (~is_open & ~slips).mean(axis=2), "slip": slips.mean(axis=2), "open": is_open.mean(axis=2), "dissipation": work}


def stored(results):
    activities = [results.contact_activity(point) for point in range(len(results))]
    return {name: np.array([getattr(activity, name) for activity in activities])
            for name in ("stick", "slip", "open", "events", "dissipation")}


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("order", PLACES.values(), ids=PLACES)
@pytest.mark.slow
def test_sampled(tmp_path, order, ranks):
    """The same samples: the same shares but for a sample that meets the bound to round-off, the same energy."""
    results = results_of(tmp_path, order, SAMPLES, ranks=ranks)
    assert results.samples == SAMPLES and results.contact["law"].tolist() == order
    found, expected = stored(results), marched(results, SAMPLES)
    np.testing.assert_allclose(found["open"], expected["open"], atol=1e-12)
    for name in ("stick", "slip"):
        np.testing.assert_allclose(found[name], expected[name], atol=2.1 / SAMPLES)
    np.testing.assert_allclose(found["dissipation"], expected["dissipation"], atol=1e-8 * np.abs(expected["dissipation"]).max())


@pytest.mark.slow
@pytest.mark.parametrize("order", PLACES.values(), ids=PLACES)
def test_exact(tmp_path, order):
    """Against a march of 4096 samples; the cone's point is sampled as ever, with 256 at so few harmonics."""
    results = results_of(tmp_path, order)
    assert results.samples == 0
    cone = order.index(LAWS.index("cone"))
    others = np.where(np.arange(len(order)) == cone, LAWS.index("unilateral"), order)  # fine marches of a cone take long
    found, fine, coarse = stored(results), marched(results, 4096, others), marched(results, 256)
    for name in ("stick", "slip", "open", "dissipation"):
        expected = fine[name].copy()
        expected[:, cone] = coarse[name][:, cone]
        tolerance = 1e-4 * np.abs(expected).max() if name == "dissipation" else 0.01
        np.testing.assert_allclose(found[name], expected, atol=tolerance, err_msg=name)


def test_shares_and_events_belong_together(tmp_path):
    found = stored(results_of(tmp_path, PLACES["in order"]))
    shares = np.array([found[name] for name in ("stick", "slip", "open")])
    np.testing.assert_allclose(shares.sum(axis=0), 1, atol=1e-12)
    assert shares.min() >= -1e-12
    changes = (shares > 1e-9).sum(axis=0) > 1
    rests = (shares[0] > 1 - 1e-12) | (shares[2] > 1 - 1e-12)
    assert changes.any() and rests.any()
    assert (found["events"][changes] >= 2).all() and not found["events"][rests].any()
    friction, frictionless = (slice(0, 2), slice(2, 4))
    assert found["slip"][:, friction].max() > 0.1 and not found["slip"][:, frictionless].any()
    assert found["open"][:, :3].max() > 0.1 and not found["open"][:, 3].any() and not found["events"][:, 3].any()
    largest = found["dissipation"].max()
    assert largest > 0 and np.abs(found["dissipation"][:, frictionless]).max() < 1e-9 * largest
