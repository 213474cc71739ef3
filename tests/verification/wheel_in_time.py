"""A wheel of all sectors, integrated in time, from the reduced matrices of every index of one sector.

Nothing of harmonic balance and no cyclic symmetry is in it: every sector has its own modes, contact points and sliders, coupled with
all others. The structure is stepped exactly in its modes, contact forces are taken to change linearly in a step.
"""

import numpy as np
import scipy.linalg

import cyclic_sector
from whole_rotor import N


def later(Z, engine_order):
    """Z (n, H+1) of sector 0 as (N, n, H+1) of all."""
    h = np.array([cyclic_sector.index(k, engine_order) for k in range(Z.shape[1])])
    return Z * np.exp(-2j * np.pi * np.arange(N)[:, None, None] * h / N)


def complex_series(coefficients):
    """[a0, a1, b1, ...] along the last axis as Z_k = a_k - i b_k, the mean first."""
    c = np.asarray(coefficients, float)
    return np.concatenate([c[..., :1] / 2, c[..., 1::2] - 1j * c[..., 2::2]], axis=-1)


class Wheel:
    def __init__(self, models, contact, stiffness_damping, loads, engine_order, omega, preload, steps):
        """models : of index 0 .. N/2 (`cyclic_sector.of_every_index`); contact : kn, kt, mu, gap of a sector's points; loads : one
        series [a0, a1, b1, ...] per pattern; preload : xp, w of a sector; steps : per period."""
        self.steps, self.engine_order, self.omega = steps, engine_order, omega
        self.modes, self.n = len(models[0]["Kaa"]), len(models[0]["Kaa"]) + len(models[0]["R"])
        pairs = []
        for model in models:
            K = scipy.linalg.block_diag(np.diag(model["Kaa"]), model["Kxx"])
            pairs.append((K, np.block([[np.eye(self.modes), model["Mxa"].conj().T], [model["Mxa"], model["Mxx"]]])))
        K, M = (self.of_all([pair[i] for pair in pairs]) for i in (0, 1))
        squares, shapes = scipy.linalg.eigh(K, M)
        squares[np.abs(squares) < 1e-10 * squares[-1]] = 0
        self.inverse = shapes.T @ M
        contact_rows = (self.n * np.arange(N)[:, None] + np.arange(self.modes, self.n)).ravel()
        self.of_contact = np.ascontiguousarray(shapes[contact_rows])
        self.onto_modes = np.ascontiguousarray(self.of_contact.T)
        self.propagate(squares, stiffness_damping * squares, 2 * np.pi / omega / steps)
        theta = 2 * np.pi * np.arange(steps) / steps
        force = np.zeros((steps, N, self.n))
        for pattern, series in enumerate(loads):
            Z = complex_series(series)
            F = [np.hstack([model["Fa"], model["Fx"]])[pattern] for model in models]
            h = [cyclic_sector.index(k, engine_order) for k in range(len(Z))]
            amplitudes = later(np.array([F[abs(i)].conj() if i < 0 else F[i] for i in h]).T * Z, engine_order)
            force += np.einsum("jnk,sk->sjn", amplitudes, np.exp(1j * np.outer(theta, range(len(Z))))).real
        self.load = force.reshape(steps, -1) @ shapes
        self.kn, self.kt, self.mu, self.gap = (np.tile(contact[key], (N,) + (1,) * (np.ndim(contact[key]) - 1))
                                               for key in ("kn", "kt", "mu", "gap"))
        self.xp, self.w = (np.tile(np.reshape(preload[i], (-1, 3 - i)), (N, 1)) for i in (0, 1))
        self.at_rest = self.contact_force(np.zeros(len(contact_rows)))

    @staticmethod
    def of_all(of_index):
        """Real, by sectors, from Hermitian matrices of index 0 .. N/2."""
        indices = [cyclic_sector.index(1, h) for h in range(N)]
        matrices = np.array([of_index[-h].conj() if h < 0 else of_index[h].astype(complex) for h in indices])
        turns = np.exp(-2j * np.pi * np.outer(np.arange(N), indices) / N)
        blocks = np.einsum("jh,lh,hrc->jrlc", turns, turns.conj(), matrices).real / N
        n = matrices.shape[1]
        return blocks.reshape(N * n, N * n)

    def propagate(self, squares, damping, dt):
        A = np.zeros((len(squares), 4, 4))
        A[:, 0, 1] = A[:, 1, 2] = A[:, 2, 3] = 1
        A[:, 1, 0], A[:, 1, 1] = -squares, -damping
        E = np.array([scipy.linalg.expm(a * dt) for a in A])
        self.to_q, self.to_v = ([E[:, row, 0], E[:, row, 1], E[:, row, 2], E[:, row, 3] / dt] for row in (0, 1))

    def contact_force(self, x):
        """And what the sliders become."""
        x = x.reshape(-1, 3) + self.xp
        normal = np.maximum(self.kn * (x[:, 2] - self.gap), 0)
        limit = self.mu * normal[:, None]
        friction = np.clip(self.kt * (x[:, :2] - self.w), -limit, limit)
        self.w = x[:, :2] - friction / self.kt
        return np.column_stack([friction, normal]).ravel()

    def start(self, coefficients, push):
        """On the wave of coefficients (n, 2H+1), sliders as after a period of it, displacements off by `push` (N, n)."""
        Z = later(complex_series(coefficients), self.engine_order)
        k = np.arange(Z.shape[-1])
        for theta in 2 * np.pi * np.arange(-self.steps, 1) / self.steps:
            u = (Z * np.exp(1j * k * theta)).real.sum(axis=-1)
            self.contact_force(u[:, self.modes:].ravel())
        v = (1j * k * self.omega * Z).real.sum(axis=-1)
        self.q, self.v = self.inverse @ (u + push).ravel(), self.inverse @ v.ravel()
        self.force = self.old = self.load[0] - self.onto_modes @ (self.contact_force(self.of_contact @ self.q) - self.at_rest)

    def run(self, periods):
        """Motions of the contact dofs (periods * steps + 1, N, contact dofs of a sector)."""
        seen = np.empty((periods * self.steps + 1, N, self.n - self.modes))
        for i in range(len(seen)):
            seen[i] = (self.of_contact @ self.q).reshape(N, -1)
            (a, b, c, d), (e, f, g, h) = self.to_q, self.to_v
            q, v = (x * self.q + y * self.v + z * self.force for x, y, z in ((a, b, c), (e, f, g)))
            ahead = self.of_contact @ (q + d * (self.force - self.old))  # as if it went on like that
            force = self.load[(i + 1) % self.steps] - self.onto_modes @ (self.contact_force(ahead) - self.at_rest)
            self.q, self.v = q + d * (force - self.force), v + h * (force - self.force)
            self.old, self.force = self.force, force
        return seen


def by_diameter(change):
    """Of a change of motion (instants, N, dofs): its size in each nodal diameter 0 .. N/2, (instants, N/2+1)."""
    parts = np.abs(np.fft.fft(change, axis=1)) ** 2
    parts = parts.sum(axis=2)
    return np.sqrt(np.array([parts[:, h] + (parts[:, -h] if 0 < 2 * h < N else 0) for h in range(N // 2 + 1)]).T)
