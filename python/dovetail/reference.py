"""Forced response of small structures with frictional joints, in plain NumPy.

The same mathematics as the compiled core, written to be read: start with `law`. Everything is dense, and the derivative
of the contact force is taken by complex step, so that nothing here shares an idea with the core except the equations.
Numbers in parentheses are equations of the theory page; units are those of the model (SI in the examples).

    reduced = craig_bampton(K, M, contact_dofs, force, preload, modes=2)
    contact = Contact.uniform(1, normal_stiffness=1.0, tangential_stiffness=1.0, friction=1.0, gap=-3.5)
    system = HarmonicBalance(reduced, contact, contact_preload(reduced, contact), 0.05, [0, 0, 1], 10, 64)
    omega, q = system.continuation(0.9, 1.3, 0.05)
"""

from dataclasses import dataclass
from itertools import islice

import numpy as np
import scipy.linalg

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
    alone = np.where(trial.real < 0, -trial, trial)
    together = np.sqrt(np.sum(trial ** 2, axis=-1, keepdims=True))
    size = np.where(cone, together, alone)
    slips = size.real > limit.real
    force = np.where(slips, limit * (trial / np.where(slips, size, 1)), trial)
    return force, np.where(slips, np.where(trial.real < 0, -1, 1), 0)


def law(x, xp, w, kn, kt, mu, gap, kind="coulomb"):
    """Contact force over one period, by one of four laws.

    coulomb: the normal force is N = kn max(0, p), p the approach beyond lift-off. In each tangential direction a slider, a
    spring kt between the surface and a foot at w: it holds (stick) while |kt (x_t - w)| <= mu N, else the foot is dragged
    along (slip) so that the force stays at mu N. An open contact carries nothing; when it lands, the foot is set where the
    surface was at the instant p = 0, interpolated linearly between the two samples.
    cone: the same, but the length of the two tangential forces together is bounded by mu N, and the foot is dragged in their
    direction. unilateral: N alone, no friction. bilateral: N = kn p of either sign, never open.
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
    kind = law_numbers(kind)[..., None]
    rubs, cone = kind <= CONE, kind == CONE
    total = np.asarray(x) + np.asarray(xp)[..., None, :]
    surface = total[..., :2]
    approach = total[..., 2:] - np.asarray(gap)[..., None, None]
    kn, kt, mu = np.asarray(kn)[..., None], np.where(rubs, kt, 1), np.where(rubs, mu, 0)
    force = np.zeros_like(total)
    state = np.zeros(surface.shape, int)
    was_open = False  # nothing precedes the first sample of the first pass
    close = 1e-10 * mu * kn * np.maximum(approach.real.max(axis=-2), 0)
    end = np.inf  # forces at the end of the round before
    for _ in range(100):
        for j in range(total.shape[-2]):
            here, p = surface[..., j, :], approach[..., j, :]
            before, p_before = surface[..., j - 1, :], approach[..., j - 1, :]
            is_open = (p.real <= 0) & (kind != BILATERAL)
            landing = was_open & ~is_open
            instant = p_before / np.where(landing, p_before - p, 1)
            w = np.where(landing, before + instant * (here - before), w)

            normal = np.where(is_open, 0, kn * p)
            trial = kt * (here - w)
            tangential, sign = rubbed(trial, mu * normal, cone)
            w = np.where(sign == 0, w, here - tangential / kt)

            force[..., j, :2] = np.where(is_open | ~rubs, 0, tangential)
            force[..., j, 2:] = normal
            state[..., j, :] = np.where(is_open, OPEN, np.where(rubs, sign, 0))
            was_open = is_open
        moved, end = np.abs(tangential - end), tangential
        if np.isfinite(moved).all() and not (cone & (moved > close)).any():
            break
    return force, state


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


# --------------------------------------------------------------------------------------------- reduction and preload
@dataclass(frozen=True)
class Reduced:
    """Craig-Bampton model: kaa, fa (N_a,); max (N_a, n_c); mxx, kxx (n_c, n_c); fx, r (n_c,); n_c = 3 N_x."""

    kaa: np.ndarray
    max: np.ndarray
    mxx: np.ndarray
    kxx: np.ndarray
    fa: np.ndarray
    fx: np.ndarray
    r: np.ndarray


@dataclass(frozen=True)
class Preload:
    """Preload state of the contact points: xp (N_x, 3) [m], g (N_x, 3) [N], w (N_x, 2) [m]."""

    xp: np.ndarray
    g: np.ndarray
    w: np.ndarray


def split(K, M, contact_dofs):
    """Elastic dofs (all others, ascending), contact dofs (t1, t2, n of each point), and K, M as dense arrays."""
    K, M = (A.toarray() if hasattr(A, "toarray") else np.asarray(A, float) for A in (K, M))
    c = np.asarray(contact_dofs).ravel()
    return np.setdiff1d(np.arange(len(K)), c), c, K, M


def bases(K, M, contact_dofs, modes):
    """Fixed-interface modes Phi, their w^2 (15), and constraint modes Psi (16)."""
    e, c, K, M = split(K, M, contact_dofs)
    squares, phi = scipy.linalg.eigh(K[np.ix_(e, e)], M[np.ix_(e, e)])
    squares, phi = squares[:modes], phi[:, :modes]
    for mode in phi.T:  # sign: the largest entry is positive, the first one where several are equally large
        largest = np.abs(mode).max()
        mode *= np.sign(mode[np.argmax(np.abs(mode) > (1 - 1e-6) * largest)])
    return squares, phi, -np.linalg.solve(K[np.ix_(e, e)], K[np.ix_(e, c)])


def craig_bampton(K, M, contact_dofs, force, preload, modes):
    """Reduce a full model (1) to its contact dofs and `modes` fixed-interface modes: (2), (5), (15)-(18).

    K, M : (n, n) sparse or dense; contact_dofs : (N_x, 3) indices of t1, t2, n; force, preload : (n,) [N].
    """
    squares, phi, psi = bases(K, M, contact_dofs, modes)
    e, c, K, M = split(K, M, contact_dofs)
    Kee, Kec, Kcc = K[np.ix_(e, e)], K[np.ix_(e, c)], K[np.ix_(c, c)]
    Mee, Mec, Mcc = M[np.ix_(e, e)], M[np.ix_(e, c)], M[np.ix_(c, c)]
    return Reduced(kaa=squares,
                   max=phi.T @ (Mee @ psi + Mec),
                   mxx=psi.T @ Mee @ psi + psi.T @ Mec + Mec.T @ psi + Mcc,
                   kxx=Kcc + Kec.T @ psi,
                   fa=phi.T @ force[e],
                   fx=psi.T @ force[e] + force[c],
                   r=Kec.T @ np.linalg.solve(Kee, preload[e]) - preload[c])


def static_force(x, contact):
    """Force reached in one step from a foot at zero: g (N_x, 3) at total displacement x (N_x, 3), and the foot then, w (N_x, 2)."""
    rubs, cone = (contact.kind <= CONE)[:, None], (contact.kind == CONE)[:, None]
    p = x[:, 2] - contact.gap
    is_open = (p.real <= 0) & (contact.kind != BILATERAL)
    normal = np.where(is_open, 0, contact.kn * p)
    kt = np.where(rubs, contact.kt, 1)
    tangential, sign = rubbed(kt * x[:, :2], contact.mu * normal[:, None], cone)
    tangential = np.where(is_open[:, None] | ~rubs, 0, tangential)
    moves = rubs & (is_open[:, None] | (sign != 0))
    w = np.where(moves, x[:, :2] - tangential / kt, 0)
    return np.column_stack([tangential, normal]), w


def static_law(x, contact):
    """`static_force` and its derivative by complex step: g (N_x, 3), w (N_x, 2), dg/dx (N_x, 3, 3).

    In the derivative p = 0 counts as closed and stuck, so that a body held by its joint alone can be pushed onto it.
    """
    h = 1e-30
    slope = np.stack([static_force(x + 1j * h * direction, contact)[0].imag / h for direction in np.eye(3)], axis=2)
    springs = np.column_stack([(contact.kind <= CONE)[:, None] * contact.kt, contact.kn])
    touching = x[:, 2] == contact.gap
    slope[touching] = springs[touching, :, None] * np.eye(3)
    return *static_force(x, contact), slope


def contact_preload(reduced, contact, initial=0.0):
    """Solve K_xx xp + g(xp) = -R (7) by Newton's method from `initial` (a number, or one per contact dof) [m]."""
    def residual(x):
        return reduced.kxx @ x + static_law(x.reshape(-1, 3), contact)[0].ravel() + reduced.r

    def jacobian(x):
        return reduced.kxx + scipy.linalg.block_diag(*static_law(x.reshape(-1, 3), contact)[2])

    start = np.broadcast_to(np.asarray(initial, float), reduced.r.shape)
    xp = newton(residual, jacobian, start).reshape(-1, 3)
    g, w, _ = static_law(xp, contact)
    return Preload(xp, g, w)


