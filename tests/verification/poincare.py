"""Stability by time integration alone: a periodic motion found by shooting, and its multipliers by differences.

The map over one period is that of `truth.PiecewiseLinear`, exact between contact events. Its state is displacement and velocity
of all dofs, and the feet of those sliders that stick when the period begins and move at some time in it.
"""

import numpy as np

import truth
from dovetail import reference

STEP = 1e-6  # of differences, relative to the size of the motion


class Orbit:
    """The motion near coefficients q (n, 2H+1) of a case at omega, and its map over one period in `steps` steps.

    `steps`: events are looked for at the end of each, so two of them must not fall in one.
    """

    def __init__(self, case, omega, q, steps):
        reduced, preload, contact = case.reduced, case.preload, case.contact
        system = case.system(samples=1024)
        self.modes, self.n, self.steps, self.omega = system.modes, len(system.K), steps, omega
        dofs = self.modes + np.arange(3 * contact.points).reshape(-1, 3)
        force, static = np.r_[reduced.fa, reduced.fx], np.r_[np.zeros(self.modes), -reduced.r]
        self.system = truth.PiecewiseLinear(system.M, system.C, system.K, dofs, contact, force,
                                            case.settings["fourier"], static, omega)
        k = np.arange(1, q.shape[1] // 2 + 1)
        z, feet = np.zeros(self.system.size), 2 * self.n
        z[:self.n] = q[:, 0] / 2 + q[:, 1::2].sum(axis=1)
        z[self.modes:self.n] += preload.xp.ravel()
        z[self.n:feet] = omega * q[:, 2::2] @ k
        z[self.system.waves] = 1
        z[self.system.waves + 1::2] = 1
        self.states, held = np.zeros((contact.points, 2), int), []
        for j in range(contact.points):
            x = reference.synthesis(q[self.modes + 3 * j:self.modes + 3 * j + 3], 4096).T
            force, states = reference.law(x, preload.xp[j], preload.w[j], contact.kn[j], contact.kt[j], contact.mu[j],
                                          contact.gap[j], contact.kind[j])
            self.states[j] = states[0]
            for t in range(2):
                z[feet + 2 * j + t] = z[dofs[j, t]] - force[0, t] / contact.kt[j, t]
                if states[0, t] == reference.STICK and states[:, t].any():
                    held.append(feet + 2 * j + t)
        self.z, self.free = z, np.r_[0:feet, held].astype(int)
        size = max(np.abs(q[:, 1:]).max(), 1e-6)
        self.unit = np.full(len(self.free), size)  # of each state
        self.unit[self.n:feet] *= omega

    def map(self, y, periods=1):
        """State y after that many periods."""
        z, states = self.z.copy(), self.states
        z[self.free] = y
        for _ in range(periods * self.steps):
            z, states = self.system.advance(z, states, 2 * np.pi / self.omega / self.steps)
        return z[self.free]

    def derivative(self, y, step=STEP):
        """The map's, at y, by differences to both sides."""
        columns = []
        for i, unit in enumerate(step * self.unit):
            e = np.zeros(len(y))
            e[i] = unit
            columns.append((self.map(y + e) - self.map(y - e)) / (2 * unit))
        return np.array(columns).T

    def close(self, tolerance=1e-9, iterations=25):
        """The periodic state, by Newton's method on map(y) - y = 0 with the derivative renewed only where it does not help."""
        y, slope, last = self.z[self.free], None, np.inf
        for _ in range(iterations):
            change = self.map(y) - y
            gap = np.abs(change / self.unit).max()
            if gap < tolerance:
                return y
            if slope is None or gap > 0.3 * last:
                slope = self.derivative(y)
            last, y = gap, y + np.linalg.lstsq(np.eye(len(y)) - slope, change, rcond=1e-10)[0]
        raise RuntimeError(f"no periodic motion found at {self.omega}: still open by {gap:g}")

    def distance(self, a, b):
        return np.linalg.norm((a - b) / self.unit)
