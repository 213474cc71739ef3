"""The algorithm of the published program."""

import numpy as np

from .balance import HarmonicBalance
from .contact import analysis, synthesis


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