def newton(residual, jacobian, x, tolerance=1e-11, iterations=60):
    """Newton's method, steps halved while they do not reduce the residual; ends when the step is below `tolerance` |x|."""
    for _ in range(iterations):
        r = residual(x)
        step = -np.linalg.solve(jacobian(x), r)
        if np.linalg.norm(step) <= tolerance * np.linalg.norm(x + step):
            return x + step
        part = 1.0
        while part > 1e-3 and np.linalg.norm(residual(x + part * step)) >= np.linalg.norm(r):
            part /= 2
        x = x + part * step
    raise RuntimeError(f"Newton's method did not converge in {iterations} iterations")


# -------------------------------------------------------------------------------------------------- harmonic balance
class HarmonicBalance:
    """The equations (11) in real form. Unknowns q : (N_a + 3 N_x, 2H+1), modal ones first, measured from preload.

    xi : stiffness-proportional damping [s]; fourier : coefficients [a0, a1, b1, ...] of f(t); N : samples per period.
    """

    def __init__(self, reduced, contact, preload, xi, fourier, H, N):
        if len(fourier) > 2 * H + 1:
            raise ValueError(f"the excitation has {len(fourier)} coefficients, {H} harmonics carry {2 * H + 1}")
        self.contact, self.preload, self.xi, self.H, self.N = contact, preload, xi, H, N
        self.modes = len(reduced.kaa)
        self.K = scipy.linalg.block_diag(np.diag(reduced.kaa), reduced.kxx)
        self.M = np.block([[np.eye(self.modes), reduced.max], [reduced.max.T, reduced.mxx]])
        self.shape = (len(self.K), 2 * H + 1)
        self.excitation = np.zeros(self.shape)
        self.excitation[:, :len(fourier)] = np.outer(np.r_[reduced.fa, reduced.fx], fourier)

    def contact_part(self, q):
        """Coefficients (N_x, 3, 2H+1) of the contact displacements in q."""
        return q[self.modes:].reshape(-1, 3, self.shape[1])

    def harmonic_blocks(self, in_phase, quadrature):
        """Matrix (n (2H+1), n (2H+1)) that has D_k = in_phase(k) + i quadrature(k) as its harmonic k."""
        n, size = self.shape
        matrix = np.zeros((n, size, n, size))
        matrix[:, 0, :, 0] = in_phase(0)
        for k in range(1, self.H + 1):
            c, s = 2 * k - 1, 2 * k
            matrix[:, c, :, c] = matrix[:, s, :, s] = in_phase(k)
            matrix[:, c, :, s] = quadrature(k)
            matrix[:, s, :, c] = -quadrature(k)
        return matrix.reshape(n * size, n * size)

    def dynamic_stiffness(self, omega):
        """D_k = K - k^2 omega^2 M + i k omega xi K for all harmonics."""
        return self.harmonic_blocks(lambda k: self.K - (k * omega) ** 2 * self.M, lambda k: k * omega * self.xi * self.K)

    def residual(self, q, omega):
        """Left-hand side of (11) [N], in the shape of q."""
        r = (self.dynamic_stiffness(omega) @ q.ravel()).reshape(self.shape) - self.excitation
        G = contact_coefficients(self.contact_part(q), self.contact, self.preload, self.N)
        r[self.modes:] += G.reshape(-1, self.shape[1])
        return r

    def jacobian(self, q, omega):
        """Derivative of the flattened residual with respect to the flattened q (12)."""
        n, size = self.shape
        matrix = self.dynamic_stiffness(omega).reshape(n, size, n, size)
        blocks = contact_jacobian(self.contact_part(q), self.contact, self.preload, self.N)
        for point, block in enumerate(blocks):
            rows = slice(self.modes + 3 * point, self.modes + 3 * point + 3)
            matrix[rows, :, rows, :] += block
        return matrix.reshape(n * size, n * size)

    def omega_derivative(self, q, omega):
        """Derivative of the residual with respect to omega (13), in the shape of q."""
        slope = self.harmonic_blocks(lambda k: -2 * k ** 2 * omega * self.M, lambda k: k * self.xi * self.K)
        return (slope @ q.ravel()).reshape(self.shape)

    def solve(self, omega, q0=None):
        """Newton's method at one frequency [rad/s], from q0 (default: rest in the preload state)."""
        start = np.zeros(self.shape) if q0 is None else q0
        return newton(lambda z: self.residual(z.reshape(self.shape), omega).ravel(),
                      lambda z: self.jacobian(z.reshape(self.shape), omega), start.ravel()).reshape(self.shape)

    def continuation(self, omega_from, omega_to, step, largest=np.inf, smallest=1e-7, points=2000, q0=None):
        """Follow the solution by pseudo arc length: predictor along the tangent, corrector perpendicular to it.

        step, largest, smallest : arc lengths in the norm of [q, omega], user units. The step is halved when Newton's
        method fails and grows by a quarter when it does not. Ends exactly at omega_to.

        Returns omega (n,) [rad/s] and q (n, N_a + 3 N_x, 2H+1).
        """
        omega, q = zip(*islice(self.branch(omega_from, omega_to, step, largest, smallest, q0), points))
        return np.array(omega), np.array(q)

    def branch(self, omega_from, omega_to, step, largest=np.inf, smallest=1e-7, q0=None):
        """The points (omega, q) of `continuation` one by one, so that those before a failure are not lost."""
        def correct(predicted, tangent):
            return newton(lambda y: np.append(self.residual(y[:-1].reshape(self.shape), y[-1]), tangent @ (y - predicted)),
                          lambda y: self.bordered(y, tangent), predicted, iterations=10)

        sense = np.sign(omega_to - omega_from)
        y = np.append(self.solve(omega_from, q0), omega_from)
        yield omega_from, y[:-1].reshape(self.shape)
        tangent = sense * np.eye(len(y))[-1]
        while y[-1] != omega_to:
            tangent = self.tangent(y, tangent)
            try:
                new = correct(y + step * tangent, tangent)
            except RuntimeError:
                step /= 2
                if step < smallest:
                    raise
                continue
            if sense * (new[-1] - omega_to) >= 0:
                part = (omega_to - y[-1]) / (new[-1] - y[-1])
                start = (y + part * (new - y))[:-1].reshape(self.shape)
                new = np.append(self.solve(omega_to, start), omega_to)
            y = new
            yield y[-1], y[:-1].reshape(self.shape)
            step = min(1.25 * step, largest)

    def bordered(self, y, row):
        """Jacobian with respect to y = [q, omega], completed by `row`."""
        q = y[:-1].reshape(self.shape)
        column = self.omega_derivative(q, y[-1]).ravel()
        return np.vstack([np.column_stack([self.jacobian(q, y[-1]), column]), row])

    def tangent(self, y, before):
        """Unit tangent of the solution curve at y = [q, omega], in the sense of the tangent `before`."""
        tangent = np.linalg.solve(self.bordered(y, before), np.eye(len(y))[-1])
        return tangent / np.linalg.norm(tangent)


