"""Fourier series of a period, and what the contact points do in it."""

from dataclasses import dataclass

import numpy as np

STICK, OPEN = 0, 2  # contact states; slip is +1 or -1, the sign of the tangential force
LAWS = ("coulomb", "cone", "unilateral", "bilateral")  # numbered as in a results file; the first two have friction
COULOMB, CONE, UNILATERAL, BILATERAL = range(4)


# ----------------------------------------------------------------------------------------------- Fourier series (10)
def waves(harmonics, samples):
    """Rows 1, cos(j), sin(j), cos(2j), ... of one period; shape (2 harmonics + 1, samples)."""
    angle = 2 * np.pi * np.arange(samples) / samples
    rows = [np.ones(samples)]
    for k in range(1, harmonics + 1):
        rows += [np.cos(k * angle), np.sin(k * angle)]
    return np.array(rows)


def synthesis(coefficients, samples):
    """Samples of one period from coefficients [a0, a1, b1, ...] on the last axis; the mean is a0/2."""
    harmonics = coefficients.shape[-1] // 2
    rows = waves(harmonics, samples)
    rows[0] = 0.5
    return coefficients @ rows


def analysis(values, harmonics):
    """Coefficients [a0, a1, b1, ...] from samples of one period on the last axis: (2/N) sums."""
    samples = values.shape[-1]
    if samples <= 2 * harmonics:
        raise ValueError(f"{samples} samples cannot carry {harmonics} harmonics: more than {2 * harmonics} are needed")
    return values @ waves(harmonics, samples).T * (2 / samples)


# ------------------------------------------------------------------------------------------------------- contact law
@dataclass(frozen=True)
class Contact:
    """Parameters of all contact points.

    kn : (N_x,) normal stiffness [N/m];  kt : (N_x, 2) tangential stiffness [N/m], positive
    mu : (N_x, 2) friction coefficient [-];  gap : (N_x,) lift-off displacement [m]
    law : (N_x,) numbers or names of `LAWS`, or one of them for all points; without friction kt and mu have no meaning
    """

    kn: np.ndarray
    kt: np.ndarray
    mu: np.ndarray
    gap: np.ndarray
    law: np.ndarray = COULOMB

    @classmethod
    def uniform(cls, points, normal_stiffness, tangential_stiffness, friction, gap=0.0, law="coulomb"):
        """From values as in the case file: one for all points, or one (tangential: one pair) per point."""
        return cls(np.broadcast_to(np.asarray(normal_stiffness, float), (points,)),
                   np.broadcast_to(np.asarray(tangential_stiffness, float), (points, 2)),
                   np.broadcast_to(np.asarray(friction, float), (points, 2)),
                   np.broadcast_to(np.asarray(gap, float), (points,)), law)

    @property
    def points(self):
        return len(self.kn)

    @property
    def kind(self):
        """Number of the law of each point, (N_x,)."""
        return np.broadcast_to(law_numbers(self.law), (self.points,))


def law_numbers(kind):
    """Laws as numbers, from numbers or from names in `LAWS`, one or many."""
    kind = np.asarray(kind)
    if kind.dtype.kind != "U":
        return kind
    unknown = set(kind.ravel()) - set(LAWS)
    if unknown:
        raise ValueError(f"no contact law {', '.join(sorted(unknown))}; there are {', '.join(LAWS)}")
    return np.vectorize(LAWS.index, otypes=[int])(kind)


def rubbed(trial, limit, cone):
    """What friction lets through of the forces (..., 2) that two sliders would carry if both stuck.

    limit : (..., 2) mu N, the bound of each force alone or, where `cone`, of the length of both together. Real parts decide.
    Returns the forces, and (..., 2) 0 for stick, +1 or -1 for slip with that sign of the force.
    """
    size = np.where(trial.real < 0, -trial, trial)
    if np.any(cone):
        size = np.where(cone, np.sqrt(np.sum(trial ** 2, axis=-1, keepdims=True)), size)
    slips = size.real > limit.real
    if not slips.any():
        return trial, np.zeros(slips.shape, int)
    force = np.where(slips, limit * (trial / np.where(slips, size, 1)), trial)
    return force, np.where(slips, np.where(trial.real < 0, -1, 1), 0)


