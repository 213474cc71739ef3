"""Answers that owe nothing to harmonic balance: exact time integration, and closed forms.

Between two contact events the structure is linear, so `steady_state` advances it with its Taylor series, exact to
round-off, and finds each event (lift-off, landing, onset and end of slip) as a root of that series. What is left of the
error is the distance to the periodic motion, which the integration runs until it is below `tolerance`.
"""

from dataclasses import dataclass
from math import factorial

import numpy as np
from scipy.optimize import brentq

from dovetail import curves

STICK, OPEN = 0, 2
ORDER = 16  # of the Taylor series; the remainder is below 1e-15 while the step times the norm of A stays below 0.7


@dataclass
class Orbit:
    """One period of the steady state at equal steps: u, v (steps, n), states (steps, N_x, 2) as in `reference.law`."""

    u: np.ndarray
    v: np.ndarray
    states: np.ndarray
    last_change: float  # largest difference between the last two periods [unit of u]


class PiecewiseLinear:
    """M u'' + C u' + K u + g(u) = excitation + static, with the contact law in continuous time.

    The state z holds u, v, the feet of the sliders w (t1, t2 of each point), and the excitation 1, cos, sin, cos 2, ...,
    so that each set of contact states has its own constant A in z' = A z.
    """

    def __init__(self, M, C, K, contact_dofs, contact, force, fourier, static, omega):
        self.inverse, self.C, self.K = np.linalg.inv(M), C, K
        self.dofs, self.contact = np.asarray(contact_dofs), contact
        self.static, self.excitation, self.omega = static, excitation(force, fourier), omega
        self.n, self.points = len(K), len(self.dofs)
        self.waves = 2 * self.n + 2 * self.points  # where 1, cos, sin, ... begin
        self.size = self.waves + self.excitation.shape[1]
        self.series_of = {}

    def row(self, *terms):
        """Row vector with the given (index, value) entries."""
        e = np.zeros(self.size)
        for index, value in terms:
            e[index] += value
        return e

    def normal(self, point):
        """N while closed, negative where open [N]."""
        kn = self.contact.kn[point]
        return self.row((self.dofs[point, 2], kn), (self.waves, -kn * self.contact.gap[point]))

    def trial(self, point, t):
        """T of a slider that holds [N]."""
        kt = self.contact.kt[point, t]
        return self.row((self.dofs[point, t], kt), (2 * self.n + 2 * point + t, -kt))

    def friction(self, point, t, state):
        if state == OPEN:
            return self.row()
        return self.trial(point, t) if state == STICK else state * self.contact.mu[point, t] * self.normal(point)

    def events(self, states):
        """Rows that are positive while the states hold, and which (point, direction) each one ends."""
        rows, who = [], []
        for point in range(self.points):
            is_open = states[point, 0] == OPEN
            rows.append(-self.normal(point) if is_open else self.normal(point))
            who.append((point, None))
            for t in range(0 if is_open else 2):
                s, mu, kt = states[point, t], self.contact.mu[point, t], self.contact.kt[point, t]
                if s == STICK:
                    rows += [mu * self.normal(point) - sign * self.trial(point, t) for sign in (1, -1)]
                    who += 2 * [(point, t)]
                else:  # slips while the foot moves with the force
                    slope = s * mu * self.contact.kn[point] / kt
                    rows.append(s * self.row((self.n + self.dofs[point, t], 1), (self.n + self.dofs[point, 2], -slope)))
                    who.append((point, t))
        return np.array(rows), who

    def series(self, states):
        """A^k / k! for k = 0..ORDER, stacked, and the events, of one set of states."""
        key = states.tobytes()
        if key not in self.series_of:
            n, A = self.n, np.zeros((self.size, self.size))
            acceleration = np.zeros((n, self.size))
            acceleration[:, :n], acceleration[:, n:2 * n] = -self.K, -self.C
            acceleration[:, self.waves] = self.static + self.excitation[:, 0] / 2
            acceleration[:, self.waves + 1:] = self.excitation[:, 1:]
            for point in range(self.points):
                if states[point, 0] != OPEN:
                    acceleration[self.dofs[point, 2]] -= self.normal(point)
                    for t in range(2):
                        acceleration[self.dofs[point, t]] -= self.friction(point, t, states[point, t])
            A[:n, n:2 * n] = np.eye(n)
            A[n:2 * n] = self.inverse @ acceleration
            for k in range(1, self.excitation.shape[1] // 2 + 1):
                c, s = self.waves + 2 * k - 1, self.waves + 2 * k
                A[c, s], A[s, c] = -k * self.omega, k * self.omega
            powers = [np.linalg.matrix_power(A, k) / factorial(k) for k in range(ORDER + 1)]
            self.series_of[key] = np.concatenate(powers), *self.events(states)
        return self.series_of[key]

    def after(self, states, z, point, t):
        """States and feet beyond the event (point, t): t None is lift-off or landing."""
        states, z, foot = states.copy(), z.copy(), 2 * self.n + 2 * point
        tangent, velocity = z[self.dofs[point, :2]], z[self.n + self.dofs[point]]
        if t is not None and states[point, t] == STICK:
            states[point, t] = np.sign(self.trial(point, t) @ z)
        elif t is not None:
            z[foot + t] = tangent[t] - self.friction(point, t, states[point, t]) @ z / self.contact.kt[point, t]
            states[point, t] = STICK
        elif states[point, 0] != OPEN:
            states[point] = OPEN
        else:
            z[foot:foot + 2] = tangent
            slips = self.contact.kt[point] * abs(velocity[:2]) > self.contact.mu[point] * self.contact.kn[point] * velocity[2]
            states[point] = np.where(slips, np.sign(velocity[:2]), STICK)
        return states, z

    def advance(self, z, states, step):
        """State one step later, through all events inside it."""
        left = step
        for _ in range(100):
            stack, rows, who = self.series(states)
            terms = (stack @ z).reshape(ORDER + 1, -1)
            end = left ** np.arange(ORDER + 1) @ terms
            passed = np.flatnonzero(rows @ end < -1e-13 * (np.abs(rows) @ np.abs(end)))
            if len(passed) == 0:
                return end, states
            instants = [crossing(terms @ rows[i], left) for i in passed]
            first = np.argmin(instants)
            states, z = self.after(states, instants[first] ** np.arange(ORDER + 1) @ terms, *who[passed[first]])
            left -= instants[first]
        raise RuntimeError("more than 100 contact events in one step")


def excitation(force, fourier):
    """Coefficients (n, 2H+1) of force f(t), or of the sum over several patterns (L, n), each with its own series."""
    courses = [fourier] if np.ndim(fourier[0]) == 0 else fourier
    total = np.zeros((np.shape(force)[-1], 1 + 2 * max(len(course) // 2 for course in courses)))
    for pattern, course in zip(np.atleast_2d(force), courses, strict=True):
        total[:, :len(course)] += np.outer(pattern, course)
    return total


def crossing(coefficients, end):
    """First instant in [0, end] at which a polynomial, negative at `end`, becomes negative."""
    def value(s):
        return np.polyval(coefficients[::-1], s)

    grid = np.linspace(0, end, 9)
    first = 1 + np.argmax(value(grid[1:]) < 0)
    if value(grid[first - 1]) <= 0:
        return grid[first - 1]
    return brentq(value, grid[first - 1], grid[first], xtol=1e-16, rtol=1e-14)


def steady_state(M, damping, K, contact_dofs, contact, force, fourier, static, omega, start, feet, steps=512, tolerance=1e-10,
                 periods=1000):
    """Steady state of the full model (1), reached from rest at `start` with the sliders' feet at `feet`.

    M, K : (n, n); damping : C (n, n), or xi [s] of xi K; contact_dofs (N_x, 3); force, static, start (n,); feet (N_x, 2); omega [rad/s].
    Several load patterns: force (L, n), and one series for each in fourier.
    Where a slider never slips, the mean it settles to depends on the start: then compare with means removed.
    """
    C = damping * K if np.isscalar(damping) else damping
    system = PiecewiseLinear(M, C, K, contact_dofs, contact, force, fourier, static, omega)
    n = system.n
    z = np.zeros(system.size)
    z[:n], z[2 * n:system.waves] = start, np.ravel(feet)
    z[system.waves] = 1
    z[system.waves + 1::2] = 1
    states = np.zeros((system.points, 2), int)
    states[start[system.dofs[:, 2]] <= contact.gap] = OPEN
    step = 2 * np.pi / omega / steps
    before = None
    for _ in range(periods):
        motion, history = np.empty((steps, 2 * n)), np.empty((steps, system.points, 2), int)
        for j in range(steps):
            motion[j], history[j] = z[:2 * n], states
            z, states = system.advance(z, states, step)
        change = np.inf if before is None else np.abs(motion - before)[:, :n].max()
        if change <= tolerance * np.abs(motion[:, :n]).max():
            return Orbit(motion[:, :n], motion[:, n:], history, change)
        before = motion
    raise RuntimeError(f"no steady state after {periods} periods: the last change was {change:g}")


def linear_response(K, M, damping, force, fourier, omega, springs, loss=0.0):
    """Coefficients (n, 2H+1) of the steady state of M q'' + C q' + (K + i loss + diag(springs)) q = `excitation`.

    damping : C (n, n), or xi [s] of C = xi K; loss : (n, n), hysteretic, in all harmonics but the mean.
    """
    E = excitation(force, fourier)
    C = damping * K if np.isscalar(damping) else damping
    q = np.zeros(E.shape)
    q[:, 0] = np.linalg.solve(K + np.diag(springs), E[:, 0])
    for k in range(1, E.shape[1] // 2 + 1):
        stiffness = K + 1j * (k * omega * C + loss) + np.diag(springs) - (k * omega) ** 2 * M
        z = np.linalg.solve(stiffness, E[:, 2 * k - 1] - 1j * E[:, 2 * k])
        q[:, 2 * k - 1], q[:, 2 * k] = z.real, -z.imag
    return q


def jenkins_loop_area(X, kt, limit):
    """Energy per cycle [J] that a slider of stiffness kt [N/m] and slip force `limit` [N] takes from x = X cos [m]."""
    return 4 * limit * max(0, X - limit / kt)


def over_the_cycle(results, dof):
    """Largest absolute value over the cycle at every point, (n,), mean included, as published curves have it."""
    return np.array([peak(row) for row in results.coefficients[:, results.dof_index(dof)]])


def top(results, values):
    """(omega, value) at the top of a curve, by a parabola through three points."""
    return curves.top(results.omega, results.points("arclength"), values, int(np.argmax(values)))


def peak(coefficients):
    """Largest absolute value over the cycle of one coefficient row [a0, a1, b1, ...], mean included, to 1e-9 relative."""
    angle = np.linspace(0, 2 * np.pi, 4097)
    harmonics = np.arange(1, len(coefficients) // 2 + 1)

    def value(t):
        t = np.multiply.outer(t, harmonics)
        return coefficients[0] / 2 + np.cos(t) @ coefficients[1::2] + np.sin(t) @ coefficients[2::2]

    i = np.argmax(np.abs(value(angle)))
    fine = angle[i] + np.linspace(-1, 1, 4097) * angle[1]
    return np.abs(value(fine)).max()