# ---------------------------------------------------------------------------------------------------- the original
class Original(HarmonicBalance):
    """The published algorithm that Dovetail set out from, to show where and why it stops. Not a way to compute anything.

    It differs from `HarmonicBalance.continuation` in this:
    - The sliders' feet are memory: every evaluation of the residual begins where the one before it ended, so the equations
      that are solved depend on what was evaluated before. Here `foot` (N_x, 2) [m].
    - Contact is sampled, and the foot of an open contact is where the surface was at the last open sample.
    - The Jacobian of the contact forces is made of forward differences of `DIFFERENCE` metres, whatever the unit of length.
    - One arc length throughout, in the plain norm of [q, omega], user units; Newton's method without line search, and no
      second attempt: it converges within `ITERATIONS` or the sweep is over.
    What it has no part in is given to it: the preload state is that of `contact_preload`.
    """

    DIFFERENCE = 1e-8  # [m]
    TOLERANCE = 1e-5  # of the last step, relative to [q, omega], and of the residual [N]
    ITERATIONS = 50

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.foot = self.preload.w

    def march(self, X):
        """Coefficients of g(x + xp) - g(xp), and the feet after two periods begun at `foot`; X (..., N_x, 3, 2H+1) [m].

        w = min(max(w, low), high) with low, high = x_t -+ mu N / kt holds in stick, in slip, and with N = 0 in separation.
        """
        contact = self.contact
        x = synthesis(X, self.N) + self.preload.xp[..., None]
        normal = np.maximum(0, contact.kn[:, None] * (x[..., 2, :] - contact.gap[:, None]))
        surface = np.moveaxis(x[..., :2, :], -1, 0)  # samples first
        reach = np.moveaxis(normal, -1, 0)[..., None] * (contact.mu / contact.kt)
        low, high = surface - reach, surface + reach
        w = np.broadcast_to(self.foot, low.shape[1:])
        feet = np.empty_like(low)
        for j in 2 * list(range(self.N)):
            w = feet[j] = np.minimum(np.maximum(w, low[j]), high[j])
        tangential = np.where(reach > 0, contact.kt * (surface - feet), 0)
        force = np.concatenate([np.moveaxis(tangential, 0, -1), normal[..., None, :]], axis=-2)
        return analysis(force - self.preload.g[..., None], self.H), w

    def residual(self, q, omega):
        """Left-hand side of (11) [N] with the present feet, which it moves on."""
        r = (self.dynamic_stiffness(omega) @ q.ravel()).reshape(self.shape) - self.excitation
        G, self.foot = self.march(self.contact_part(q))
        r[self.modes:] += G.reshape(-1, self.shape[1])
        return r

    def jacobian(self, q, omega):
        """Derivative of the flattened residual by forward differences, all with the present feet, which stay.

        A point's force depends on that point alone, so one coefficient of all points is moved at a time: the original
        moves one of one point and gets the same numbers.
        """
        n, size = self.shape
        moves = np.vstack([np.zeros(3 * size), self.DIFFERENCE * np.eye(3 * size)]).reshape(-1, 1, 3, size)
        G, _ = self.march(self.contact_part(q) + moves)
        columns = (G[1:] - G[0]) / self.DIFFERENCE
        matrix = self.dynamic_stiffness(omega).reshape(n, size, n, size)
        for point in range(self.contact.points):
            rows = slice(self.modes + 3 * point, self.modes + 3 * point + 3)
            matrix[rows, :, rows, :] += np.moveaxis(columns[:, point].reshape(3, size, 3, size), (0, 1), (2, 3))
        return matrix.reshape(n * size, n * size)

    def branch(self, omega_from, omega_to, step, q0=None):
        """The points (omega, q, Newton iterations) one by one. Raises RuntimeError where the original stops."""
        sense = -1 if omega_to < omega_from else 1
        along_omega = sense * np.eye(self.excitation.size + 1)[-1]
        y, iterations = self.correct(np.append(np.zeros(self.shape) if q0 is None else q0, omega_from), along_omega)
        yield y[-1], y[:-1].reshape(self.shape), iterations
        tangent = self.tangent(y, along_omega)
        while omega_from != omega_to:
            y, iterations = self.correct(y + step * tangent, tangent)
            yield y[-1], y[:-1].reshape(self.shape), iterations
            tangent = self.tangent(y, tangent)
            if sense * (y[-1] + step * tangent[-1] - omega_to) > 0:  # the next point would lie beyond the end
                y, iterations = self.correct(np.append(y[:-1], omega_to), along_omega)
                yield y[-1], y[:-1].reshape(self.shape), iterations
                return

    def correct(self, predicted, row):
        """Newton's method in the plane through `predicted` across `row`: the solution [q, omega], iterations."""
        def defect(y):
            return np.append(self.residual(y[:-1].reshape(self.shape), y[-1]), row @ (y - predicted))

        y, r = predicted, defect(predicted)
        for iteration in range(1, self.ITERATIONS + 1):
            step = -np.linalg.solve(self.bordered(y, row), r)
            y = y + step
            r = defect(y)
            if np.linalg.norm(step) < self.TOLERANCE * np.linalg.norm(y) and np.linalg.norm(r) < self.TOLERANCE:
                return y, iteration
        raise RuntimeError(f"Newton's method did not converge in {self.ITERATIONS} iterations")