def cone_step(force, step, before, now):
    """Friction in the plane over a step in which motion and normal force go linearly, exactly: (..., 2) forces at its end.

    force : (..., 2) T at its beginning; step : (..., 2) what T would grow by if it stuck; before, now : (..., 1) mu N then and now.
    T sticks until it meets the bound R, then T' = y' - lambda T with |T| = R: the angle psi from y' to T follows
    tan(psi / 2) = tan(psi_0 / 2) exp(-integral of |y'| / R). Real parts decide. Also returns (..., 1) whether it slips at the end.
    """
    def dot(a, b):
        return np.sum(a * b, axis=-1, keepdims=True)

    def safe(x):
        return np.where(x == 0, 1, x)
    trial = force + step
    slips = np.sqrt(dot(trial, trial)).real > now.real
    grows = now - before
    a, b, c = dot(step, step) - grows ** 2, dot(force, step) - before * grows, dot(force, force) - before ** 2
    c = np.where(c.real > 0, 0, c)
    root = np.sqrt(np.where((b * b - a * c).real > 0, b * b - a * c, 0))
    s = np.where(b.real > 0, -c / safe(b + root), np.where(a.real > 0, (root - b) / safe(a), 0))
    s = np.where(s.real > 1, 1, s)
    bound, start, rest = before + s * grows, force + s * step, (1 - s) * step
    length, size = np.sqrt(dot(rest, rest)), np.sqrt(dot(start, start))
    u, e = rest / safe(length), start / safe(size)
    cosine, sine = dot(e, u), u[..., :1] * e[..., 1:] - u[..., 1:] * e[..., :1]
    growth = now / safe(bound) - 1
    small = np.abs(growth) < 1e-4
    series = 1 - growth * (0.5 - growth * (1 / 3 - growth / 4))
    mean = np.where(small, series, np.log1p(np.where(small, 1, growth)) / safe(growth))
    turned = np.exp(-length / safe(bound) * mean)
    ahead, behind = 1 + cosine, (1 - cosine) * turned ** 2
    turned = 2 * sine * turned / safe(ahead + behind)
    arc = now * ((ahead - behind) / safe(ahead + behind) * u + turned * np.concatenate([-u[..., 1:], u[..., :1]], axis=-1))
    landed, straight = bound.real <= 1e-6 * now.real, length.real <= 1e-6 * now.real
    drawn = np.where(landed, rest, start + rest)
    drawn = now * drawn / safe(np.sqrt(dot(drawn, drawn)))
    return np.where(slips, np.where(landed | straight, drawn, arc), trial), slips


def law(x, xp, w, kn, kt, mu, gap, kind="coulomb"):
    """Contact force over one period, by one of four laws.

    coulomb: the normal force is N = kn max(0, p), p the approach beyond lift-off. In each tangential direction a slider, a
    spring kt between the surface and a foot at w: it holds (stick) while |kt (x_t - w)| <= mu N, else the foot is dragged
    along (slip) so that the force stays at mu N. An open contact carries nothing; when it lands, the foot is set where the
    surface was at the instant p = 0, interpolated linearly between the two samples.
    cone: the same, but the length of the two tangential forces together is bounded by mu N, and the foot is dragged in their
    direction; between two samples motion and normal force are taken to be linear (`cone_step`).
    unilateral: N alone, no friction. bilateral: N = kn p of either sign, never open.
    The period is marched twice, starting with the foot at w, and the second time round is kept: by then the force is periodic,
    but for the cone, which goes round until it is (to 1e-10 of the largest bound mu N), a hundred times at most.

    Parameters
    ----------
    x : (..., N, 3) displacement from the preload state, t1, t2, n, at N equal steps of one period [m]; may be complex
        (complex-step derivatives): only real parts decide about states
    xp : (..., 3) preload displacement [m]
    w : (..., 2) foot of the two sliders at preload, in total displacement [m]
    kn, gap : (...); kt, mu : (..., 2) as in `Contact`
    kind : (...) names in `LAWS`, or their numbers

    Returns
    -------
    force : (..., N, 3) total contact force g(x + xp) [N]
    state : (..., N, 2) 0 stick, +1 or -1 slip with that sign of the force, 2 open; 0 while closed if there is no friction
    """
    kind = law_numbers(kind)[..., None, None]
    rubs, cone = kind <= CONE, kind == CONE
    total = np.asarray(x) + np.asarray(xp)[..., None, :]
    surface = total[..., :2]
    approach = total[..., 2:] - np.asarray(gap)[..., None, None]
    kn, kt, mu = np.asarray(kn)[..., None, None], np.asarray(kt)[..., None, :], np.asarray(mu)[..., None, :]
    kt, mu = np.where(rubs, kt, 1), np.where(rubs, mu, 0)

    # of all samples at once, what does not hang on the feet
    is_open = (approach.real <= 0) & (kind != BILATERAL)
    normal = np.where(is_open, 0, kn * approach)
    before, p_before = np.roll(surface, 1, axis=-2), np.roll(approach, 1, axis=-2)
    lands = np.roll(is_open, 1, axis=-2) & ~is_open
    touch = before + p_before / np.where(lands, p_before - approach, 1) * (surface - before)
    close = 1e-10 * (mu * kn * np.maximum(approach.real.max(axis=-2, keepdims=True), 0))[..., 0, :]
    here, touch, limit, bound, lands = (np.ascontiguousarray(np.moveaxis(np.broadcast_to(values, surface.shape), -2, 0))
                                        for values in (surface, touch, mu * normal, mu * kn * p_before, lands))

    kt, cone = kt[..., 0, :], cone[..., 0, :]
    feet = marched(w, here, touch, lands, limit / kt)
    force, sign = rubbed(kt * (here - np.where(lands, touch, feet)), limit, False)
    if cone.any():
        by_cone = marched_cone(w, here, touch, lands, limit, bound, kt, np.where(cone, close, np.inf))
        force, sign = (np.where(cone, one, other) for one, other in zip(by_cone, (force, sign)))
    force, sign = np.moveaxis(force, 0, -2), np.moveaxis(sign, 0, -2)
    force = np.concatenate([np.where(is_open | ~rubs, 0, force), normal], axis=-1)
    return force, np.where(is_open, OPEN, np.where(rubs, sign, 0))


def marched(w, here, touch, lands, reach):
    """Feet (N, ..., 2) before each sample of the second round, from w; each sample drags them to within `reach` of the surface.

    here, touch, lands, reach : (N, ..., 2) where the surface is, and was on landing; whether it lands; mu N / kt. Real parts decide.
    """
    def drag_complex(w, low, high):
        return np.where(w.real < low.real, low, np.where(w.real > high.real, high, w))

    def drag_real(w, low, high):
        return np.minimum(np.maximum(w, low), high)
    drag = drag_complex if np.iscomplexobj(here) else drag_real
    low, high = here - reach, here + reach
    w = drag(np.broadcast_to(w, here.shape[1:]), low[0], high[0])  # nothing precedes the first sample of the first round
    landed = drag(touch, low, high)
    low, high = np.where(lands, landed, low), np.where(lands, landed, high)
    for j in range(1, len(here)):
        w = drag(w, low[j], high[j])
    feet = np.empty_like(here)
    for j in range(len(here)):
        feet[j] = w
        w = drag(w, low[j], high[j])
    return feet


def marched_cone(w, here, touch, lands, limit, bound, kt, close):
    """Forces and signs (N, ..., 2) of the cone in the last round: when the force at its end is that of the one before, to `close`.

    bound : (N, ..., 2) mu N at the sample before each.
    """
    forces, signs = np.zeros_like(here), np.zeros(here.shape, int)
    began = False  # nothing precedes the first sample of the first round
    end = np.inf
    for _ in range(100):
        for j in range(len(here)):
            w = np.where(lands[j] & began, touch[j], w)
            trial = kt * (here[j] - w)
            force, sign = rubbed(trial, limit[j], True)
            if began:
                first, least = (np.where(lands[j], 0, values) for values in (kt * (here[j - 1] - w), bound[j]))
                with np.errstate(all="ignore"):  # of other laws, and of steps that stick
                    force, slips = cone_step(first, trial - first, least[..., :1], limit[j][..., :1])
                force = np.where(limit[j].real > 0, force, 0)  # also while open
                sign = np.where(slips, np.where(force.real < 0, -1, 1), 0)
            began = True
            w = np.where(sign == 0, w, here[j] - force / kt)
            forces[j], signs[j] = force, sign
        moved, end = np.abs(force - end), force
        if not (moved > close).any():
            break
    return forces, signs


def contact_coefficients(X, contact, preload, samples):
    """Coefficients G of g(x + xp) - g(xp) for all points.

    X : (..., N_x, 3, 2H+1) coefficients of the displacement [m]. Returns an array of the same shape [N].
    """
    x = np.swapaxes(synthesis(X, samples), -1, -2)
    force, _ = law(x, preload.xp, preload.w, contact.kn, contact.kt, contact.mu, contact.gap, contact.kind)
    return analysis(np.swapaxes(force - preload.g[:, None, :], -1, -2), X.shape[-1] // 2)


def contact_jacobian(X, contact, preload, samples):
    """dG/dX by complex step: (N_x, 3, 2H+1, 3, 2H+1) [N/m]; a point's force depends on that point alone."""
    points, _, size = X.shape
    h = 1e-30
    moved = X + 1j * h * np.eye(3 * size).reshape(3 * size, 1, 3, size)
    columns = contact_coefficients(moved, contact, preload, samples).imag / h
    return np.moveaxis(columns.reshape(3, size, points, 3, size), (0, 1), (3, 4))
